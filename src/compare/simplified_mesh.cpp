#include "compare/simplified_mesh.h"

#include <fmt/format.h>

#include <utility>
#include <vector>

#include "base/blocks.h"
#include "base/error.h"
#include "base/sums.h"
#include "compare/face_match.h"
#include "compare/hilbert_curve.h"
#include "compare/sorted_by_key.h"
#include "mesh/faces.h"
#include "mesh/predicates.h"

namespace tetfusion {

namespace {

constexpr std::size_t kItemsPerBlock = 8192;
constexpr std::size_t kMostSides = std::size_t{1} << 21;

class Loader {
 public:
  explicit Loader(MeshSource* source) : source_(source) {}

  SimplifiedMesh run(const FieldSet& point_fields, const FieldSet& cell_fields) {
    geometry_ = source_->read_geometry();
    take_points();
    order_tets();
    number_points();
    wind();
    link();
    find_parts();
    take_boundary();
    geometry_.tets = {};
    geometry_.points = {};
    read_rows(Association::kPoint, point_fields, rows_of(geometry_.point_source, points_),
              &mesh_.point_rows);
    for_each_block(mesh_.points.size(), kItemsPerBlock,
                   [&](std::size_t, std::size_t begin, std::size_t end) {
                     fill_lengths(point_fields, end - begin,
                                  mesh_.point_rows.data() + begin * point_fields.width);
                   });
    read_rows(Association::kCell, cell_fields, rows_of(geometry_.tet_source, tets_),
              &mesh_.cell_rows);
    mesh_.point_ids = std::move(points_);
    mesh_.tet_ids = std::move(tets_);
    return std::move(mesh_);
  }

 private:
  void take_points() {
    all_points_.resize(point_count(geometry_.points));
    std::visit(
        [&](const auto& points) {
          for (std::size_t i = 0; i < points.size(); ++i) {
            all_points_[i] = {points[i].x, points[i].y, points[i].z};
          }
        },
        geometry_.points);
    const Vector<Tet>& tets = geometry_.tets;
    std::vector<PointBox> boxes(block_count(tets.size(), kItemsPerBlock));
    for_each_block(tets.size(), kItemsPerBlock,
                   [&](std::size_t b, std::size_t begin, std::size_t end) {
                     PointBox box;
                     for (std::size_t t = begin; t < end; ++t) {
                       for (const VertexId v : tets[t]) box.add(all_points_[v]);
                     }
                     boxes[b] = box;
                   });
    for (const PointBox& box : boxes) mesh_.box.add(box);
  }

  void order_tets() {
    const Vector<Tet>& tets = geometry_.tets;
    const HilbertCurve curve(mesh_.box);
    Vector<std::uint32_t> keys(tets.size());
    for_each_block(tets.size(), kItemsPerBlock,
                   [&](std::size_t, std::size_t begin, std::size_t end) {
                     for (std::size_t t = begin; t < end; ++t) {
                       const Point pair = all_points_[tets[t][0]] + all_points_[tets[t][1]];
                       const Point other = all_points_[tets[t][2]] + all_points_[tets[t][3]];
                       keys[t] = curve.key(0.25 * (pair + other));
                     }
                   });
    tets_ = sorted_by_key(keys, curve.key_bits());
    mesh_.tets.resize(tets.size());
    for_each_block(tets.size(), kItemsPerBlock,
                   [&](std::size_t, std::size_t begin, std::size_t end) {
                     for (std::size_t t = begin; t < end; ++t) mesh_.tets[t] = tets[tets_[t]];
                   });
  }

  // In the order in which tetrahedra use them.
  void number_points() {
    Vector<VertexId> number;
    number.assign(all_points_.size(), kNoVertex);
    for (Tet& t : mesh_.tets) {
      for (VertexId& v : t) {
        if (number[v] == kNoVertex) {
          number[v] = static_cast<VertexId>(points_.size());
          points_.push_back(v);
          mesh_.points.push_back(all_points_[v]);
        }
        v = number[v];
      }
    }
    all_points_ = {};
  }

