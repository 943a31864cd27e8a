#include "judge.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

#include "measure.h"
#include "surfaces.h"

namespace corpus {

namespace {

using Key = std::int64_t;  // of a place: equal coordinates, equal keys
using FaceKeys = std::multiset<std::array<Key, 3>>;

class Judge {
 public:
  Judge(const Case& c, const Mesh& result)
      : o_(c.options), before_(c.mesh), after_(result), numbers_(c, result) {
    for (const Mesh* mesh : {&before_, &after_}) {
      for (const Point& p : mesh->points) keys_.try_emplace(p, static_cast<Key>(keys_.size()));
    }
    faces_before_ = faces_of(before_.tets);
    faces_after_ = faces_of(after_.tets);
    regions_ = o_.regions ? find(before_.cell_arrays, kRegions) : nullptr;
  }

  std::vector<std::string> run() {
    judge_arrays();
    if (!faults_.empty()) return faults_;
    judge_counts();
    if (!trace_cells()) return faults_;
    judge_cells();
    judge_signs();
    judge_faces();
    judge_fixed_points();
    judge_ranges();
    judge_linear_field();
    for (std::string& fault : numbers_.judge()) faults_.push_back(std::move(fault));
    return faults_;
  }

 private:
  template <class... Parts>
  void fail(const Parts&... parts) {
    std::ostringstream text;
    (text << ... << parts);
    faults_.push_back(text.str());
  }

  Key key(const Mesh& mesh, std::int64_t v) const {
    return keys_.at(mesh.points[static_cast<std::size_t>(v)]);
  }
  std::array<Key, 4> keys(const Mesh& mesh, const Tet& t) const {
    std::array<Key, 4> result{key(mesh, t[0]), key(mesh, t[1]), key(mesh, t[2]), key(mesh, t[3])};
    std::sort(result.begin(), result.end());
    return result;
  }

  void judge_arrays() {
    if (after_.floats != before_.floats) fail("arrays: the points have another type");
    const auto compare = [&](const std::vector<Array>& a, const std::vector<Array>& b) {
      for (const Array& array : a) {
        const Array* other = find(b, array.name);
        if (other == nullptr) {
          fail("arrays: ", array.name, " is lost");
        } else if (other->type != array.type || other->components != array.components) {
          fail("arrays: ", array.name, " has another type");
        }
      }
    };
    compare(before_.point_arrays, after_.point_arrays);
    compare(before_.cell_arrays, after_.cell_arrays);
    compare(before_.field_arrays, after_.field_arrays);
    for (const Array& array : before_.field_arrays) {
      const Array* other = find(after_.field_arrays, array.name);
      if (other != nullptr && other->bytes != array.bytes)
        fail("arrays: ", array.name, " is another one");
    }
  }

  void judge_counts() {
    const std::uint64_t goal = std::min<std::uint64_t>(o_.tets.value_or(1), before_.tets.size());
    if (after_.tets.size() < goal) {
      fail("goal: ", after_.tets.size(), " tetrahedra are fewer than ", goal);
    }
    if (after_.tets.size() > before_.tets.size())
      fail("goal: there are more tetrahedra than before");
  }

  // Has another cell of the input its centre in it? Then two are in one place.
  bool is_overlapped(std::size_t cell) const {
    const auto corners_of = [&](std::size_t t) {
      std::array<Point, 4> corners;
      for (std::size_t k = 0; k < 4; ++k) {
        corners[k] = before_.points[static_cast<std::size_t>(before_.tets[t][k])];
      }
      return corners;
    };
    const std::array<Point, 4> own = corners_of(cell);
    const int sign = orientation(own[0], own[1], own[2], own[3]);
    for (std::size_t t = 0; t < before_.tets.size(); ++t) {
      if (t == cell) continue;
      Point centre{};
      for (const Point& p : corners_of(t)) {
        for (std::size_t a = 0; a < 3; ++a) centre[a] += p[a] / 4;
      }
      bool inside = true;
      for (std::size_t k = 0; k < 4; ++k) {
        std::array<Point, 4> with = own;
        with[k] = centre;
        inside &= sign * orientation(with[0], with[1], with[2], with[3]) >= 0;
      }
      if (inside) return true;
    }
    return false;
  }

