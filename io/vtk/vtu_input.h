// An open .vtu file, or a legacy .vtk of an unstructured grid: its bytes and what its head says
// about them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

#include "base/error.h"
#include "io/files/guarded_reading.h"
#include "io/files/mapped_file.h"
#include "io/vtk/array_reader.h"
#include "io/vtk/vtu_head.h"

namespace tetfusion {

struct VtuInput {
  MappedFile file;
  VtuHead head;

  // " of piece 2", or nothing when there is one piece only.
  std::string of_piece(std::size_t piece) const {
    return head.pieces.size() > 1 ? " of piece " + std::to_string(piece) : "";
  }

  [[noreturn]] void fail(ErrorCode code, const std::string& what) const {
    throw Error(code, file.path() + ": " + what);
  }

  template <class F>
  void guarded(F f) const {
    read_guarded(file, std::move(f));
  }

  // A reader for one of the head's arrays; `label` names it in messages. Throws Error(kBadInput).
  ArrayReader open(const VtuArray& array, std::string label) const {
    const std::uint64_t values = array.counted ? array.info.values() : ArraySource::kUnknown;
    return ArrayReader({&file, std::move(label), array.payload, head.layout, array.info.type,
                        values, array.computed});
  }
};

}  // namespace tetfusion
