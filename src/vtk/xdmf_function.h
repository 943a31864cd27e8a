// Functions of finite elements, as FEniCS's checkpoints have them: values for each cell, numbered.
#pragma once

#include <vtkDataArray.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <pugixml.hpp>
#include <string>

#include "vtk/xdmf_document.h"
#include "vtk/xdmf_items.h"

namespace tetfusion {

struct XdmfFunction {
  vtkSmartPointer<vtkDataArray> values;  // of points or cells, without a name; null: not read
  bool of_points = false;
  std::string what;  // "CG 2"
};

// Linear ones on triangles and tetrahedra are values at points, constant ones values of cells;
// others are not read. Throws Error(kBadInput).
XdmfFunction read_xdmf_function(const XdmfDocument& document, pugi::xml_node attribute,
                                vtkUnstructuredGrid* grid, XdmfItems* items);

}  // namespace tetfusion
