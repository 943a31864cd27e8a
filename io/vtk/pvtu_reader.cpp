#include "io/vtk/pvtu_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "base/error.h"
#include "io/formats/format_file.h"
#include "io/formats/xml_text.h"
#include "io/source/cell_kinds.h"
#include "io/source/mesh_stream.h"
#include "io/vtk/listed_files.h"
#include "io/vtk/pieces_stream.h"
#include "io/vtk/vtu_cells.h"
#include "io/vtk/vtu_input.h"
#include "io/vtk/vtu_points.h"
#include "io/vtk/vtu_reader.h"
#include "io/vtk/xml_scan.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kWindow = std::uint64_t{1} << 18;

std::vector<std::string> piece_paths(const MappedFile& file, const pugi::xml_node& grid) {
  std::vector<std::string> paths;
  for (const pugi::xml_node node : grid.children("Piece")) {
    paths.push_back(listed_path(file.path(), "piece " + std::to_string(paths.size()),
                                node.attribute("Source").value()));
  }
  if (!paths.empty()) return paths;
  throw Error(ErrorCode::kBadInput, file.path() + ": no <Piece> element: the mesh is empty");
}

// Where the first piece says no units: VTK reads those that are said here, and no piece's.
void take_units(const pugi::xml_node& data, AttributeSet* set) {
  for (const pugi::xml_node array : data.children("PDataArray")) {
    const std::size_t i = set->find(legible(array.attribute("Name").value()));
    if (i != AttributeSet::npos && set->arrays[i].units.empty()) {
      set->arrays[i].units = units_of(array);
    }
  }
}

bool same_arrays(const AttributeSet& a, const AttributeSet& b) {
  return std::equal(a.arrays.begin(), a.arrays.end(), b.arrays.begin(), b.arrays.end(),
                    [](const ArrayInfo& x, const ArrayInfo& y) {
                      return x.name == y.name && x.type == y.type && x.components == y.components;
                    });
}

// Gives a file's arrays the order that those of the first one have, if they have the same names.
void put_in_order(const AttributeSet& first, AttributeSet* set, std::vector<VtuPiece>* pieces,
                  std::vector<VtuArray> VtuPiece::*arrays) {
  if (set->arrays.size() != first.arrays.size() || same_arrays(*set, first)) return;
  std::vector<std::size_t> places;
  for (const ArrayInfo& info : first.arrays) {
    const std::size_t place = set->find(info.name);
    if (place == AttributeSet::npos || std::count(places.begin(), places.end(), place) > 0) return;
    places.push_back(place);
  }
  const auto reorder = [&](auto* all) {
    if (all->empty()) return;  // of an empty piece
    auto ordered = *all;
    for (std::size_t i = 0; i < places.size(); ++i) ordered[i] = (*all)[places[i]];
    *all = std::move(ordered);
  };
  reorder(&set->arrays);
  for (VtuPiece& piece : *pieces) reorder(&(piece.*arrays));
}

class PvtuSource final : public MeshSource {
 public:
  PvtuSource(const std::string& path, const OpenOptions& options) : options_(options) {
    description_.path = path;
    description_.format = "VTK XML unstructured grid in several files";
    description_.pieces = 0;
  }

  // False where the piece does not go with the others, or where all cannot be read in windows.
  bool add(const std::string& path);
  bool finish(std::uint64_t bytes, const pugi::xml_node& grid);
  const std::string& obstacle() const { return obstacle_; }  // after that: "a .pvtu ..."

  const MeshDescription& description() const override { return description_; }
  std::unique_ptr<MeshStream> stream() override;
  Geometry read_geometry() override;
  DataArray read_array(Association association, std::size_t index) override;

 private:
  bool merge(const AttributeSet& from, bool* seen, AttributeSet* to);
  bool has_cells_to_split() const;
  const MeshStream& own_stream();

