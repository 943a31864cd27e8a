// Where the mesh is to stay as it is.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "io/mesh_source.h"
#include "io/mesh_stream.h"
#include "mesh/geometry.h"
#include "partition/curve_cut.h"

namespace tetfusion {

// A tetrahedron all of whose points are inside stays. Immutable, safe to use from several threads.
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
  // Error(kUsage), naming the arrays there are.
  RegionOfInterest(const std::vector<std::string>& texts, const MeshDescription& mesh);

  // Sets locked[i] to 1 for each point inside, of those from `first` on; leaves the others.
  template <class Real>
  void lock(const MeshStream& stream, std::uint64_t first, std::span<const Vec3<Real>> positions,
            std::uint8_t* locked) const;

 private:
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
  using Part = std::variant<Box, Sphere, Threshold>;

  static Part parse(const std::string& text, const MeshDescription& mesh);

  std::vector<Part> parts_;
};

}  // namespace tetfusion
