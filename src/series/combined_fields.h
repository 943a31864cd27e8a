// What all steps of a series have to say about where a mesh may become coarse, in a few fields.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "compare/measure.h"
#include "compare/original_mesh.h"
#include "driver/arrays/steering.h"
#include "io/files/row_file.h"
#include "io/source/mesh_stream.h"

namespace tetfusion {

// Of each array that steers there are a few fields, or as many as steps if these are fewer: sums of
// the steps' values, each as a share of its range in that step, with signs; a step is in one sum,
// and those that follow each other in different ones. A few steps may be fields by themselves, too.
// They lie on the disk, and memory does not grow with the mesh but for windows, nor with the number
// of steps.
class CombinedFields {
 public:
  // How many sums, and in which of many ways: in another one steps have other signs, and meet
  // others in their sums.
  struct Settings {
    std::size_t sums = 1;
    std::uint64_t way = 0;
    std::vector<std::size_t> alone = {};  // steps that are fields by themselves, each once
  };

  // The arrays are point arrays of `first`; for so many steps of a mesh with so many points, of
  // which `used` have a say in ranges. `used` must outlive this.
  CombinedFields(const std::string& folder, const std::vector<SteeringChoice>& arrays,
                 const MeshDescription& first, const PointSet* used, std::size_t steps,
                 const Settings& settings);

  // Of each array's sums, the one that a step is in.
  std::size_t sum_of(std::size_t step) const { return (step + step / sums_ * way_) % sums_; }

  // Each step once; those of one sum in order, as sums are rounded, and those of different sums
  // from several threads at once. Throws Error(kBadInput) where it has not the arrays, with as many
  // components.
  void add(std::size_t step, const MeshDescription& mesh, const MeshStream& stream,
           const RunContext& context);
  // After all steps.
  void finish(const RunContext& context);

  // Float64; a field that is the same everywhere is among them.
  const std::vector<ArrayInfo>& fields() const { return infos_; }
  std::size_t array_of(std::size_t field) const { return field / fields_; }
  double range(std::size_t field) const { return ranges_[field]; }  // in steps' ranges
  // Its rows from `first` on, as many as there is room for.
  void read(std::size_t field, std::uint64_t first, std::span<std::byte> out) const;

 private:
  struct Source {
    std::size_t index = 0;
    ArrayInfo info;
  };
  Source find(const SteeringChoice& array, std::uint32_t components,
              const MeshDescription& mesh) const;
  // Nothing where no point has a value.
  std::optional<FieldValues> measure(const Source& source, const MeshStream& stream,
                                     const RunContext& context) const;
  void add_rows(std::size_t field, std::uint64_t first, const Vector<double>& rows, double factor);
  void take_gaps(std::size_t from, std::size_t to, const RunContext& context);
  std::uint64_t offset(std::size_t field, std::uint64_t row) const {
    return starts_[field] + row * infos_[field].components * sizeof(double);
  }

  const std::vector<SteeringChoice> arrays_;
  const PointSet* used_;
  const std::vector<std::size_t> alone_;
  const std::size_t sums_, fields_;  // of each array
  const std::uint64_t way_;
  std::vector<ArrayInfo> infos_;
  std::vector<std::uint64_t> starts_;
  std::vector<double> ranges_;
  std::optional<RowFile> file_;
};

}  // namespace tetfusion
