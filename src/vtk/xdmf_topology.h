// The cells of an XDMF grid.
#pragma once

#include <vtkCellArray.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <cstdint>
#include <pugixml.hpp>

#include "vtk/xdmf_document.h"
#include "vtk/xdmf_items.h"

namespace tetfusion {

struct XdmfCells {
  vtkSmartPointer<vtkCellArray> cells;
  vtkSmartPointer<vtkUnsignedCharArray> types;  // VTK's, of each
};

// The ids of points may be any. Throws Error(kBadInput).
XdmfCells read_xdmf_cells(const XdmfDocument& document, pugi::xml_node topology, XdmfItems* items);

}  // namespace tetfusion
