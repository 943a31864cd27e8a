#include "vtk/xdmf_topology.h"

#include <vtkCellType.h>
#include <vtkNew.h>
#include <vtkTypeInt32Array.h>
#include <vtkTypeInt64Array.h>

#include <algorithm>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>

#include "base/numbers.h"
#include "io/formats/text_tokens.h"
#include "vtk/number_types.h"

namespace tetfusion {
namespace {

struct CellKind {
  std::string_view name, short_name;
  std::int64_t number;  // among mixed cells; 0: none
  std::uint64_t nodes;  // 0: a count says how many
  int vtk;
};

// Corners come first in all of them, as in VTK's.
constexpr CellKind kCellKinds[] = {
    {"Polyvertex", "", 0x1, 0, VTK_POLY_VERTEX},
    {"Polyline", "", 0x2, 0, VTK_POLY_LINE},
    {"Polygon", "", 0x3, 0, VTK_POLYGON},
    {"Triangle", "Tri", 0x4, 3, VTK_TRIANGLE},
    {"Quadrilateral", "Quad", 0x5, 4, VTK_QUAD},
    {"Tetrahedron", "Tet", 0x6, 4, VTK_TETRA},
    {"Pyramid", "", 0x7, 5, VTK_PYRAMID},
    {"Wedge", "", 0x8, 6, VTK_WEDGE},
    {"Hexahedron", "Hex", 0x9, 8, VTK_HEXAHEDRON},
    {"Edge_3", "", 0x22, 3, VTK_QUADRATIC_EDGE},
    {"Quadrilateral_9", "Quad_9", 0x23, 9, VTK_BIQUADRATIC_QUAD},
    {"Triangle_6", "Tri_6", 0x24, 6, VTK_QUADRATIC_TRIANGLE},
    {"Quadrilateral_8", "Quad_8", 0x25, 8, VTK_QUADRATIC_QUAD},
    {"Tetrahedron_10", "Tet_10", 0x26, 10, VTK_QUADRATIC_TETRA},
    {"Pyramid_13", "", 0x27, 13, VTK_QUADRATIC_PYRAMID},
    {"Wedge_15", "", 0x28, 15, VTK_QUADRATIC_WEDGE},
    {"Wedge_18", "", 0x29, 18, VTK_BIQUADRATIC_QUADRATIC_WEDGE},
    {"Hexahedron_20", "Hex_20", 0x30, 20, VTK_QUADRATIC_HEXAHEDRON},
    {"Hexahedron_24", "Hex_24", 0x31, 24, VTK_BIQUADRATIC_QUADRATIC_HEXAHEDRON},
    {"Hexahedron_27", "Hex_27", 0x32, 27, VTK_TRIQUADRATIC_HEXAHEDRON},
    // As FEniCSx writes them.
    {"Triangle_10", "", 0, 10, VTK_LAGRANGE_TRIANGLE},
    {"Tetrahedron_20", "", 0, 20, VTK_LAGRANGE_TETRAHEDRON},
};

// Cells of a count of nodes that have a type of their own where there are few.
int type_of(const CellKind& kind, std::uint64_t nodes) {
  if (kind.vtk == VTK_POLY_VERTEX && nodes == 1) return VTK_VERTEX;
  if (kind.vtk == VTK_POLY_LINE && nodes == 2) return VTK_LINE;
  if (kind.vtk == VTK_POLYGON && nodes == 3) return VTK_TRIANGLE;
  return kind.vtk;
}

class TopologyReader {
 public:
  TopologyReader(const XdmfDocument& document, pugi::xml_node topology, XdmfItems* items)
      : document_(document),
        topology_(topology),
        items_(items),
        name_(xdmf_attribute(topology, {"TopologyType", "Type"})),
        offset_(number("BaseOffset").value_or(0)),
        cells_said_(product("NumberOfElements", "Dimensions")) {}

  XdmfCells read() {
    refuse_what_is_no_cells();
    if (is_xdmf_word(name_, "Mixed")) return read_mixed();
    const auto kind =
        std::find_if(std::begin(kCellKinds), std::end(kCellKinds), [&](const CellKind& candidate) {
          return is_xdmf_word(name_, candidate.name) || is_xdmf_word(name_, candidate.short_name);
        });
    if (kind == std::end(kCellKinds)) {
      fail("is of type " + name_ + ", which is not read: let ParaView save the file as .vtu");
    }
    return read_alike(*kind);
  }