  OpenOptions options_;
  MeshDescription description_;
  std::vector<std::unique_ptr<VtuInput>> inputs_;
  std::vector<StreamPiece> pieces_;
  std::unique_ptr<MeshStream> stream_;
  std::string obstacle_;
  std::string first_with_cells_;  // whose field data counts
  bool has_points_ = false;
  bool has_cells_ = false;
};

bool PvtuSource::add(const std::string& path) {
  MappedFile mapped = MappedFile::open(path);
  const std::string_view text(reinterpret_cast<const char*>(mapped.bytes().data()), mapped.size());
  if (vtk_file_type(text) != "UnstructuredGrid") {
    obstacle_ = "a .pvtu of pieces that are no .vtu files";
    return false;
  }
  inputs_.push_back(std::make_unique<VtuInput>(VtuInput{std::move(mapped), {}}));
  VtuInput& input = *inputs_.back();
  input.guarded([&] { input.head = parse_vtu_head(input.file); });
  MeshDescription& d = description_;
  VtuHead& head = input.head;
  if (has_points_) {
    put_in_order(d.point_data, &head.point_data, &head.pieces, &VtuPiece::point_data);
  }
  if (has_cells_) put_in_order(d.cell_data, &head.cell_data, &head.pieces, &VtuPiece::cell_data);
  for (std::size_t p = 0; p < input.head.pieces.size(); ++p) {
    const VtuPiece& piece = input.head.pieces[p];
    if (piece.has_faces && options_.tetrahedralize) {
      obstacle_ = "a .pvtu with polyhedra";
      return false;
    }
    if (piece.points > 0 && piece.coordinates.present) {
      const ValueType type = point_type_for(piece.coordinates.info.type);
      if (!has_points_ || type == ValueType::kFloat64) d.point_type = type;
      if (!merge(input.head.point_data, &has_points_, &d.point_data)) return false;
    }
    if (piece.cells > 0 && !merge(input.head.cell_data, &has_cells_, &d.cell_data)) return false;
    pieces_.push_back({&input, p});
    d.points += piece.points;
    d.cells += piece.cells;
  }
  if (d.unread.empty()) d.unread = input.head.unread;
  d.pieces += input.head.pieces.size();
  d.file_bytes += input.file.size();
  d.files.push_back(path);
  if (first_with_cells_.empty() && d.cells > 0) first_with_cells_ = path;
  return true;
}

bool PvtuSource::merge(const AttributeSet& from, bool* seen, AttributeSet* to) {
  if (*seen && same_arrays(from, *to)) return true;
  if (*seen) {
    obstacle_ = "a .pvtu whose pieces have other arrays than the first one";
    return false;
  }
  *seen = true;
  *to = from;
  return true;
}

// Or straightened: where they may be, or opening the piece would have failed.
bool PvtuSource::has_cells_to_split() const {
  const OpenOptions as_they_are{.drop_patches = options_.drop_patches};
  for (const auto& input : inputs_) {
    CellTypeCounts counts{};
    input->guarded([&] { counts = count_types(*input); });
    for (std::size_t type = 0; type < counts.size(); ++type) {
      if (counts[type] > 0 && kept_vertices(static_cast<std::uint8_t>(type), as_they_are) < 0)
        return true;
    }
  }
  return false;
}

bool PvtuSource::finish(std::uint64_t bytes, const pugi::xml_node& grid) {
  MeshDescription& d = description_;
  if (d.cells == 0) throw Error(ErrorCode::kBadInput, d.path + ": the mesh has no cells");
  d.joins_points = d.pieces > 1 || options_.merge_points;
  d.file_bytes += bytes;
  for (ArrayInfo& info : d.point_data.arrays) info.tuples = d.points;
  for (ArrayInfo& info : d.cell_data.arrays) info.tuples = d.cells;
  take_units(grid.child("PPointData"), &d.point_data);
  take_units(grid.child("PCellData"), &d.cell_data);
  d.field_data = open_vtu(MappedFile::open(first_with_cells_), options_)->description().field_data;
  stream_ = open_pieces_stream(pieces_, description_, options_);
  if (stream_ != nullptr) return true;
  obstacle_ = has_cells_to_split()
                  ? "a .pvtu with cells to split or straighten"
                  : "a .pvtu with large compressed blocks, or with a piece of cells without points";
  return false;
}

