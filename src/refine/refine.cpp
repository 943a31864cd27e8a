#include "refine/refine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "base/resources.h"
#include "mesh/region_of_interest.h"
#include "refine/fusion_needs.h"
#include "refine/points_inside.h"
#include "refine/refinable_mesh.h"
#include "refine/write_level.h"

namespace tetfusion {

namespace {

// Shares of the work that are done when it is known what a region needs, and when the mesh is
// refined.
constexpr double kRegionShare = 0.4;
constexpr double kRefineShare = 0.6;

class Job {
 public:
  Job(const RefineRequest& request, const RunContext& context)
      : request_(request), context_(context), file_(ProgressiveFile::open(request.input)) {
    check_errors_are_known();
    const RegionOfInterest region(request.region, request.input,
                                  file_.description().point_data);  // or throws now
  }
  RefineReport run(PhaseClock* clock);

 private:
  void check_errors_are_known() const;
  std::optional<double> error_goal() const {
    return request_.max_error ? request_.max_error : request_.max_rms;
  }
  std::uint64_t tets_goal() const;
  std::unique_ptr<RefinableMesh> read_base() const;
  template <class F>
  void for_each_fusion(double from, double to, F f) const;
  void find_needed();
  void find_end();
  void check_count(std::uint64_t fusions) const;
  void undo(RefinableMesh* mesh);
  void undo_everywhere(RefinableMesh* mesh);
  void undo_needed(RefinableMesh* mesh);
  void add_rest(RefinableMesh* mesh) const;

