// Pieces as text, for tests of what keeps them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/store/piece_store.h"

namespace tetfusion::testing {

struct PieceText {
  std::uint32_t bucket;
  std::string text;
};

inline std::string text(std::span<const std::byte> bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

inline void add_pieces(PieceStore* store, std::uint32_t source,
                       const std::vector<PieceText>& pieces) {
  std::vector<PieceRef> refs;
  for (const PieceText& piece : pieces) {
    refs.push_back({piece.bucket, std::as_bytes(std::span(piece.text))});
  }
  store->add(source, refs);
}

inline std::vector<std::string> pieces_in(const PieceStore& store, std::uint32_t bucket) {
  std::vector<std::string> texts;
  const auto pieces = store.read(bucket);
  for (const auto piece : pieces->pieces()) texts.push_back(text(piece));
  return texts;
}

}  // namespace tetfusion::testing
