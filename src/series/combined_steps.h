// All steps, read once: what they have to say of the one simplification, and that they have one
// mesh.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "compare/original_mesh.h"
#include "driver/arrays/steering.h"
#include "driver/request/options.h"
#include "io/source/mesh_source.h"
#include "io/source/mesh_stream.h"
#include "series/array_tally.h"
#include "series/combined_fields.h"
#include "series/combined_interest.h"
#include "series/combined_regions.h"
#include "series/fitted_steps.h"
#include "series/step_mesh.h"
#include "series/step_source.h"

namespace tetfusion {

// On the disk lies what grows with the mesh, but for a bit or two a point.
class CombinedSteps {
 public:
  // Reads the first step, against which all others are held, and what all have of arrays that
  // steer, of regions and of the region of interest. That they have one mesh is known then, but
  // where is_to_compare(). `folder`: on whose disk this may work. Reports progress up to a fifth of
  // the run. What is given outlives this. Throws Error: kUsage for arrays that the options name and
  // the first step has not; kBadInput for a step that lacks one, or has another mesh.
  CombinedSteps(const BehaviourOptions& behaviour, const StepFiles& files,
                const std::string& folder, const CombinedFields::Settings& sums,
                const RunContext& context);

  // All of all meshes is still to be read: compare() does, in the calling thread alone, and may do
  // so beside anything else. Throws as the constructor.
  bool is_to_compare() const { return is_to_compare_; }
  void compare() const;

  // So many steps may be in hand together, as far as reading goes: 1 or 2.
  int at_once() const { return at_once_; }
  const MeshDescription& first() const { return first_; }                // step
  const std::vector<SteeringChoice>& arrays() const { return arrays_; }  // that steer, of the first
  const CombinedFields& sums() const { return *sums_; }
  std::vector<std::string> interest() const { return interest_->texts(); }
  const StepWidths& widths() const { return widths_; }  // of all steps

  // Reads the arrays of all steps again, for other sums of them.
  void add_up_again(const CombinedFields::Settings& sums, int at_once);

  // The first step's mesh, but with arrays of points that steer or weigh, and of cells that may
  // tell regions or weigh. It is valid until add_up_again().
  std::unique_ptr<MeshSource> mesh() const;

 private:
  // Of values that points have and copies had that were joined with them.
  struct Differences {
    std::uint64_t points = 0;
    double share = 0;
    std::string text;
  };

  void look_at_first(const CombinedFields::Settings& sums);
  std::vector<SteeringChoice> choose_what_varies_at_any(MeshSource* first,
                                                        const MeshStream& stream) const;
  void look_at(std::size_t step, const MeshDescription& mesh, const MeshStream& stream);
  void require_regions() const;
  void say_which_regions_change() const;
  void note_widths(const MeshDescription& mesh);
  void note_differences(std::size_t step, const MeshDescription& mesh, const MeshStream& stream);
  void say_which_step_differs() const;
  void begin_sums(const CombinedFields::Settings& sums);
  template <class Look>
  void add_up(std::size_t from, bool arrays_alone, int at_once, Look look);
  void add_to_sums(std::size_t step, const MeshDescription& mesh, const MeshStream& stream);

  const BehaviourOptions& options_;
  const StepFiles& files_;
  const RunContext& context_;
  const std::string folder_;
  int at_once_ = 1;
  bool is_to_compare_ = false;
  std::mutex widths_mutex_;
  StepWidths widths_;
  MeshDescription first_;
  std::vector<SteeringChoice> arrays_;
  MeshPrint print_;
  std::optional<PointSet> used_;
  std::unique_ptr<CombinedFields> sums_;
  std::optional<CombinedRegions> regions_;
  std::optional<CombinedInterest> interest_;
  std::vector<Differences> differences_;  // of each step
  ArrayTally tally_;
};

}  // namespace tetfusion
