#include "kernel/sheets/facing_grid.h"

#include <algorithm>
#include <atomic>
#include <cmath>

namespace tetfusion {

namespace {

constexpr unsigned kBins = FacingGrid::kBins;

// The bin of a direction: the side of the cube that it leaves by, and the quarter of that.
unsigned bin_of(const Point3& d) {
  std::size_t axis = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (std::abs(d[i]) > std::abs(d[axis])) axis = i;
  }
  const unsigned side = static_cast<unsigned>(2 * axis) + (d[axis] < 0 ? 1 : 0);
  const unsigned quarter = (d[(axis + 1) % 3] < 0 ? 1u : 0u) | (d[(axis + 2) % 3] < 0 ? 2u : 0u);
  return 4 * side + quarter;
}

// A bin is the cone of its four corners.
struct Cone {
  std::size_t axis;
  double side, u, v;

  explicit Cone(unsigned bin)
      : axis(bin / 8),
        side(bin / 4 % 2 == 1 ? -1 : 1),
        u((bin & 1u) != 0 ? -1 : 1),
        v((bin & 2u) != 0 ? -1 : 1) {}
  // The least product of the direction with a corner.
  double least(const Point3& d) const {
    return side * d[axis] + std::min(u * d[(axis + 1) % 3], 0.0) +
           std::min(v * d[(axis + 2) % 3], 0.0);
  }
  Point3 middle() const {
    Point3 m{};
    m[axis] = side;
    m[(axis + 1) % 3] = u / 2;
    m[(axis + 2) % 3] = v / 2;
    const double length = std::sqrt(1.5);
    for (double& c : m) c /= length;
    return m;
  }
};

// The bins that hold a direction at more than a right angle to this one: a corner is such a
// direction if any is.
std::uint32_t bins_against(const Point3& d) {
  std::uint32_t bins = 0;
  for (unsigned bin = 0; bin < kBins; ++bin) {
    if (Cone(bin).least(d) < 0) bins |= 1u << bin;
  }
  return bins;
}

}  // namespace

void FacingBox::add(const Point3& p) {
  for (std::size_t i = 0; i < 3; ++i) {
    lo[i] = std::min(lo[i], p[i]);
    hi[i] = std::max(hi[i], p[i]);
  }
}

void FacingBox::widen(double by) {
  for (std::size_t i = 0; i < 3; ++i) {
    lo[i] -= by;
    hi[i] += by;
  }
}

// From 0 to kCells, but for what is outside.
Point3 FacingGrid::in_cells(const Point3& p) const {
  Point3 out{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double width = box_.hi[i] - box_.lo[i];
    out[i] = width > 0 ? (p[i] - box_.lo[i]) / width * double{kCells} : 0;
  }
  return out;
}

auto FacingGrid::range_round(const Point3& lo, const Point3& hi) -> Range {
  const auto cell = [](double x) {
    return static_cast<std::size_t>(std::clamp(x, 0.0, kCells - 1.0));
  };
  return {{cell(lo[0]), cell(lo[1]), cell(lo[2])}, {cell(hi[0]), cell(hi[1]), cell(hi[2])}};
}

double FacingGrid::cells_touched(const Triangle3& t) {
  const Point3 u = minus(t[1], t[0]), v = minus(t[2], t[0]), normal = cross(u, v);
  const double longest = std::max({dot(u, u), dot(v, v), dot(minus(u, v), minus(u, v))});
  return std::sqrt(dot(normal, normal)) / 2 + std::sqrt(longest) + 1;
}

// By the middle of the longest edge.
std::array<Triangle3, 2> FacingGrid::halves(const Triangle3& t) {
  const auto length = [&](std::size_t i, std::size_t j) {
    const Point3 edge = minus(t[i], t[j]);
    return dot(edge, edge);
  };
  std::size_t apex = 0;
  for (std::size_t i = 1; i < 3; ++i) {
    if (length((i + 1) % 3, (i + 2) % 3) > length((apex + 1) % 3, (apex + 2) % 3)) apex = i;
  }
  const Point3 &a = t[apex], &b = t[(apex + 1) % 3], &c = t[(apex + 2) % 3];
  const Point3 middle{b[0] / 2 + c[0] / 2, b[1] / 2 + c[1] / 2, b[2] / 2 + c[2] / 2};
  return {Triangle3{a, b, middle}, Triangle3{a, middle, c}};
}

void FacingGrid::reset(const FacingBox& box) {
  box_ = box;
  cells_.assign(kCells * kCells * kCells, 0);
}

void FacingGrid::note(const Point3& a, const Point3& b, const Point3& c) {
  const std::uint64_t bit = std::uint64_t{1} << bin_of(cross(minus(b, a), minus(c, a)));
  visit_triangle({a, b, c}, [&](std::size_t cell) {
    const std::atomic_ref<std::uint64_t> here(cells_[cell]);
    here.fetch_or(bit, std::memory_order_relaxed);
    here.fetch_add(std::uint64_t{1} << kBins, std::memory_order_relaxed);
    return false;
  });
}

bool FacingGrid::may_face(const FacingBox& box, const Point3& direction) const {
  const std::uint32_t bins = bins_against(direction);
  bool found = false;
  visit(box, [&](std::size_t cell) {
    found = (cells_[cell] & bins) != 0;
    return found;
  });
  return found;
}

bool FacingGrid::looks_one_way(const FacingBox& box) const {
  std::uint64_t bins = 0;
  visit(box, [&](std::size_t cell) {
    bins |= cells_[cell];
    return false;
  });
  Point3 way{};
  for (unsigned bin = 0; bin < kBins; ++bin) {
    if ((bins >> bin & 1u) == 0) continue;
    const Point3 middle = Cone(bin).middle();
    for (std::size_t i = 0; i < 3; ++i) way[i] += middle[i];
  }
  for (unsigned bin = 0; bin < kBins; ++bin) {
    if ((bins >> bin & 1u) != 0 && !(Cone(bin).least(way) > 0)) return false;
  }
  return true;
}

}  // namespace tetfusion