  // Might the new tetrahedron's values be means of those of the input in its region?
  bool is_mean(const Array& array, const Array& other, std::size_t c) const {
    for (std::size_t k = 0; k < array.components; ++k) {
      const double mean = other.value(c * array.components + k);
      const double own = array.value(trace_[c] * array.components + k);
      if (mean == own || (std::isnan(mean) && std::isnan(own))) continue;
      bool lower = false, higher = false;  // or there are such that are no numbers
      for (std::size_t t = 0; t < before_.tets.size(); ++t) {
        if (between({t, trace_[c]})) continue;
        const double value = array.value(t * array.components + k);
        const bool are_none = !std::isfinite(mean) && !std::isfinite(value);
        lower |= value <= mean || are_none;
        higher |= value >= mean || are_none;
      }
      if (!lower || !higher) return false;
    }
    return true;
  }

  // Which cell of the input each is.
  bool trace_cells() {
    const Array* numbers = find(after_.cell_arrays, kCellNumber);
    std::set<std::size_t> seen;
    for (std::size_t c = 0; c < after_.cells(); ++c) {
      const double number = numbers->value(c);
      const bool tet = c < after_.tets.size();
      if (!(number >= 0 && number < static_cast<double>(before_.cells())) ||
          (number < static_cast<double>(before_.tets.size())) != tet ||
          !seen.insert(static_cast<std::size_t>(number)).second) {
        fail("cells: cell ", c, " is none of the input's, or there twice");
        return false;
      }
      trace_.push_back(static_cast<std::size_t>(number));
    }
    return true;
  }

  void judge_cells() {
    for (const Array& array : before_.cell_arrays) {
      if (o_.conserve && array.is_float()) continue;
      const Array& other = *find(after_.cell_arrays, array.name);
      const bool is_averaged = o_.fuse && array.is_float() && &array != regions_;
      for (std::size_t c = 0; c < trace_.size(); ++c) {
        if (other.row(c) == array.row(trace_[c])) continue;
        if (is_averaged && c < after_.tets.size() && is_mean(array, other, c) &&
            (changed(c) || is_overlapped(trace_[c]))) {
          continue;
        }
        fail("cells: cell ", c, " has another value of ", array.name);
        break;
      }
    }
    if (after_.lower.size() != before_.lower.size()) {
      fail("cells: some of lower dimension are lost");
      return;
    }
    for (std::size_t i = 0; i < before_.lower.size(); ++i) {
      const LowerCell &a = before_.lower[i], &b = after_.lower[i];
      bool same = a.type == b.type && a.corners.size() == b.corners.size();
      for (std::size_t k = 0; same && k < a.corners.size(); ++k) {
        same = key(before_, a.corners[k]) == key(after_, b.corners[k]);
      }
      if (!same) fail("cells: cell ", i, " of lower dimension is another one");
    }
  }

  bool changed(std::size_t t) const {
    return keys(after_, after_.tets[t]) != keys(before_, before_.tets[trace_[t]]);
  }

  // What has changed is wound as it should be, for certain.
  void judge_signs() {
    std::set<std::size_t> boundary;
    if (o_.boundary_tets) {
      std::set<std::int64_t> vertices;
      for (const auto& [face, cells] : faces_before_) {
        if (cells.size() == 1) vertices.insert(face.begin(), face.end());
      }
      for (std::size_t t = 0; t < before_.tets.size(); ++t) {
        for (const std::int64_t v : before_.tets[t]) {
          if (vertices.count(v) != 0) boundary.insert(t);
        }
      }
    }
    std::size_t bad = 0, first = 0;
    for (std::size_t t = 0; t < after_.tets.size(); ++t) {
      if (!changed(t)) {
        boundary.erase(trace_[t]);
        continue;
      }
      if (numbers_.sign(after_.tets[t]) > 0) continue;
      if (bad++ == 0) first = t;
    }
    if (bad > 0)
      fail("inverted: ", bad, " cells have been turned over or flattened, as cell ", first);
    if (!boundary.empty()) fail("boundary: ", boundary.size(), " boundary tetrahedra have changed");
  }

