// A map's places as sweeps over them want them: put aside once, for the values of many steps.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "base/vector.h"
#include "io/files/paged_array.h"
#include "io/progressive/map_file.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Where a point of the original lies. All four corners may be used: one without weight is another
// one, too. A point that lies in no tetrahedron has kNoVertex.
struct PointPlace {
  std::array<VertexId, 4> corners;
  std::array<double, 4> weights;
};
PointPlace place_of(const MapFile& map, std::uint64_t point);

// In windows of points of the original: which points of the result each depends on, and by how
// much; and the same the other way round, for the new ones among these (a new point is one that
// does not have the value of a point of the original). On the disk, up to 112 bytes a point; in
// memory a window, and a byte for each point of the result. Safe to read from several threads.
class PointWeights {
 public:
  static constexpr std::uint64_t kWindow = std::uint64_t{1} << 16;
  static constexpr std::size_t kRanges = 32;

  struct Part {
    VertexId to;         // a new point of the result
    std::uint32_t from;  // a point of the original, counted from the window's first one
    double weight;       // above 0
  };

  // `folder` is where the file lies, without a name.
  PointWeights(const MapFile& map, const std::string& folder);

  std::uint64_t points() const { return places_.size(); }
  std::uint64_t first_of(std::size_t window) const { return window * kWindow; }
  std::size_t windows() const { return ends_.size() / kRanges; }
  std::span<const PointPlace> places(std::size_t window) const;
  const PointPlace& place(std::uint64_t point) const { return places_[point]; }
  // Points of the result are in ranges, by their numbers; parts of one range are in the order of
  // the original's points.
  std::span<const Part> parts(std::size_t window, std::size_t range) const;
  // Takes what was read out of this process's memory.
  void let_go() const;

  const Vector<std::uint8_t>& is_new() const { return is_new_; }

 private:
  void find_new_points(const MapFile& map);
  void count_parts(const MapFile& map);
  void fill(std::size_t window);
  std::size_t range_of(VertexId vertex) const {
    return std::size_t{vertex} * kRanges / is_new_.size();
  }

  Vector<std::uint8_t> is_new_;
  PagedArray<PointPlace> places_;
  PagedArray<Part> parts_;
  Vector<std::uint64_t> ends_;  // in parts_, of each window's ranges
};

}  // namespace tetfusion
