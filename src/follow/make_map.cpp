#include "follow/make_map.h"

#include <algorithm>
#include <array>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "base/blocks.h"
#include "compare/corner_weights.h"
#include "compare/face_match.h"
#include "compare/locator.h"
#include "compare/measure.h"
#include "compare/original_mesh.h"
#include "compare/simplified_mesh.h"
#include "io/open_mesh.h"
#include "io/progressive/map_file.h"

namespace tetfusion {

namespace {

constexpr std::size_t kItemsPerBlock = 4096;

// A point of the original that stayed, and which of the result's it is.
struct Stayed {
  std::uint64_t original, point;
};

class MapMaker {
 public:
  MapMaker(MeshSource* original, const std::string& result, const ResultFacts& facts,
           OutputFile* file, const RunContext& context)
      : context_(context),
        result_(open_mesh(result)),
        regions_(fields_of(facts.regions, original->description(), result_->description())),
        original_(original, nothing_, regions_),
        point_type_(
            coarsest(original->description().point_type, result_->description().point_type)),
        writer_(begin(facts.numbers, file)) {
    original_.choose_bases(Association::kCell, &regions_);
    for (std::uint64_t p = 0; p < numbers_.points.size(); ++p) {
      const std::int64_t id = numbers_.points[p];
      if (id >= 0) stayed_.push_back({static_cast<std::uint64_t>(id), p});
    }
    std::sort(stayed_.begin(), stayed_.end(),
              [](const Stayed& a, const Stayed& b) { return a.original < b.original; });
  }

  void run(std::uint64_t sides, bool wants_homes) {
    mesh_ = load_simplified(result_.get(), nothing_, regions_);
    original_.survey(sides_within(sides), context_);
    original_.match_parts(mesh_.parts, context_);
    {
      const Locator locator(&mesh_, point_type_);
      put_places(locator);
      put_homes(locator, wants_homes);
    }
    mesh_.tets = {};
    mesh_.neighbours = {};
    mesh_.boundary = {};
    shares_.reserve(stayed_.size() + 4 * (numbers_.points.size() - stayed_.size()));
    for (const Stayed& s : stayed_) shares_.push_back({s.original, s.point, 1});
    find_new_points();
    std::sort(shares_.begin(), shares_.end(), [](const MapShare& a, const MapShare& b) {
      return std::pair(a.original, a.point) < std::pair(b.original, b.point);
    });
    writer_.put(shares_);
    writer_.finish(tets_sum_);
  }

 private:
  static ValueType coarsest(ValueType a, ValueType b) { return a == ValueType::kFloat32 ? a : b; }

  // The cell arrays of these names.
  static FieldSet fields_of(const std::vector<std::string>& names, const MeshDescription& original,
                            const MeshDescription& result) {
    FieldSet some;
    for (Field field : match_arrays(original, result).cells.fields) {
      if (std::find(names.begin(), names.end(), field.info.name) == names.end()) continue;
      field.offset = some.components;
      some.components += field.info.components;
      some.fields.push_back(std::move(field));
    }
    some.width = some.components;
    return some;
  }

  // Points that no cell uses any more are not read.
  MapWriter begin(const OriginalNumbers& written, OutputFile* file) {
    const Geometry mesh = result_->read_geometry();
    const std::size_t count = point_count(mesh.points);
    const std::size_t tets = mesh.tets.size();
    if (count + mesh.unused_points != written.points.size() ||
        tets + mesh.lower.size() != written.cells.size()) {
      throw std::logic_error("the result has another number of points or cells than were written");
    }
    const auto take = [](const auto& from, const auto& source, std::size_t before, std::size_t rows,
                         auto* to) {
      for (std::size_t i = 0; i < rows; ++i) {
        to->push_back(from[source.empty() ? before + i : source[i]]);
      }
    };
    take(written.points, mesh.point_source, 0, count, &numbers_.points);
    take(written.cells, mesh.tet_source, 0, tets, &numbers_.cells);
    take(written.cells, mesh.lower_source, tets, mesh.lower.size(), &numbers_.cells);
    rewound_.resize(mesh.tets.size());
    std::visit(
        [&](const auto& points) {
          for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
            rewound_[t] = determinant(points, mesh.tets[t]).value < 0;
          }
        },
        mesh.points);
    return {file, original_.all_points(), original_.stream().cells(), mesh};
  }

