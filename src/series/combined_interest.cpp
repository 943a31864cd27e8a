#include "series/combined_interest.h"

#include <fmt/format.h>

#include <span>

#include "io/source/stream_windows.h"
#include "mesh/regions/region_of_interest.h"

namespace tetfusion {

namespace {

constexpr const char* kName = "in a region of interest";

}  // namespace

CombinedInterest::CombinedInterest(const std::vector<std::string>& texts,
                                   const MeshDescription& first, std::uint64_t points)
    : inside_(points) {
  // What is wrong with them is said before steps are read.
  static_cast<void>(RegionOfInterest(texts, first.path, first.point_data));
  for (const std::string& text : texts) {
    (RegionOfInterest::is_by_values(text) ? by_values_ : by_place_).push_back(text);
  }
}

void CombinedInterest::add(const MeshDescription& mesh, const MeshStream& stream,
                           const RunContext& context) {
  if (empty()) return;
  const RegionOfInterest interest(by_values_, mesh.path, mesh.point_data);
  Vector<std::uint8_t> inside;
  for_each_window(inside_.points(), context, [&](std::uint64_t first, std::uint64_t count) {
    inside.assign(count, 0);
    const auto read = [&](std::size_t array, std::span<std::byte> rows) {
      stream.read_rows(Association::kPoint, array, first, count, rows);
    };
    interest.mark_by_values(count, read, inside.data());
    const std::lock_guard lock(mutex_);
    for (std::uint64_t i = 0; i < count; ++i) {
      if (inside[i] != 0) inside_.add(first + i);
    }
  });
}

std::vector<std::string> CombinedInterest::texts() const {
  std::vector<std::string> texts = by_place_;
  if (!empty()) texts.push_back(fmt::format("{}>0", kName));
  return texts;
}

ArrayFrom CombinedInterest::array() const {
  const auto read = [this](const MeshStream&, std::uint64_t first, std::span<std::byte> out) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = static_cast<std::byte>(inside_.has(first + i));
    }
  };
  return {{kName, ValueType::kUInt8, 1, {}, inside_.points(), true}, read};
}

}  // namespace tetfusion
