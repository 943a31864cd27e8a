// A part of the mesh, by what lies in it.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "mesh/data_array.h"
#include "mesh/geometry.h"

namespace tetfusion {

// Immutable, safe to use from several threads.
class RegionOfInterest {
 public:
  RegionOfInterest() = default;  // nothing is inside

  // Each text is one of
  //
  //   box=X0,X1,Y0,Y1,Z0,Z1   in VTK's order of bounds
  //   sphere=X,Y,Z,RADIUS
  //   NAME>VALUE, NAME<VALUE  of a point array; of an array of several components, the length
  //
  // What is in one of them is inside; so are points on a box's or a sphere's surface. Throws
  // Error(kUsage), naming the arrays that the mesh has; `path` is what messages call it.
  RegionOfInterest(const std::vector<std::string>& texts, const std::string& path,
                   const AttributeSet& point_data);

  // Whether such a text goes by the values of an array, not by places.
  static bool is_by_values(const std::string& text);

  bool empty() const { return parts_.empty(); }

  // Reads the values of an array at the points in hand.
  using ReadRows = std::function<void(std::size_t array, std::span<std::byte> rows)>;
  // Sets inside[i] to 1 for each point inside; leaves the others.
  template <class Real>
  void mark(std::span<const Vec3<Real>> positions, const ReadRows& read,
            std::uint8_t* inside) const;
  // The same for what goes by values alone: without the points' places.
  void mark_by_values(std::size_t points, const ReadRows& read, std::uint8_t* inside) const;

 private:
  struct Bounds {
    std::array<double, 6> limits{};  // as in the text
  };
  struct Sphere {
    Vec3<double> centre;
    double radius = 0;
  };
  struct Threshold {
    std::size_t index = 0;  // of the point array
    ArrayInfo array;
    double value = 0;
    bool above = true;
  };
  using Part = std::variant<Bounds, Sphere, Threshold>;

  static Part parse(const std::string& text, const std::string& path,
                    const AttributeSet& point_data);

  std::vector<Part> parts_;
};

}  // namespace tetfusion