  using Chosen = std::function<bool(const std::vector<std::size_t>& cells)>;

  bool between(const std::vector<std::size_t>& cells) const {  // of the input
    for (const std::size_t c : cells) {
      if (regions_ != nullptr && regions_->row(c) != regions_->row(cells[0])) return true;
    }
    return false;
  }
  std::vector<std::size_t> traced(const std::vector<std::size_t>& cells) const {
    std::vector<std::size_t> result;
    for (const std::size_t c : cells) result.push_back(trace_[c]);
    return result;
  }

  // The faces of both meshes for whose cells, by their numbers in the input, that is true.
  std::array<std::vector<Face>, 2> choose(const Chosen& chosen) const {
    std::array<std::vector<Face>, 2> result;
    for (const auto& [face, cells] : faces_before_) {
      if (chosen(cells)) result[0].push_back(face);
    }
    for (const auto& [face, cells] : faces_after_) {
      if (chosen(traced(cells))) result[1].push_back(face);
    }
    return result;
  }

  FaceKeys places(const Mesh& mesh, const std::vector<Face>& faces) const {
    FaceKeys result;
    for (const Face& f : faces) {
      std::array<Key, 3> k{key(mesh, f[0]), key(mesh, f[1]), key(mesh, f[2])};
      std::sort(k.begin(), k.end());
      result.insert(k);
    }
    return result;
  }

  void judge_faces() {
    const auto boundary = choose([](const auto& cells) { return cells.size() == 1; });
    const auto overfull = choose([](const auto& cells) { return cells.size() > 2; });
    const auto interface = choose([&](const auto& cells) { return between(cells); });
    if (places(before_, overfull[0]) != places(after_, overfull[1])) {
      fail("faces: those with more than two cells are others");
    }
    judge_surface("boundary", boundary);
    judge_surface("interfaces", interface);
    const Topology a = topology_of(boundary[0]), b = topology_of(boundary[1]);
    if (a.parts != b.parts || a.euler != b.euler) {
      fail("topology: the boundary had ", a.parts, " parts and Euler number ", a.euler, ", now ",
           b.parts, " and ", b.euler);
    }
    if (b.odd_edges > a.odd_edges) {
      fail("topology: ", b.odd_edges, " boundary edges are not manifold, before ", a.odd_edges);
    }
    if (numbers_.foldovers(after_, faces_after_) > numbers_.foldovers(before_, faces_before_)) {
      fail("inverted: cells lie on the same side of a face that did not");
    }
  }

  void judge_surface(const char* what, const std::array<std::vector<Face>, 2>& faces) {
    if (o_.surface == Surface::kExact) {
      if (places(before_, faces[0]) != places(after_, faces[1])) {
        fail(what, ": the triangles are others (", faces[0].size(), " before, ", faces[1].size(),
             " now)");
      }
      return;
    }
    const double share = o_.surface == Surface::kPlanar ? 0x1p-18 : o_.distance;
    const double found = numbers_.distance(faces[0], faces[1]);
    if (!(found <= share + numbers_.rounding())) {
      fail(what, ": moved by ", found, " of the diagonal, more than ", share);
    }
  }