  void wind() {
    mesh_.flat.resize(mesh_.tets.size());
    Vector<CompensatedSum> sums(block_count(mesh_.tets.size(), kItemsPerBlock));
    Vector<CompensatedSum> errors(sums.size());
    for_each_block(mesh_.tets.size(), kItemsPerBlock,
                   [&](std::size_t b, std::size_t begin, std::size_t end) {
                     for (std::size_t t = begin; t < end; ++t) {
                       Tet& tet = mesh_.tets[t];
                       const Determinant d = determinant(mesh_.points, tet);
                       mesh_.flat[t] = d.sign() == 0 ? 1 : 0;
                       if (d.value < 0) std::swap(tet[0], tet[1]);
                       sums[b].add(std::abs(d.value) / 6);
                       errors[b].add(d.error / 6);
                     }
                   });
    CompensatedSum volume, error;
    for (const CompensatedSum& sum : sums) volume.add(sum);
    for (const CompensatedSum& sum : errors) error.add(sum);
    mesh_.volume = volume.value();
    mesh_.volume_error = error.value();
  }

  void link() {
    mesh_.neighbours.assign(mesh_.tets.size(), {kNoTet, kNoTet, kNoTet, kNoTet});
    auto& neighbours = mesh_.neighbours;
    const Vector<CellSide> sides = match_faces(
        mesh_.points.size(), kMostSides,
        [&](const auto& take) {
          take({0, mesh_.tets});
        },
        [&](std::span<const CellSide> face) {
          if (face.size() != 2) return face.size() == 1;
          const std::uint32_t a = face[0].side, b = face[1].side;
          neighbours[a / 4][a % 4] = b / 4;
          neighbours[b / 4][b % 4] = a / 4;
          return false;
        });
    if (sides.empty()) {
      throw Error(
          ErrorCode::kBadInput,
          fmt::format("{}: the mesh has no boundary: its cells are doubled, or have no volume; see "
                      "'tetfusion check {}'",
                      source_->description().path, source_->description().path));
    }
    for (const CellSide& s : sides) mesh_.boundary_sides.push_back(s.side);
  }

  void find_parts() {
    PartFinder finder(mesh_.points.size());
    finder.add(mesh_.tets);
    std::uint32_t parts = 0;
    mesh_.point_parts = finder.parts([](std::size_t) { return true; }, &parts);
    if (parts == 1 || parts > kMostParts) {
      mesh_.point_parts = {};
      return;
    }
    mesh_.parts.resize(parts);
    for (TetId t = 0; t < mesh_.tets.size(); ++t) {
      mesh_.parts[mesh_.part_of(t)].add(mesh_.corners(t));
    }
  }

  void take_boundary() {
    Vector<std::uint32_t> number;
    number.assign(mesh_.points.size(), kNoVertex);
    TriangleSet& boundary = mesh_.boundary;
    for (const std::uint32_t side : mesh_.boundary_sides) {
      std::array<std::uint32_t, 3> triangle;
      for (std::size_t i = 0; i < 3; ++i) {
        const VertexId v = mesh_.tets[side / 4][kFaceCorners[side % 4][i]];
        if (number[v] == kNoVertex) {
          number[v] = static_cast<std::uint32_t>(boundary.points.size());
          boundary.points.push_back(mesh_.points[v]);
          if (!mesh_.parts.empty()) boundary.parts.push_back(mesh_.point_parts[v]);
        }
        triangle[i] = number[v];
      }
      boundary.triangles.push_back(triangle);
    }
    const Vector<std::uint32_t> order = order_triangles(&boundary);
    const Vector<std::uint32_t> sides = mesh_.boundary_sides;
    for (std::size_t i = 0; i < order.size(); ++i) mesh_.boundary_sides[i] = sides[order[i]];
  }

  // Of the file, for what is item i here.
  static Vector<std::uint64_t> rows_of(const Vector<std::uint64_t>& source,
                                       const Vector<std::uint32_t>& items) {
    Vector<std::uint64_t> rows(items.size());
    for (std::size_t i = 0; i < items.size(); ++i) {
      rows[i] = source.empty() ? items[i] : source[items[i]];
    }
    return rows;
  }

  void read_rows(Association association, const FieldSet& set, const Vector<std::uint64_t>& rows,
                 Vector<double>* out) {
    out->resize(rows.size() * set.width);
    for (const Field& field : set.fields) {
      const DataArray array = source_->read_array(association, field.simplified);
      spread_values(array.info, array.bytes,
                    {set.width, field.offset, rows.size(), rows, out->data(), field.base});
    }
  }

  MeshSource* source_;
  Geometry geometry_;
  Vector<Point> all_points_;
  Vector<std::uint32_t> tets_, points_;  // of the geometry, for each of the mesh
  SimplifiedMesh mesh_;
};

}  // namespace

SimplifiedMesh load_simplified(MeshSource* source, const FieldSet& point_fields,
                               const FieldSet& cell_fields) {
  return Loader(source).run(point_fields, cell_fields);
}

}  // namespace tetfusion
