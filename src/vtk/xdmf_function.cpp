#include "vtk/xdmf_function.h"

#include <vtkIdList.h>
#include <vtkNew.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "vtk/number_types.h"

namespace tetfusion {
namespace {

// How many nodes each cell has, all as many; 0 where they differ or there are no cells.
std::uint64_t nodes_of_each_cell(vtkUnstructuredGrid* grid) {
  vtkCellArray* const cells = grid->GetCells();
  const vtkIdType nodes = cells->IsHomogeneous();
  return nodes > 0 ? static_cast<std::uint64_t>(nodes) : 0;
}

}  // namespace

// Of each cell first all its nodes' numbers for the first component, then those for the next.
XdmfFunction read_xdmf_function(const XdmfDocument& document, pugi::xml_node attribute,
                                vtkUnstructuredGrid* grid, XdmfItems* items) {
  const std::string family = xdmf_attribute(attribute, {"ElementFamily"});
  const std::string degree = xdmf_attribute(attribute, {"ElementDegree"});
  const std::string cell = xdmf_attribute(attribute, {"ElementCell"});
  XdmfFunction out;
  out.what = family + " " + degree;
  const bool is_simplex = is_xdmf_word(cell, "tetrahedron") || is_xdmf_word(cell, "triangle");
  const bool is_linear = is_xdmf_word(family, "CG") && degree == "1" && is_simplex;
  const bool is_constant =
      degree == "0" && (is_xdmf_word(family, "DG") || is_xdmf_word(family, "DQ"));
  const std::uint64_t nodes = is_constant ? 1 : nodes_of_each_cell(grid);
  const auto cells = static_cast<std::uint64_t>(grid->GetNumberOfCells());
  if (!(is_linear || is_constant) || cells == 0 || nodes == 0) return out;
  const std::vector<pugi::xml_node> lists = document.children(attribute, "DataItem");
  if (lists.size() < 2) document.fail(attribute, "has no list of numbers, or no values");
  const vtkSmartPointer<vtkDataArray> numbers = items->read(lists[0]);
  const vtkSmartPointer<vtkDataArray> values = items->read(lists[1]);
  const auto length = static_cast<std::uint64_t>(numbers->GetNumberOfTuples());
  const auto known = static_cast<std::uint64_t>(values->GetNumberOfTuples());
  if (length == 0 || length % (cells * nodes) != 0) {
    document.fail(attribute, "has " + std::to_string(length) + " numbers of values for " +
                                 std::to_string(cells) + " cells");
  }
  const std::uint64_t width = length / (cells * nodes);
  std::vector<std::uint64_t> number_of(length);
  with_number_type(numbers->GetDataType(), [&](auto zero) {
    const auto* const from = numbers_of<decltype(zero)>(numbers);
    for (std::uint64_t i = 0; i < length; ++i) {
      const std::int64_t id = whole_number(from[i]);
      if (id < 0 || static_cast<std::uint64_t>(id) >= known) {
        document.fail(attribute,
                      "wants value " + std::to_string(id) + " of " + std::to_string(known));
      }
      number_of[i] = static_cast<std::uint64_t>(id);
    }
  });
  out.of_points = is_linear;
  const auto rows = is_linear ? static_cast<std::uint64_t>(grid->GetNumberOfPoints()) : cells;
  out.values = new_numbers(values->GetDataType(), rows * width);
  with_number_type(values->GetDataType(), [&](auto zero) {
    using Value = decltype(zero);
    const auto* const from = numbers_of<Value>(values);
    auto* const to = numbers_of<Value>(out.values);
    std::fill_n(to, rows * width, std::numeric_limits<Value>::quiet_NaN());
    vtkNew<vtkIdList> corners;
    const std::uint64_t* number = number_of.data();
    for (std::uint64_t c = 0; c < cells; ++c) {
      if (is_linear) grid->GetCellPoints(static_cast<vtkIdType>(c), corners);
      for (std::uint64_t k = 0; k < width; ++k) {
        for (std::uint64_t node = 0; node < nodes; ++node, ++number) {
          const std::uint64_t row =
              is_linear ? static_cast<std::uint64_t>(corners->GetId(static_cast<vtkIdType>(node)))
                        : c;
          if (row < rows) to[row * width + k] = from[*number];  // else the cell is refused later
        }
      }
    }
  });
  return out;
}

}  // namespace tetfusion