// The first one was made when the file was opened, to see whether it can be.
std::unique_ptr<MeshStream> PvtuSource::stream() {
  if (stream_) return std::move(stream_);
  return open_pieces_stream(pieces_, description_, options_);
}

// Of its own, where the first one is another's.
const MeshStream& PvtuSource::own_stream() {
  if (!stream_) stream_ = open_pieces_stream(pieces_, description_, options_);
  return *stream_;
}

template <class Real>
void take_points(const MeshStream& stream, Geometry* mesh) {
  Vector<Vec3<Real>> points(stream.points());
  stream.read_points(0, points.size(), std::as_writable_bytes(std::span(points)));
  mesh->points = std::move(points);
}

Geometry PvtuSource::read_geometry() {
  const MeshStream& stream = own_stream();
  Geometry mesh;
  if (description_.point_type == ValueType::kFloat32) {
    take_points<float>(stream, &mesh);
  } else {
    take_points<double>(stream, &mesh);
  }
  CellWindow window;
  for (std::uint64_t first = 0; first < stream.cells(); first += kWindow) {
    stream.read_cells(first, std::min(kWindow, stream.cells() - first), &window);
    mesh.tets.insert(mesh.tets.end(), window.tets.begin(), window.tets.end());
    for (std::size_t t = 0; t < window.tets.size(); ++t) {
      mesh.tet_source.push_back(window.tet_rows.empty() ? first + t : window.tet_rows[t]);
    }
    mesh.lower.add(window.lower);
    mesh.lower_source.insert(mesh.lower_source.end(), window.lower_rows.begin(),
                             window.lower_rows.end());
  }
  mesh.unused_points = stream.dropped_points();
  mesh.merged_points = stream.merged_points();
  mesh.differing_points = stream.differing_points();
  mesh.largest_difference = stream.largest_difference();
  mesh.ghost_cells = stream.ghost_cells();
  return mesh;
}

// Point arrays by the numbers of the merged points, which are read_geometry()'s.
DataArray PvtuSource::read_array(Association association, std::size_t index) {
  if (association == Association::kField) {
    return open_vtu(MappedFile::open(first_with_cells_), options_)->read_array(association, index);
  }
  const bool of_points = association == Association::kPoint;
  const MeshStream& stream = own_stream();
  DataArray array;
  array.info = (of_points ? description_.point_data : description_.cell_data).arrays.at(index);
  array.info.tuples = of_points ? stream.points() : stream.cells();
  array.bytes.resize(array.info.bytes());
  stream.read_rows(association, index, 0, array.info.tuples, array.bytes);
  return array;
}

}  // namespace

std::vector<std::string> pieces_of_pvtu(const MappedFile& file) {
  const pugi::xml_document list = parse_list(file);
  return piece_paths(file, list.child("VTKFile").child("PUnstructuredGrid"));
}

std::unique_ptr<MeshSource> open_pvtu(const MappedFile& file, const OpenOptions& options,
                                      std::string* why) {
  const pugi::xml_document list = parse_list(file);
  const pugi::xml_node grid = list.child("VTKFile").child("PUnstructuredGrid");
  const std::vector<std::string> paths = piece_paths(file, grid);
  if (paths.size() > kMaxPiecesRead) {
    *why = fmt::format("a .pvtu of more than {} pieces", kMaxPiecesRead);
    return nullptr;
  }
  auto source = std::make_unique<PvtuSource>(file.path(), options);
  bool can_read = true;
  for (std::size_t p = 0; p < paths.size() && can_read; ++p) can_read = source->add(paths[p]);
  if (can_read && source->finish(file.size(), grid)) return source;
  *why = source->obstacle();
  return nullptr;
}

}  // namespace tetfusion
