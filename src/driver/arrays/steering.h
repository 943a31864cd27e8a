// Which arrays steer, and their values at the vertices.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/run_context.h"
#include "driver/request/error_limits.h"
#include "io/source/mesh_stream.h"
#include "kernel/criteria.h"

namespace tetfusion {

// An array that the user, or the default, chose to steer.
struct SteeringChoice {
  Association association = Association::kPoint;
  std::size_t index = 0;            // in the description's AttributeSet
  std::optional<double> tolerance;  // "NAME:0.5%": its own, as a share of its range
  std::string name;                 // as in the file; "cell:NAME" for a cell array
  bool by_name = false;             // the user has named it
};

// The bounds of their own.
Tolerances tolerances_of(const std::vector<SteeringChoice>& choices);

// "NAME" of the points, "cell:NAME" of the cells.
std::optional<SteeringChoice> find_array(const MeshDescription& mesh, const std::string& name);
// The same, but none that is there for steering alone: "cell:NAME" is that of the cells then, too.
std::optional<SteeringChoice> find_own_array(const MeshDescription& mesh, const std::string& name);

// The name that stands for many.
inline constexpr std::string_view kAllArrays = "all";

// "NAME:0.005", as a user would give it.
std::string with_tolerance(const std::string& name, double tolerance);

// Resolves the user's names ("NAME", "NAME:0.5%", "cell:NAME"; "all" for the floating-point point
// arrays that are not named besides, if no array is called so). Throws Error(kUsage) naming the
// arrays there are, or for an array that is named twice.
std::vector<SteeringChoice> choose_steering(const MeshDescription& mesh,
                                            const std::vector<std::string>& names);

// Where nobody has named any one of these steers: VTK's active scalars, and the floating-point
// point arrays in the file's order.
std::vector<SteeringChoice> choices_by_default(const MeshDescription& mesh);

// Does that array of the points have two finite values that differ, at points that tetrahedra use?
// Without a stream it is read whole, and all points count.
bool varies(std::size_t point_array, MeshSource* source, const MeshStream* stream,
            const RunContext& context);

// The first of choices_by_default() that varies, with a notice of those before it; all of them
// where none does.
std::vector<SteeringChoice> choose_what_varies(MeshSource* source, const MeshStream* stream,
                                               const RunContext& context);

// The one that those who name none get; none where all arrays that could be it are the same
// everywhere.
std::optional<SteeringChoice> steering_by_default(MeshSource* source, const MeshStream* stream,
                                                  const RunContext& context);

// Values a point, of all of them.
std::uint32_t components_of(const std::vector<SteeringChoice>& choices,
                            const MeshDescription& mesh);

// Of a cell array, at every point: means of the cells round it, weighted by volume; 0 where there
// are none.
Vector<double> means_at_points(std::size_t cell_array, const MeshDescription& mesh,
                               const MeshStream& stream, const RunContext& context);

// The values of the arrays that steer, at any window of points, each field in a unit of its own
// that is a power of two: its range lies between a half and one.
class Steering {
 public:
  Steering() = default;

  // Looks through the chosen arrays for their ranges. Cell arrays are averaged at the points,
  // weighted by volume, and kept in memory (8 bytes a component and point). A field whose range is
  // zero is left out, with a notice; but not where it has been chosen by name and has no value at
  // some points, which must stay as they are. The stream must outlive this.
  Steering(const std::vector<SteeringChoice>& choices, const MeshDescription& mesh,
           const MeshStream& stream, const RunContext& context);

  // Takes the fields' ranges, and so their units, from the points of which is_used(point) is true
  // alone: what others have may be anything. A field whose range is zero then stays as it is.
  void relate_to(const std::function<bool(VertexId)>& is_used, const RunContext& context);

  const std::vector<SteeringField>& fields() const { return fields_; }
  const std::vector<std::string>& names() const { return names_; }  // one a field
  std::uint32_t width() const { return width_; }                    // values a point
  // Which of the description's point arrays a field is; none: a cell array's averages.
  std::optional<std::size_t> point_array(std::size_t field) const {
    const Array& array = arrays_[field];
    return array.averages.empty() ? std::optional(array.index) : std::nullopt;
  }

  // width() values for each point of a window into `values`, NaN for all that is not finite; sets
  // not_finite[i] to 1 where one is: the vertex must stay. Safe to call from several threads.
  void read(std::uint64_t first, std::uint64_t count, double* values,
            std::uint8_t* not_finite) const;

 private:
  struct Array {
    std::size_t index = 0;  // of the point array
    ValueType type = ValueType::kFloat64;
    std::uint32_t components = 1;
    int exponent = 0;         // values are scaled by 2^exponent
    Vector<double> averages;  // of a cell array at the points; else empty
  };
  void read_array(const Array& array, std::uint64_t first, std::uint64_t count,
                  Vector<double>* values) const;
  // The field's range in its new unit, which is set; 0 when all values are the same, and then in a
  // unit in which they are no larger than one. Says, too, whether some tuples are finite and others
  // are not.
  struct Measured {
    double range = 0;
    bool has_gaps = false;
  };
  Measured measure(Array* array, const std::function<bool(VertexId)>& is_used,
                   const RunContext& context) const;

  const MeshStream* stream_ = nullptr;
  std::vector<Array> arrays_;
  std::vector<SteeringField> fields_;
  std::vector<std::string> names_;
  std::uint32_t width_ = 0;
};

}  // namespace tetfusion
