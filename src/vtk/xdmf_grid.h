// Uniform grids of an XDMF file as VTK's data sets.
#pragma once

#include <vtkDataSetAttributes.h>
#include <vtkFieldData.h>
#include <vtkPoints.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <cstddef>
#include <map>
#include <pugixml.hpp>
#include <set>
#include <string>
#include <vector>

#include "vtk/xdmf_document.h"
#include "vtk/xdmf_items.h"
#include "vtk/xdmf_topology.h"

namespace tetfusion {

struct XdmfBlock {
  std::size_t place = 0;  // among the grids
  std::string name;
  vtkSmartPointer<vtkUnstructuredGrid> grid;
  vtkSmartPointer<vtkUnsignedCharArray> types;
};

// The document and the items outlive it.
class XdmfGrids {
 public:
  XdmfGrids(const XdmfDocument& document, XdmfItems* items) : document_(document), items_(items) {}

  // Reads its points and cells. Throws Error(kBadInput).
  void add(pugi::xml_node grid, const std::string& name);

  // Reads arrays that a collection of grids has itself. Throws Error(kBadInput).
  void add_own_arrays(pugi::xml_node collection);

  // Each grid, in their order; but one that has the same points and cells as another one, or some
  // of its cells, gives that one its arrays, as where each function and all tags of a mesh are
  // grids. Reads the arrays. To be called once. Throws Error(kBadInput).
  std::vector<XdmfBlock> blocks();

  vtkFieldData* field_data() const { return field_data_; }
  const std::vector<std::string>& left_out() const { return left_out_; }

 private:
  struct Grid {
    pugi::xml_node node;
    std::string name;
    vtkSmartPointer<vtkPoints> points;
    const XdmfCells* cells = nullptr;
  };
  // Whose arrays are read.
  struct Target {
    vtkUnstructuredGrid* grid = nullptr;  // none: those of a collection
    vtkIdType cells = 0;                  // as many rows there are
    std::vector<vtkIdType> cell_of;       // of the grid, for each row; empty: the same
  };

  vtkSmartPointer<vtkPoints> points_of(pugi::xml_node grid);
  vtkSmartPointer<vtkDataArray> coordinates_of(pugi::xml_node geometry);
  const XdmfCells& cells_of(pugi::xml_node grid);
  void place(std::size_t grid, std::vector<XdmfBlock>* blocks);
  void add_arrays(pugi::xml_node grid, const Target& target);
  void add_array(pugi::xml_node attribute, const Target& target);
  void add_function(pugi::xml_node attribute, const std::string& name, vtkUnstructuredGrid* grid);
  void add_point_rows(pugi::xml_node attribute, vtkUnstructuredGrid* grid, vtkDataArray* array);
  void add_cell_rows(pugi::xml_node attribute, const Target& target,
                     vtkSmartPointer<vtkDataArray> array);
  void keep_rows(pugi::xml_node attribute, vtkDataSetAttributes* data, vtkDataArray* array);
  void keep(vtkFieldData* data, vtkDataArray* array, const std::string& what);
  void leave_out(const std::string& what);
  std::string key_of(pugi::xml_node node) const;

  const XdmfDocument& document_;
  XdmfItems* items_;
  std::vector<Grid> grids_;
  std::map<std::string, vtkSmartPointer<vtkPoints>> points_;
  std::map<std::string, XdmfCells> cells_;
  vtkSmartPointer<vtkFieldData> field_data_ = vtkSmartPointer<vtkFieldData>::New();
  std::vector<std::string> left_out_;
  std::set<std::string> told_;
};

}  // namespace tetfusion
