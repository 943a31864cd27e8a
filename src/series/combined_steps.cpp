#include "series/combined_steps.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <span>
#include <utility>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "base/tasks.h"
#include "driver/arrays/carried_arrays.h"
#include "driver/arrays/notices.h"
#include "driver/arrays/regions.h"
#include "driver/arrays/weights.h"
#include "driver/export/export.h"
#include "driver/request/error_limits.h"
#include "driver/run_setup.h"
#include "series/other_arrays.h"
#include "series/result_mesh.h"

namespace tetfusion {

namespace {

// Of the first step, which need not have all that are named.
std::vector<std::size_t> regions_in(const MeshDescription& mesh,
                                    const std::optional<std::vector<std::string>>& names) {
  if (!names) return choose_regions(mesh, names);
  std::vector<std::size_t> regions;
  for (const std::string& name : *names) {
    const std::size_t index = mesh.cell_data.find(name);
    if (index != AttributeSet::npos) regions.push_back(index);
  }
  return regions;
}

}  // namespace

CombinedSteps::CombinedSteps(const BehaviourOptions& behaviour, const StepFiles& files,
                             const std::string& folder, const CombinedFields::Settings& sums,
                             const RunContext& context)
    : options_(behaviour),
      files_(files),
      context_(context),
      folder_(folder),
      differences_(files.count()),
      tally_(files.count()) {
  look_at_first(sums);
  std::atomic<std::size_t> seen{1};
  add_up(1, files.are_one_mesh() || is_to_compare_, at_once_,
         [&](std::size_t i, const MeshDescription& mesh, const MeshStream& stream) {
           context.report("reading steps", 0, 0.2, seen++, files.count());
           try {
             look_at(i, mesh, stream);
           } catch (const Error& error) {
             throw in_step(files[i], error);
           }
         });
  require_regions();
  say_which_regions_change();
  say_which_step_differs();
  if (!files.are_one_mesh()) tally_.say_what_is_missing(files.labels(), context);
}

void CombinedSteps::look_at_first(const CombinedFields::Settings& sums) {
  context_.report("reading steps", 0);
  const auto source = files_.open(0);
  first_ = source->description();
  const MeshDescription& mesh = first_;
  const auto stream = open_stream(source.get());
  // Where steps are read whole, one is enough in memory.
  at_once_ = stream->streams_from_disk() && thread_count() > 1 ? 2 : 1;
  is_to_compare_ = stream->streams_from_disk() && !files_.are_one_mesh();
  note_differences(0, mesh, *stream);
  tally_.note(0, mesh.point_data, mesh.cell_data);
  arrays_ = options_.arrays.empty() ? choose_what_varies_at_any(source.get(), *stream)
                                    : choose_steering(mesh, options_.arrays);
  regions_.emplace(folder_, stream->cells(), options_.regions);
  // Names that are none are refused here, where the mesh has its own arrays.
  static_cast<void>(weight_column(options_.weight, mesh, CarriedArrays(mesh)));
  if (options_.arrays.empty() && !arrays_.empty()) {
    say_what_steers({arrays_[0].name}, mesh, regions_in(mesh, options_.regions), context_);
  }
  if (surfaces_move(options_)) say_which_may_be_node_sets(mesh, *stream, arrays_, context_);
  say_which_are_directions(mesh, *stream, context_);
  if (options_.original_ids) require_no_original_ids(mesh.path, mesh);
  used_.emplace(stream->points());
  print_ = print_of(mesh, *stream, context_, &*used_);
  const auto& arrays = mesh.point_data.arrays;
  const bool has_means = std::any_of(arrays.begin(), arrays.end(),
                                     [](const ArrayInfo& array) { return array.steers_only; });
  for (const ArrayInfo& array : arrays) {
    if (array.steers_only) say_means_steer(array.name, context_);
  }
  const bool is_dressed = files_.are_one_mesh() || has_means;
  const MeshDescription whole = is_dressed ? files_.open_whole(0)->description() : mesh;
  tell_left_out(files_[0].output, whole, region_that_was_named(options_.regions), context_);
  note_widths(whole);
  context_.report_size(mesh.cells);
  regions_->add(0, mesh, *stream, context_);
  interest_.emplace(options_.interest, mesh, stream->points());
  interest_->add(mesh, *stream, context_);
  begin_sums(sums);
  add_to_sums(0, mesh, *stream);
}

// Where none does, the first of them.
std::vector<SteeringChoice> CombinedSteps::choose_what_varies_at_any(
    MeshSource* first, const MeshStream& stream) const {
  const std::vector<SteeringChoice> choices = choices_by_default(first->description());
  const auto at_any = [&](const SteeringChoice& choice) {
    if (varies(choice.index, first, &stream, context_)) return true;
    for (std::size_t i = 1; i < files_.count(); ++i) {
      const auto source = files_.open(i);
      const auto there = find_array(source->description(), choice.name);
      if (!there || there->association != Association::kPoint) continue;  // refused later
      if (varies(there->index, source.get(), source->stream().get(), context_)) return true;
    }
    return false;
  };
  const auto found = std::ranges::find_if(choices, at_any);
  if (found == choices.end()) return choices.empty() ? choices : std::vector{choices.front()};
  for (auto before = choices.begin(); before != found; ++before) {
    say_does_not_steer(before->name, context_);
  }
  return {*found};
}

void CombinedSteps::look_at(std::size_t i, const MeshDescription& mesh, const MeshStream& stream) {
  if (!files_.are_one_mesh()) {
    const auto first = [&] { return files_.open(0); };
    if (is_to_compare_) {
      require_same_size(print_, first, mesh, stream);
    } else {
      require_same_mesh(print_, first, print_of(mesh, stream, context_), mesh, stream);
    }
    regions_->add(i, mesh, stream, context_);
    note_differences(i, mesh, stream);
    note_widths(mesh);
    tally_.note(i, mesh.point_data, mesh.cell_data);
  }
  interest_->add(mesh, stream, context_);
  if (options_.original_ids) require_no_original_ids(mesh.path, mesh);
}

void CombinedSteps::require_regions() const {
  if (!options_.regions) return;
  for (const std::string& name : *options_.regions) {
    if (!regions_->has(name)) choose_regions(first_, {{name}});
  }
}

void CombinedSteps::say_which_regions_change() const {
  for (const std::string& name : regions_->changing()) {
    if ("cell:" + name == options_.weight) {
      throw Error(
          ErrorCode::kUsage,
          fmt::format("--weight cell:{}: the array says regions, too, and changes from step "
                      "to step: give another one, or --regions none",
                      name));
    }
    context_.say(fmt::format(
        "cell array {} changes from step to step: what any step tells apart stays so", name));
  }
}

void CombinedSteps::note_widths(const MeshDescription& mesh) {
  const std::lock_guard lock(widths_mutex_);
  widths_.add(mesh);
}

void CombinedSteps::note_differences(std::size_t step, const MeshDescription& mesh,
                                     const MeshStream& stream) {
  const LargestDifference largest = stream.largest_difference();
  differences_[step] = {stream.differing_points(), largest.share,
                        describe_difference(largest, mesh.point_data)};
}

// The run says itself what it is of the first one. Where steps are arrays of one mesh, all are.
void CombinedSteps::say_which_step_differs() const {
  const auto most =
      std::max_element(differences_.begin(), differences_.end(), [](const auto& a, const auto& b) {
        return std::pair(a.share, a.points) < std::pair(b.share, b.points);
      });
  if (most == differences_.begin()) return;
  context_.say(fmt::format(
      "step {}: {} that were joined with others had other values in some array{}{}: those of the "
      "first one that has it were taken",
      files_[static_cast<std::size_t>(most - differences_.begin())].label,
      format_count(most->points, "point"), most->text.empty() ? "" : ", ", most->text));
  if (differences_.front().points == 0 && limits_errors(options_, tolerances_of(arrays_))) {
    say_whose_bounds(context_);
  }
}

void CombinedSteps::begin_sums(const CombinedFields::Settings& sums) {
  sums_ = std::make_unique<CombinedFields>(folder_, arrays_, first_, &*used_, files_.count(), sums);
}

// Calls look(step, mesh, stream) for steps from that one on, and adds them to the sums, which are
// whole then; two at once if they go to different ones, so that each sum has its steps in order.
template <class Look>
void CombinedSteps::add_up(std::size_t from, bool arrays_alone, int at_once, Look look) {
  std::size_t count = 1;
  for (std::size_t i = from; i < files_.count(); i += count) {
    const bool two = at_once > 1 && i + 1 < files_.count();
    count = two && sums_->sum_of(i) != sums_->sum_of(i + 1) ? 2 : 1;
    run_tasks_with_loops(count, at_once, [&](std::size_t k) {
      const auto source = files_.open(i + k);
      const auto stream = arrays_alone ? open_rows(source.get()) : open_stream(source.get());
      look(i + k, source->description(), *stream);
      add_to_sums(i + k, source->description(), *stream);
    });
  }
  sums_->finish(context_);
}

void CombinedSteps::add_to_sums(std::size_t i, const MeshDescription& mesh,
                                const MeshStream& stream) {
  try {
    sums_->add(i, mesh, stream, context_);
  } catch (const Error& error) {
    if (!files_.are_one_mesh() || error.code() != ErrorCode::kBadInput) throw;
    throw Error(error.code(), fmt::format("step {}: {}", files_[i].label, error.what()));
  }
}

void CombinedSteps::add_up_again(const CombinedFields::Settings& sums, int at_once) {
  begin_sums(sums);
  add_up(0, true, at_once, [](std::size_t, const MeshDescription&, const MeshStream&) {});
}

void CombinedSteps::compare() const {
  const auto open = [&](std::size_t i) { return files_.open(i); };
  require_same_meshes(print_, files_.count(), open, context_);
}

std::unique_ptr<MeshSource> CombinedSteps::mesh() const {
  auto source = files_.open(0);
  OtherArrays arrays;
  for (std::size_t f = 0; f < sums_->fields().size(); ++f) {
    const auto read = [this, f](const MeshStream&, std::uint64_t first, std::span<std::byte> out) {
      sums_->read(f, first, out);
    };
    arrays.points.push_back({sums_->fields()[f], read});
  }
  if (!interest_->empty()) arrays.points.push_back(interest_->array());
  const MeshDescription& mesh = source->description();
  const auto weights = find_own_array(mesh, options_.weight);
  if (weights && weights->association == Association::kPoint) {
    arrays.points.push_back(own_array(mesh, Association::kPoint, weights->index));
  }
  for (std::size_t i = 0; i < mesh.cell_data.arrays.size(); ++i) {
    const ArrayInfo& info = mesh.cell_data.arrays[i];
    const bool is_weight =
        weights && weights->association == Association::kCell && weights->index == i;
    if (is_float(info.type) && !is_weight && !regions_->has(info.name)) continue;
    if (!regions_->changes(info.name)) {
      arrays.cells.push_back(own_array(mesh, Association::kCell, i));
    }
  }
  for (const std::string& name : regions_->changing()) {
    arrays.cells.push_back(
        {{name, ValueType::kInt64, 1, {}, mesh.cells},
         [this, name](const MeshStream&, std::uint64_t first, std::span<std::byte> out) {
           regions_->read(name, first, out);
         }});
  }
  return with_arrays(std::move(source), std::move(arrays));
}

}  // namespace tetfusion