  // Weights are given as the corners of mesh_, which is wound alike, and kept as those of the file.
  MapPlace place_in(TetId t, std::array<double, 4> weights) const {
    const std::uint32_t cell = mesh_.tet_ids[t];
    if (rewound_[cell]) std::swap(weights[0], weights[1]);
    return {cell, weights};
  }

  void put_places(const Locator& locator);
  void put_homes(const Locator& locator, bool wanted);
  void place_points(const OriginalPoints& window, const Locator& locator,
                    Vector<MapPlace>* places) const;
  void find_new_points();
  void take_outside(const Vector<std::uint32_t>& points, const std::vector<bool>& found);
  void add_shares(std::uint64_t point, std::span<const VertexId> corners,
                  std::span<const double> weights);

  const RunContext& context_;
  const FieldSet nothing_{};
  std::unique_ptr<MeshSource> result_;
  FieldSet regions_;
  OriginalMesh original_;
  const ValueType point_type_;
  OriginalNumbers numbers_;  // of the result as it is read
  std::uint64_t tets_sum_ = 0;
  std::vector<bool> rewound_;  // tetrahedra of the file
  MapWriter writer_;
  Vector<Stayed> stayed_;  // ascending by original
  SimplifiedMesh mesh_;
  Vector<MapShare> shares_;
};

void MapMaker::put_places(const Locator& locator) {
  // A tetrahedron of each point that stayed: it need not be looked for, and on a crack, where two
  // points have one place, only the mesh can tell them apart.
  Vector<MapPlace> of_points(numbers_.points.size());
  for (std::size_t t = mesh_.tets.size(); t > 0; --t) {
    for (std::size_t k = 0; k < 4; ++k) {
      std::array<double, 4> weights{};
      weights[k] = 1;
      const auto tet = static_cast<TetId>(t - 1);
      of_points[mesh_.point_ids[mesh_.tets[tet][k]]] = place_in(tet, weights);
    }
  }
  Vector<MapPlace> places;
  Vector<MapPlace> run;
  std::uint64_t next = 0;
  original_.for_each_points([&](const OriginalPoints& window, double share) {
    place_points(window, locator, &places);
    run.clear();
    for (std::size_t i = 0; i < places.size(); ++i) {
      const std::uint64_t id = window.ids[i];
      for (; next < id; ++next) run.push_back({});
      const auto at = std::lower_bound(
          stayed_.begin(), stayed_.end(), id,
          [](const Stayed& s, std::uint64_t wanted) { return s.original < wanted; });
      const bool stayed = at != stayed_.end() && at->original == id;
      run.push_back(stayed ? of_points[at->point] : places[i]);
      ++next;
    }
    writer_.put(run);
    context_.check();
    context_.report("mapping", 0.3 * share);
  });
  run.clear();
  run.resize(original_.all_points() - next);
  for (MapPlace& place : run) place = {};
  writer_.put(run);
}

void MapMaker::place_points(const OriginalPoints& window, const Locator& locator,
                            Vector<MapPlace>* places) const {
  places->resize(window.points.size());
  const Vector<std::uint32_t> order = curve_order(window.points);
  for_each_block(order.size(), kItemsPerBlock,
                 [&](std::size_t, std::size_t begin, std::size_t end) {
                   LocatorHint hint;
                   for (std::size_t i = begin; i < end; ++i) {
                     const Place place =
                         locator.locate(window.points[order[i]], &hint, window.part_of(order[i]));
                     (*places)[order[i]] = place_in(place.tet, place.weights);
                   }
                 });
}

void MapMaker::put_homes(const Locator& locator, bool wanted) {
  CellHomes cells(mesh_, locator, numbers_);
  TetsChecksum sum;
  Vector<MapHome> run, homes;
  std::uint64_t next = 0;
  const auto take = [&](const OriginalCells& window, double share) {
    homes.assign(window.tets.size(), {});
    cells.find(window, regions_.width, homes);
    run.clear();
    for (std::size_t i = 0; i < homes.size(); ++i) {
      const std::uint64_t row = window.row(i);
      Tet corners = window.tets[i];
      for (VertexId& v : corners) v = window.points.ids[v];
      sum.add(row, corners);
      run.resize(run.size() + row - next, MapHome{});
      run.push_back(homes[i]);
      next = row + 1;
    }
    writer_.put(run);
    context_.check();
    context_.report("mapping", 0.3 + 0.3 * share);
  };
  if (wanted) original_.for_each_cells(take);
  const std::uint64_t count = original_.stream().cells();
  run.assign(std::min<std::uint64_t>(count - next, kItemsPerBlock), {});
  for (; next < count; next += run.size()) {
    run.resize(std::min<std::uint64_t>(count - next, run.size()));
    writer_.put(run);
  }
  writer_.put(cells.origins());
  tets_sum_ = sum.value();
}

// Each tetrahedron of the original asks which of the new points may lie in it.
void MapMaker::find_new_points() {
  Vector<std::uint32_t> points;  // of mesh_
  for (std::uint32_t v = 0; v < mesh_.points.size(); ++v) {
    if (numbers_.points[mesh_.point_ids[v]] < 0) points.push_back(v);
  }
  BoxTree tree;
  tree.build(points.size(), mesh_.box.centre(), [&](std::size_t i) {
    PointBox box;
    box.add(mesh_.points[points[i]]);
    return box;
  });
  struct Hit {
    std::uint32_t item;
    Tet corners;  // of the original
    std::array<double, 4> weights;
  };
  std::vector<bool> found(points.size());
  original_.for_each_cells([&](const OriginalCells& window, double share) {
    std::vector<std::vector<Hit>> hits(block_count(window.tets.size(), kItemsPerBlock));
    for_each_block(
        window.tets.size(), kItemsPerBlock, [&](std::size_t b, std::size_t begin, std::size_t end) {
          for (std::size_t t = begin; t < end; ++t) {
            Tet tet = window.tets[t];
            const int sign = determinant(window.points.points, tet).sign();
            if (sign == 0) continue;
            if (sign < 0) std::swap(tet[0], tet[1]);
            const std::uint32_t part = window.points.part_of(tet[0]);
            Corners corners;
            PointBox box;
            for (std::size_t k = 0; k < 4; ++k) {
              corners[k] = window.points.points[tet[k]];
              box.add(corners[k]);
            }
            tree.find(box.centre(), 0.5 * largest_part(box.extent()), [&](std::uint32_t item) {
              if (found[item]) return false;
              if (part != kAnyPart && mesh_.part_of_point(points[item]) != part) return false;
              const auto weights = weights_in(corners, mesh_.points[points[item]]);
              if (!weights) return false;
              Tet ids;
              for (std::size_t k = 0; k < 4; ++k) ids[k] = window.points.ids[tet[k]];
              hits[b].push_back({item, ids, *weights});
              return false;
            });
          }
        });
    for (const std::vector<Hit>& of_block : hits) {
      for (const Hit& hit : of_block) {
        if (found[hit.item]) continue;
        found[hit.item] = true;
        add_shares(mesh_.point_ids[points[hit.item]], hit.corners, hit.weights);
      }
    }
    context_.check();
    context_.report("mapping", 0.6 + 0.4 * share);
  });
  take_outside(points, found);
}

void MapMaker::take_outside(const Vector<std::uint32_t>& points, const std::vector<bool>& found) {
  const TriangleSet& boundary = original_.boundary();
  const TriangleFinder finder(&boundary);
  std::uint32_t hint = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (found[i]) continue;
    const TriangleFinder::Found nearest =
        finder.nearest(mesh_.points[points[i]], hint, mesh_.part_of_point(points[i]));
    hint = nearest.triangle;
    std::array<VertexId, 3> corners = boundary.triangles[nearest.triangle];
    for (VertexId& v : corners) v = boundary.point_ids[v];
    add_shares(mesh_.point_ids[points[i]], corners, nearest.nearest.weights);
  }
}

void MapMaker::add_shares(std::uint64_t point, std::span<const VertexId> corners,
                          std::span<const double> weights) {
  constexpr double kNearlyOne = 1 - std::numeric_limits<double>::epsilon() / 2;  // it did not stay
  for (std::size_t k = 0; k < corners.size(); ++k) {
    if (weights[k] > 0) shares_.push_back({corners[k], point, std::min(weights[k], kNearlyOne)});
  }
}

}  // namespace

void make_map(MeshSource* original, const std::string& result, const ResultFacts& facts,
              std::uint64_t sides, OutputFile* file, const RunContext& context) {
  MapMaker(original, result, facts, file, context).run(sides, facts.wants_homes);
}

}  // namespace tetfusion
