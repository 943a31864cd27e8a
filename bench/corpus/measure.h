// Signs, distances, errors and integrals of the input and the result of a case.
#pragma once

#include <array>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "case.h"
#include "surfaces.h"

namespace corpus {

class Measure {
 public:
  Measure(const Case& c, const Mesh& result);

  int sign(const Tet& t) const;  // of the result
  // Faces of two cells that lie on the same side of it.
  std::size_t foldovers(const Mesh& mesh, const Faces& faces) const;
  // Between two surfaces, the input's and the result's, as a share of the diagonal.
  double distance(const std::vector<Face>& before, const std::vector<Face>& after) const;
  double rounding() const;  // of coordinates, as a share of the diagonal
  static bool finite(const Array& array, std::size_t row);
  // Has a point array a range, so that it can steer?
  bool steers(const Array& array) const { return range_of(array).width > 0; }

  // Errors at points, volumes and integrals, as far as they were promised.
  std::vector<std::string> judge() const;

 private:
  // Over the points that cells use, where all components are finite.
  struct Range {
    double width = 0;    // the diagonal of the components' box
    double largest = 0;  // absolute value
  };
  Range range_of(const Array& array) const;
  void judge_errors(std::vector<std::string>* faults) const;
  struct Corners;
  static std::optional<std::array<long double, 4>> weights_in(const Corners& c, const Point& p);
  bool any_in_another_cell() const;
  double error_at(std::size_t v, const Array& before, const Array& after, bool* inside) const;
  double error_outside(std::size_t v, const Array& before, const Array& after) const;
  template <class Ids, class Weights>
  double difference(std::size_t v, const Array& before, const Array& after, const Ids& ids,
                    const Weights& weights) const;
  void judge_volume(std::vector<std::string>* faults) const;
  void judge_integrals(std::vector<std::string>* faults) const;
  long double volume_error() const;
  long double change_of_volume() const;
  long double rounding_of_surface() const;
  Triangles triangles(const std::vector<Point>& points, const std::vector<Face>& faces) const;

  const Options& o_;
  const Mesh &before_, &after_;
  std::vector<Point> points_before_, points_after_;  // divided by a power of two
  std::vector<Face> boundary_after_;
  std::set<std::size_t> used_;         // points of the input that cells use
  double diagonal_ = 0, largest_ = 0;  // in that unit
  bool overlaps_ = false;              // cells of the input
};

}  // namespace corpus