 private:
  void refuse_what_is_no_cells() {
    if (name_.empty()) fail("says no TopologyType");
    for (const char* const grid : {"SMesh", "RectMesh"}) {
      for (const char* const rank : {"2D", "3D"}) {
        for (const char* const co : {"", "Co"}) {
          if (!is_xdmf_word(name_, std::string(rank) + co + grid)) continue;
          fail("is a structured grid (" + name_ +
               "), which is not read from XDMF: let ParaView save it as .vts or .vti");
        }
      }
    }
    if (is_xdmf_word(name_, "Polyhedron")) {
      fail("is of polyhedra, which are not read from XDMF: let ParaView save it as .vtu");
    }
  }

  std::uint64_t nodes_of(const CellKind& kind) const {
    const auto said = number("NodesPerElement");
    if (kind.nodes > 0) {
      if (said && static_cast<std::uint64_t>(*said) != kind.nodes) {
        fail("says NodesPerElement " + std::to_string(*said) + ", and a " + name_ + " has " +
             std::to_string(kind.nodes));
      }
      return kind.nodes;
    }
    if (said && *said > 0) return static_cast<std::uint64_t>(*said);
    if (kind.vtk == VTK_POLYGON) fail("is of polygons, and says no NodesPerElement");
    return kind.vtk == VTK_POLY_LINE ? 2 : 1;
  }

  XdmfCells read_alike(const CellKind& kind) {
    const std::uint64_t nodes = nodes_of(kind);
    check_order(nodes);
    const auto ids = as_ids(ids_of(kind, nodes));
    const auto count = static_cast<std::uint64_t>(ids->GetNumberOfTuples());
    if (count % nodes != 0 || (cells_said_ && *cells_said_ != count / nodes)) {
      fail("has " + std::to_string(count) + " ids of points, and " +
           (cells_said_ ? std::to_string(*cells_said_) + " cells of " : "each cell has ") +
           std::to_string(nodes));
    }
    XdmfCells out;
    out.cells = vtkSmartPointer<vtkCellArray>::New();
    out.cells->SetData(static_cast<vtkIdType>(nodes), ids);
    out.types = vtkSmartPointer<vtkUnsignedCharArray>::New();
    out.types->SetNumberOfTuples(static_cast<vtkIdType>(count / nodes));
    out.types->FillValue(static_cast<unsigned char>(type_of(kind, nodes)));
    return out;
  }

  // Where vertices have no list they are all points, one after another.
  vtkSmartPointer<vtkDataArray> ids_of(const CellKind& kind, std::uint64_t nodes) {
    const pugi::xml_node item = document_.child(topology_, "DataItem");
    if (item) return items_->read(item);
    const auto count = value_count({cells_said_.value_or(0), nodes});
    constexpr std::uint64_t kMost = std::uint64_t{1} << 40;
    if (kind.vtk != VTK_POLY_VERTEX || !count || *count > kMost) {
      fail("has no DataItem with the points of its cells");
    }
    auto ids = new_numbers(VTK_TYPE_INT64, *count);
    for (std::uint64_t i = 0; i < *count; ++i) {
      numbers_of<std::int64_t>(ids)[i] = static_cast<std::int64_t>(i) + offset_;
    }
    return ids;
  }

  // Ids that count from 0, in one of the classes that VTK's cells are made of. PyLith's may be
  // floating-point numbers. What cannot be an id is -1, which is refused as all ids out of range
  // are.
  vtkSmartPointer<vtkDataArray> as_ids(vtkDataArray* array) const {
    vtkSmartPointer<vtkDataArray> ids;
    const int type = array->GetDataType();
    if (type == VTK_TYPE_INT32 && offset_ == 0) {
      ids = vtkSmartPointer<vtkTypeInt32Array>::New();
    } else {
      ids = vtkSmartPointer<vtkTypeInt64Array>::New();
    }
    if (offset_ == 0 && (type == VTK_TYPE_INT32 || type == VTK_TYPE_INT64)) {
      ids->ShallowCopy(array);
      return ids;
    }
    ids->SetNumberOfTuples(array->GetNumberOfTuples());
    auto* const to = numbers_of<std::int64_t>(ids);
    with_number_type(type, [&](auto zero) {
      const auto* const from = numbers_of<decltype(zero)>(array);
      for (vtkIdType i = 0; i < array->GetNumberOfTuples(); ++i) {
        to[i] = whole_number(from[i]) - offset_;
      }
    });
    return ids;
  }