  const RefineRequest& request_;
  const RunContext& context_;
  ProgressiveFile file_;
  RefineReport report_;
  // With a region: which fusions are to be undone.
  Vector<std::uint8_t> needed_;
  Vector<float> errors_;                                           // of all fusions
  std::uint64_t end_ = std::numeric_limits<std::uint64_t>::max();  // none from here on is undone
};

void check_request(const RefineRequest& request) {
  const auto refuse = [](const std::string& message) { throw Error(ErrorCode::kUsage, message); };
  std::string goals;
  int count = 0;
  const auto add = [&](bool given, const char* name) {
    if (!given) return;
    goals += count++ == 0 ? name : fmt::format(" and {}", name);
  };
  add(request.tets.has_value(), "--tets");
  add(request.reduction.has_value(), "--reduction");
  add(request.max_error.has_value(), "--max-error");
  add(request.max_rms.has_value(), "--max-rms");
  if (count > 1) refuse(fmt::format("{} are {} goals: give one of them", goals, count));
  if (request.reduction && !(*request.reduction >= 0 && *request.reduction < 1)) {
    refuse("--reduction must be at least 0% and less than 100%");
  }
  if (request.tets && *request.tets == 0) refuse("--tets must be at least 1");
  if (request.max_error && !(*request.max_error >= 0)) refuse("--max-error must be at least 0%");
  if (request.max_rms && !(*request.max_rms >= 0)) refuse("--max-rms must be at least 0%");
  check_mesh_output(request.output, request.write.encoding);
}

void Job::check_errors_are_known() const {
  if (!error_goal()) return;
  const FusionErrors known = file_.description().errors;
  if (known == FusionErrors::kNone) {
    throw Error(
        ErrorCode::kUsage,
        fmt::format("{}: the run that wrote the file knew of no errors, as no array steered "
                    "it, or with --method tetfuse: give --tets or --reduction",
                    request_.input));
  }
  if (request_.max_error && known != FusionErrors::kLargest) {
    throw Error(
        ErrorCode::kUsage,
        fmt::format("{}: the run that wrote the file did not measure errors at points, which "
                    "takes --max-error there (100% if need be): give --max-rms, --tets or "
                    "--reduction",
                    request_.input));
  }
}

std::uint64_t Job::tets_goal() const {
  if (request_.tets) return *request_.tets;
  if (!request_.reduction) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(
      std::ceil(static_cast<double>(file_.counts().tets) * (1 - *request_.reduction) - 1e-6));
}

std::unique_ptr<RefinableMesh> Job::read_base() const {
  const ProgressiveDescription& d = file_.description();
  auto mesh =
      std::make_unique<RefinableMesh>(file_.counts(), d.point_row_bytes(), d.cell_row_bytes(),
                                      [this](const std::string& what) { file_.fail(what); });
  for (std::size_t i = 0; i < file_.parts_of_points(); ++i) mesh->add_points(file_.points(i));
  for (std::size_t i = 0; i < file_.parts_of_tets(); ++i) mesh->add_tets(file_.tets(i));
  for (std::size_t i = 0; i < file_.parts_of_lower(); ++i) mesh->add_lower(file_.lower(i));
  if (mesh->tets() != file_.counts().base_tets) {
    file_.fail("the file has not the tetrahedra it names");
  }
  return mesh;
}

// Calls f(record, number).
template <class F>
void Job::for_each_fusion(double from, double to, F f) const {
  std::uint64_t number = 0;
  for (std::size_t b = 0; b < file_.blocks(); ++b) {
    context_.check();
    context_.report("refining", from, to, b, file_.blocks());
    FusionBlock block = file_.block(b);
    for (std::size_t i = 0; i < block.size(); ++i) {
      f(block.next(), number++);
    }
  }
  check_count(number);
}

void Job::check_count(std::uint64_t fusions) const {
  if (fusions != file_.counts().fusions) file_.fail("the file has not the fusions it names");
}

// Goes all the way back, to see what lies in the region, and what has to be undone for it.
void Job::find_needed() {
  const std::unique_ptr<RefinableMesh> mesh = read_base();
  FusionNeeds needs(file_.counts().points, file_.counts().cells);
  const std::size_t row = file_.description().point_row_bytes();
  for_each_fusion(0, kRegionShare, [&](const FusionRecord& record, std::uint64_t) {
    mesh->undo(record);
    needs.add(record, record.row_changed(row), mesh->star());
    errors_.push_back(record.error);
  });
  add_rest(mesh.get());
  const Vector<std::uint8_t> inside = points_inside(*mesh, file_, request_.region);
  report_.inside = static_cast<std::uint64_t>(std::count(inside.begin(), inside.end(), 1));
  needed_ = needs.of_region(*mesh, inside);
  report_.needed = static_cast<std::uint64_t>(std::count(needed_.begin(), needed_.end(), 1));
}

// Beyond it no fusion has a larger error.
void Job::find_end() {
  if (!error_goal()) return;
  const auto limit = *error_goal();
  const auto is_over = [&](float error) { return !(double{error} <= limit); };
  end_ = 0;
  if (!needed_.empty()) {
    for (std::size_t i = 0; i < needed_.size(); ++i) {
      if (needed_[i] != 0 && is_over(errors_[i])) end_ = i + 1;
    }
    return;
  }
  const Vector<float> largest = file_.errors();
  std::size_t last = largest.size();
  while (last > 0 && !is_over(largest[last - 1])) --last;
  if (last == 0) return;
  for (std::size_t b = 0; b + 1 < last; ++b) end_ += file_.fusions_of(b);
  const FusionBlock block = file_.block(last - 1);
  std::size_t count = block.size();
  while (count > 0 && !is_over(block.errors()[count - 1])) --count;
  end_ += count;
}

void Job::undo(RefinableMesh* mesh) {
  report_.reached = mesh->tets() <= tets_goal();
  find_end();
  if (request_.region.empty()) {
    undo_everywhere(mesh);
  } else {
    undo_needed(mesh);
  }
}

void Job::undo_everywhere(RefinableMesh* mesh) {
  const std::uint64_t goal = tets_goal();
  const Vector<float> largest = file_.errors();
  const auto note_rest = [this](std::span<const float> errors) {
    for (const float error : errors) report_.error = std::max(report_.error, double{error});
  };
  for (std::size_t b = 0; b < file_.blocks(); ++b) {
    context_.check();
    context_.report("refining", 0, kRefineShare, b, file_.blocks());
    if (report_.undone >= end_) return note_rest(std::span(largest).subspan(b));
    FusionBlock block = file_.block(b);
    for (std::size_t i = 0; i < block.size(); ++i) {
      const FusionRecord record = block.next();
      if (report_.undone >= end_ || mesh->tets() + record.tets.size() > goal) {
        note_rest(block.errors().subspan(i));
        return note_rest(std::span(largest).subspan(b + 1));
      }
      mesh->undo(record);
      ++report_.undone;
    }
  }
  check_count(report_.undone);
}

void Job::undo_needed(RefinableMesh* mesh) {
  const std::uint64_t goal = tets_goal();
  bool goes_on = true;
  for_each_fusion(kRegionShare, kRefineShare, [&](const FusionRecord& record, std::uint64_t i) {
    if (needed_[i] != 0) {
      goes_on = goes_on && i < end_ && mesh->tets() + record.tets.size() <= goal;
      if (goes_on) {
        mesh->undo(record);
        ++report_.undone;
        return;
      }
      report_.error_inside = std::max(report_.error_inside, double{record.error});
    }
    report_.error = std::max(report_.error, double{record.error});
  });
}

// When all fusions have been undone.
void Job::add_rest(RefinableMesh* mesh) const {
  for (std::size_t i = 0; i < file_.parts_of_spare(); ++i) mesh->add_points(file_.spare(i));
  for (std::size_t i = 0; i < file_.parts_of_rewound(); ++i) mesh->rewind(file_.rewound(i));
  const ProgressiveCounts& counts = file_.counts();
  if (mesh->points() != counts.points || mesh->cells() != counts.cells ||
      mesh->tets() != counts.tets) {
    file_.fail("the file has not the points and cells it names");
  }
}

RefineReport Job::run(PhaseClock* clock) {
  report_.counts = file_.counts();
  report_.file_bytes = file_.bytes();
  report_.errors = file_.description().errors;
  context_.report_size(report_.counts.tets);
  if (!request_.region.empty()) {
    clock->begin("region");
    find_needed();
    clock->begin("read");
  }
  const std::unique_ptr<RefinableMesh> mesh = read_base();
  clock->begin("undo");
  undo(mesh.get());
  if (report_.undone == report_.counts.fusions) add_rest(mesh.get());
  file_.check();
  WriteOptions write = request_.write;
  write.progress = [&](double share) {
    context_.check();
    context_.report("writing", kRefineShare + (1 - kRefineShare) * share);
  };
  report_.tets = mesh->tets();
  report_.points = mesh->points();
  clock->begin("write");
  write_level(*mesh, file_, request_.output, write);
  clock->end();
  return report_;
}

}  // namespace

RefineReport refine(const RefineRequest& request, const RunContext& context) {
  check_request(request);
  context.report("reading", 0);
  PhaseClock clock;
  clock.begin("read");
  RefineReport report = Job(request, context).run(&clock);
  report.seconds = clock.seconds();
  context.report("done", 1);
  return report;
}

}  // namespace tetfusion
