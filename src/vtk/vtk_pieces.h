// The data sets of one file as pieces of one mesh, their points and cells counted through.
#pragma once

#include <vtkDataArray.h>
#include <vtkDataSet.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "io/source/reading_memory.h"
#include "mesh/data_array.h"
#include "mesh/geometry.h"
#include "vtk/vtk_load.h"

namespace tetfusion {

struct Piece {
  vtkSmartPointer<vtkDataSet> data;
  std::uint64_t first_point = 0;
  std::uint64_t first_cell = 0;
  bool brings_points = true;           // not those of an earlier piece
  std::span<const vtkIdType> centres;  // LoadedFile's

  std::uint64_t points() const { return static_cast<std::uint64_t>(data->GetNumberOfPoints()); }
  std::uint64_t cells() const { return static_cast<std::uint64_t>(data->GetNumberOfCells()); }
};

struct PieceList {
  std::vector<Piece> pieces;
  std::uint64_t points = 0;
  std::uint64_t cells = 0;
  ValueType point_type =
      ValueType::kFloat32;  // Float64 if any piece has it, or numbers that are no floats
};

// vtkGhostType of the cells, if there is a flag for each; and whether it drops the cell.
vtkUnsignedCharArray* ghosts_of(vtkDataSet* data);
bool is_dropped(vtkUnsignedCharArray* ghosts, vtkIdType cell);

// The point array marked as global ids, or called so: the names that io/vtk/vtu_reader.h takes,
// too.
vtkDataArray* global_id_array(vtkDataSet* data);

// Counts the points and cells of the data sets and checks the lists of cells that VTK took from the
// file on trust. The file outlives the list. Throws Error(kBadInput), or Error(kMemory) when there
// are too many points.
PieceList number_pieces(const std::string& path, const LoadedFile& file);

// Those that have rows of their own in arrays: all for cells, for points those that bring some.
std::vector<const Piece*> pieces_with_rows(const PieceList& list, Association association);

// PluginMesh's.
CellTypeCounts count_types(const LoadedFile& file);
std::uint64_t bytes_of_cells(const LoadedFile& file);

Points all_points(const PieceList& list);

// First point of each piece that brings points, and the end.
std::vector<std::uint64_t> point_begins(const PieceList& list);

// Numbers that tell which points of different pieces are the same one; empty unless all pieces have
// them.
std::vector<std::int64_t> global_point_ids(const PieceList& list);

}  // namespace tetfusion
