// The head of a legacy .vtk file of an unstructured grid: the same as that of a .vtu, once the file
// has been walked over.
//
//   # vtk DataFile Version 5.1
//   a title
//   ASCII                            or BINARY: numbers are big-endian
//   DATASET UNSTRUCTURED_GRID
//   POINTS 8 float
//   ...
//   CELLS 6 20                       5.0 and later: entries of OFFSETS, of CONNECTIVITY; before:
//   OFFSETS vtktypeint64             cells, and numbers in the list that follows (counted_cells.h)
//   ...
//   CONNECTIVITY vtktypeint64
//   ...
//   CELL_TYPES 5
//   ...
//   POINT_DATA 8
//   SCALARS f double ...             and the other attributes, which are active; FIELD: arrays
//
// Nothing says where a section of a text ends but its numbers: they are counted, once, when the
// file is opened, and ArrayReader keeps where every 256 KiB of them begin. In binary files sections
// follow from their counts.
//
// Arrays of bits are UInt8, a value each; COLOR_SCALARS too. Strings are read where they are field
// data, and unread where they are not. Tables of colours, information keys
// and titles are passed over.
#pragma once

#include <string_view>

#include "io/vtk/vtu_head.h"

namespace tetfusion {

// Does the text begin like a legacy file, and does it not name another data set?
bool is_legacy_grid(std::string_view text);

// Throws Error(kBadInput), naming the line or the byte. Does not leave the file's pages in memory.
// `file` must outlive the arrays of the result.
VtuHead parse_legacy_head(const MappedFile& file);

}  // namespace tetfusion