  XdmfCells read_mixed() {
    const pugi::xml_node item = document_.child(topology_, "DataItem");
    if (!item) fail("has no DataItem with the points of its cells");
    const vtkSmartPointer<vtkDataArray> stream = items_->read(item);
    const auto length = static_cast<std::uint64_t>(stream->GetNumberOfTuples());
    vtkNew<vtkTypeInt64Array> ids, offsets;
    XdmfCells out;
    out.types = vtkSmartPointer<vtkUnsignedCharArray>::New();
    offsets->InsertNextValue(0);
    with_number_type(stream->GetDataType(), [&](auto zero) {
      const auto* const from = numbers_of<decltype(zero)>(stream);
      for (std::uint64_t at = 0; at < length;) {
        const CellKind& kind = kind_of(whole_number(from[at++]), out.types->GetNumberOfTuples());
        std::uint64_t nodes = kind.nodes;
        if (nodes == 0 && at < length) nodes = static_cast<std::uint64_t>(whole_number(from[at++]));
        if (nodes == 0 || nodes > length - at) {
          fail("ends in cell " + std::to_string(out.types->GetNumberOfTuples()) +
               ", or has a wrong count of points there");
        }
        for (const std::uint64_t end = at + nodes; at < end; ++at) {
          ids->InsertNextValue(whole_number(from[at]) - offset_);
        }
        offsets->InsertNextValue(ids->GetNumberOfTuples());
        out.types->InsertNextValue(static_cast<unsigned char>(type_of(kind, nodes)));
      }
    });
    const auto found = static_cast<std::uint64_t>(out.types->GetNumberOfTuples());
    if (cells_said_ && *cells_said_ != found) {
      fail("says that there are " + std::to_string(*cells_said_) + " cells, and has " +
           std::to_string(found));
    }
    out.cells = vtkSmartPointer<vtkCellArray>::New();
    out.cells->SetData(offsets, ids);
    return out;
  }

  const CellKind& kind_of(std::int64_t number, vtkIdType cell) const {
    const auto* const kind =
        std::find_if(std::begin(kCellKinds), std::end(kCellKinds),
                     [&](const CellKind& candidate) { return candidate.number == number; });
    if (number > 0 && kind != std::end(kCellKinds)) return *kind;
    fail("has cell " + std::to_string(cell) + " of type " + std::to_string(number) +
         (number == 0x10
              ? ", a polyhedron, which is not read from XDMF: let ParaView save it as .vtu"
              : ", which XDMF does not know, or which is not read"));
  }

  void check_order(std::uint64_t nodes) const {
    const std::string order = xdmf_attribute(topology_, {"Order"});
    TokenCursor cursor(order, 0);
    for (std::uint64_t i = 0; i < nodes; ++i) {
      const std::string_view token = cursor.next();
      if (i == 0 && token.empty()) return;
      if (token != std::to_string(i)) {
        fail("lists the points of a cell in an order of its own (" + order +
             "), which is not read: let ParaView save the file as .vtu");
      }
    }
  }

  std::optional<std::int64_t> number(std::string_view name) const {
    const std::string text = xdmf_attribute(topology_, {name});
    if (text.empty()) return {};
    const auto value = number_in<std::int64_t>(text);
    if (!value || *value < 0) {
      fail("says " + std::string(name) + " '" + text + "', which is no count");
    }
    return value;
  }

  // Some say them in rows and columns.
  std::optional<std::uint64_t> product(std::string_view name, std::string_view other) const {
    const std::string text = xdmf_attribute(topology_, {name, other});
    Dimensions counts;
    TokenCursor cursor(text, 0);
    for (std::string_view token = cursor.next(); !token.empty(); token = cursor.next()) {
      const auto value = number_in<std::uint64_t>(token);
      if (!value) return {};
      counts.push_back(*value);
    }
    return counts.empty() ? std::nullopt : value_count(counts);
  }

  [[noreturn]] void fail(const std::string& what) const { document_.fail(topology_, what); }

  const XdmfDocument& document_;
  pugi::xml_node topology_;
  XdmfItems* items_;
  std::string name_;
  std::int64_t offset_;
  std::optional<std::uint64_t> cells_said_;
};

}  // namespace

XdmfCells read_xdmf_cells(const XdmfDocument& document, pugi::xml_node topology, XdmfItems* items) {
  return TopologyReader(document, topology, items).read();
}

}  // namespace tetfusion