  // Points that stay, with all their values.
  void judge_fixed_points() {
    const Array* numbers = find(before_.point_arrays, kPointNumber);
    if (numbers == nullptr) return;
    std::set<std::int64_t> fixed;
    const bool exact = o_.surface == Surface::kExact;
    for (const auto& [face, cells] : faces_before_) {
      if (cells.size() > 2 || (exact && (cells.size() == 1 || between(cells)))) {
        fixed.insert(face.begin(), face.end());
      }
    }
    for (const LowerCell& c : before_.lower) fixed.insert(c.corners.begin(), c.corners.end());
    const Array& steers = before_.point_arrays[0];
    for (const Tet& t : before_.tets) {
      if (!numbers_.steers(steers)) break;
      for (const std::int64_t v : t) {
        if (!numbers_.finite(steers, static_cast<std::size_t>(v))) fixed.insert(v);
      }
    }
    std::map<std::pair<std::string, Key>, std::vector<std::size_t>> found;
    const Array& after = *find(after_.point_arrays, kPointNumber);
    for (std::size_t p = 0; p < after_.points.size(); ++p) {
      found[{after.row(p), key(after_, static_cast<std::int64_t>(p))}].push_back(p);
    }
    std::size_t gone = 0, changed_values = 0;
    for (const std::int64_t v : fixed) {
      const auto at = found.find({numbers->row(static_cast<std::size_t>(v)), key(before_, v)});
      if (at == found.end()) {
        ++gone;
      } else if (!same_values(static_cast<std::size_t>(v), at->second)) {
        ++changed_values;
      }
    }
    if (gone > 0) fail("points: ", gone, " that must stay are gone");
    if (changed_values > 0) fail("points: ", changed_values, " that stay have other values");
  }

  bool same_values(std::size_t v, const std::vector<std::size_t>& candidates) const {
    return std::any_of(candidates.begin(), candidates.end(), [&](std::size_t p) {
      return std::all_of(
          before_.point_arrays.begin(), before_.point_arrays.end(),
          [&](const Array& a) { return find(after_.point_arrays, a.name)->row(p) == a.row(v); });
    });
  }

  void judge_ranges() {
    for (const Array& array : before_.point_arrays) {
      const Array& other = *find(after_.point_arrays, array.name);
      if (!array.is_float()) {
        std::set<std::string> rows;
        for (std::size_t i = 0; i < array.rows(); ++i) rows.insert(array.row(i));
        for (std::size_t i = 0; i < other.rows(); ++i) {
          if (rows.count(other.row(i)) != 0) continue;
          fail("values: ", array.name, " has rows that the input has not");
          break;
        }
        continue;
      }
      for (std::size_t k = 0; k < array.components; ++k) judge_range(array, other, k);
    }
  }

  void judge_range(const Array& array, const Array& other, std::size_t component) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t i = component; i < array.rows() * array.components; i += array.components) {
      if (!std::isfinite(array.value(i))) return;
      low = std::min(low, array.value(i));
      high = std::max(high, array.value(i));
    }
    for (std::size_t i = component; i < other.rows() * other.components; i += other.components) {
      const double value = other.value(i);
      if (value >= low && value <= high) continue;
      fail("values: ", array.name, " is ", value, ", out of ", low, " to ", high);
      return;
    }
  }

  // Each fusion rounds a position and a value once; a point is moved by not many.
  void judge_linear_field() {
    const Array* linear = find(after_.point_arrays, kLinear);
    if (linear == nullptr || o_.conserve || o_.surface != Surface::kExact) return;
    double size = std::abs(kOffset);
    for (std::size_t i = 0; i < 3; ++i) {
      double most = 0;
      for (const Point& p : before_.points) most = std::max(most, std::abs(p[i]));
      size += most * std::abs(kSlope[i]);
    }
    double worst = 0;
    for (std::size_t v = 0; v < after_.points.size(); ++v) {
      long double value = kOffset;
      for (std::size_t i = 0; i < 3; ++i)
        value += static_cast<long double>(kSlope[i]) * after_.points[v][i];
      worst = std::max(worst, static_cast<double>(std::abs(value - linear->value(v))));
    }
    const double allowed = 40 * (after_.floats ? 0x1p-23 : 0x1p-52) * size;
    if (!(worst <= allowed))
      fail("values: a linear field is off by ", worst, ", more than ", allowed);
  }

  const Options& o_;
  const Mesh &before_, &after_;
  Measure numbers_;
  std::map<Point, Key> keys_;
  Faces faces_before_, faces_after_;
  const Array* regions_ = nullptr;
  std::vector<std::size_t> trace_;
  std::vector<std::string> faults_;
};

}  // namespace

std::vector<std::string> judge(const Case& c, const Mesh& result) { return Judge(c, result).run(); }

}  // namespace corpus
