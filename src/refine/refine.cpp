#include "refine/refine.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>

#include "base/numbers.h"
#include "base/resources.h"
#include "io/files/file_system.h"
#include "io/left_out.h"
#include "io/mesh_format.h"
#include "mesh/regions/region_of_interest.h"
#include "refine/blocks_ahead.h"
#include "refine/fusion_needs.h"
#include "refine/fusion_spool.h"
#include "refine/points_inside.h"
#include "refine/refinable_mesh.h"
#include "refine/resident_limit.h"
#include "refine/write_level.h"

namespace tetfusion {

namespace {

// Shares of the work that are done when it is known what a region needs, and when the mesh is
// refined.
constexpr double kRegionShare = 0.4;
constexpr double kRefineShare = 0.6;

// With the mesh on disk: the program, blocks of the file, the writer's buffers, and what may be
// touched until somebody looks whether it is too much.
constexpr std::uint64_t kLeastMemory = std::uint64_t{128} << 20;
constexpr std::uint64_t kMargin = std::uint64_t{64} << 20;
// Of field data: the file's, the output's, and while the file is opened what it was read from.
constexpr std::uint64_t kFieldCopies = 3;
constexpr std::uint64_t kFieldRoom = std::uint64_t{1} << 20;  // in kLeastMemory
// Of the largest block: inflated, made to records, and the next one ahead of it.
constexpr std::uint64_t kBlockCopies = 5;
constexpr std::uint64_t kBlockRoom = std::uint64_t{32} << 20;  // in kLeastMemory

class Job {
 public:
  Job(const RefineRequest& request, const RunContext& context)
      : request_(request), context_(context), file_(ProgressiveFile::open(request.input)) {
    check_errors_are_known();
    tell_left_out();
    const RegionOfInterest region(request.region, request.input,
                                  file_.description().point_data);  // or throws now
    plan_memory();
  }
  RefineReport run(PhaseClock* clock);

 private:
  void check_errors_are_known() const;
  void tell_left_out() const;
  void plan_memory();
  std::optional<double> error_goal() const {
    return request_.max_error ? request_.max_error : request_.max_rms;
  }
  std::uint64_t tets_goal() const;
  std::unique_ptr<RefinableMesh> read_base();
  void let_go(const RefinableMesh& mesh) const;
  template <class F>
  void for_each_part(std::size_t parts, F f) const {
    for (std::size_t i = 0; i < parts; ++i) {
      context_.check();
      f(i);
    }
  }
  template <class F>
  void for_each_fusion(double from, double to, const RefinableMesh* mesh, F f) const;
  void find_needed();
  void find_end();
  void check_count(std::uint64_t fusions) const;
  void undo(RefinableMesh* mesh);
  void undo_everywhere(RefinableMesh* mesh);
  std::size_t undo_block(FusionBlock* block, RefinableMesh* mesh);
  void undo_spooled(RefinableMesh* mesh);
  void undo_needed(RefinableMesh* mesh);
  void add_rest(RefinableMesh* mesh);

  const RefineRequest& request_;
  const RunContext& context_;
  ProgressiveFile file_;
  RefineReport report_;
  std::string folder_;  // for what is not in memory; empty: all is
  ResidentLimit limit_{0};
  std::optional<FusionSpool> spool_;
  std::uint64_t tets_ = 0;  // with the fusions that have been read
  // With a region: which fusions are to be undone.
  Vector<std::uint8_t> needed_;
  Vector<float> errors_;                                           // of all fusions
  std::uint64_t end_ = std::numeric_limits<std::uint64_t>::max();  // none from here on is undone
};

// Of the tetrahedra that come back, those of about two fusions.
void expect_next(const FusionBlock& block, const RefinableMesh* mesh) {
  constexpr std::size_t kTets = 12;
  const std::span<const TetId> tets = block.tets_ahead();
  mesh->expect(block.kept_ahead(), tets.first(std::min(tets.size(), kTets)));
}

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
  if (request_.max_rms && known == FusionErrors::kLargest) {
    throw Error(ErrorCode::kUsage,
                fmt::format("{}: the run that wrote the file measured errors at points: give "
                            "--max-error",
                            request_.input));
  }
}

// What the output's format has no place for.
void Job::tell_left_out() const {
  const ProgressiveDescription& d = file_.description();
  MeshDescription mesh;
  mesh.point_data = d.point_data;
  mesh.cell_data = d.cell_data;
  for (const DataArray& array : d.field_data) mesh.field_data.arrays.push_back(array.info);
  const std::string left_out = left_out_of(request_.output, mesh);
  if (!left_out.empty()) context_.say(left_out);
}

void Job::plan_memory() {
  const std::uint64_t total = memory_to_use(request_.memory);
  const ProgressiveCounts& counts = file_.counts();
  const ProgressiveDescription& d = file_.description();
  std::uint64_t fields = 0;
  for (const DataArray& array : d.field_data) fields += kFieldCopies * array.bytes.size();
  const auto beyond = [](std::uint64_t bytes, std::uint64_t room) {
    return bytes - std::min(bytes, room);
  };
  const std::uint64_t program = kLeastMemory + beyond(fields, kFieldRoom) +
                                beyond(kBlockCopies * file_.largest_block(), kBlockRoom);
  std::uint64_t least = program, beside = LevelNumbers::bytes_for(counts);
  if (!request_.region.empty()) {
    least += counts.fusions * 5 + counts.points;
    beside = std::max(beside, FusionNeeds::bytes_for(counts)) + counts.fusions * 5 + counts.points;
  }
  const std::uint64_t mesh =
      RefinableMesh::bytes_for(counts, d.point_row_bytes(), d.cell_row_bytes());
  const std::uint64_t in_core = program + mesh + beside;
  if (in_core <= total) return;
  if (total < least) {
    throw Error(ErrorCode::kMemory,
                fmt::format("{}: refining this mesh needs about {} of memory with the mesh on disk "
                            "(and {} with everything in memory), but it may use {}: give --memory "
                            "{}M or more",
                            request_.input, format_bytes(least), format_bytes(in_core),
                            format_bytes(total), (least + (1 << 20) - 1) >> 20));
  }
  context_.say(
      fmt::format("the mesh is kept on disk, as it would take about {} in memory; that is "
                  "slow where the input's points and cells lie in no order",
                  format_bytes(in_core)));
  folder_ = request_.scratch.empty() ? output_folder(request_.output) : request_.scratch;
  limit_ = ResidentLimit(total - kMargin);
  report_.on_disk = true;
}

std::uint64_t Job::tets_goal() const {
  if (request_.tets) return *request_.tets;
  if (!request_.reduction) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(
      std::ceil(static_cast<double>(file_.counts().tets) * (1 - *request_.reduction) - 1e-6));
}

void Job::let_go(const RefinableMesh& mesh) const {
  mesh.let_go();
  file_.let_go();
}

std::unique_ptr<RefinableMesh> Job::read_base() {
  const ProgressiveDescription& d = file_.description();
  auto mesh = std::make_unique<RefinableMesh>(
      file_.counts(), d.point_row_bytes(), d.cell_row_bytes(),
      [this](const std::string& what) { file_.fail(what); }, folder_);
  const auto keep = [&] { limit_.keep([&] { let_go(*mesh); }); };
  for_each_part(file_.parts_of_points(),
                [&](std::size_t i) { mesh->add_points(file_.points(i), keep); });
  for_each_part(file_.parts_of_tets(), [&](std::size_t i) { mesh->add_tets(file_.tets(i), keep); });
  for_each_part(file_.parts_of_lower(), [&](std::size_t i) { mesh->add_lower(file_.lower(i)); });
  if (mesh->tets() != file_.counts().base_tets) {
    file_.fail("the file has not the tetrahedra it names");
  }
  return mesh;
}

// Calls f(record, number).
template <class F>
void Job::for_each_fusion(double from, double to, const RefinableMesh* mesh, F f) const {
  std::uint64_t number = 0;
  BlocksAhead blocks(file_);
  for (std::size_t b = 0; b < file_.blocks(); ++b) {
    context_.check();
    context_.report("refining", from, to, b, file_.blocks());
    FusionBlock block = blocks.take();
    for (std::size_t i = 0; i < block.size(); ++i) {
      const FusionRecord record = block.next();
      expect_next(block, mesh);
      f(record, number++);
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
  FusionNeeds needs(file_.counts().points, file_.counts().cells, folder_);
  const auto let_go_of_all = [&] {
    let_go(*mesh);
    needs.let_go();
  };
  const std::size_t row = file_.description().point_row_bytes();
  errors_.reserve(file_.counts().fusions);
  for_each_fusion(0, kRegionShare, mesh.get(), [&](const FusionRecord& record, std::uint64_t) {
    mesh->undo(record);
    needs.add(record, record.row_changed(row), mesh->star());
    errors_.push_back(record.error);
    limit_.keep(let_go_of_all);
  });
  add_rest(mesh.get());
  const Vector<std::uint8_t> inside =
      points_inside(*mesh, file_, request_.region, [&] { limit_.keep(let_go_of_all); });
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
  const Vector<float> largest = file_.facts().errors;
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

// In the file's order; on disk a round's chunks one after another.
void Job::undo_everywhere(RefinableMesh* mesh) {
  const ProgressiveFile::BlockFacts facts = file_.facts();
  const auto note_rest = [this](std::span<const float> errors) {
    for (const float error : errors) report_.error = std::max(report_.error, double{error});
  };
  if (report_.on_disk) spool_.emplace(folder_);
  tets_ = mesh->tets();
  std::size_t left = 0, b = 0;
  BlocksAhead blocks(file_);
  for (; b < file_.blocks() && report_.undone < end_ && left == 0; ++b) {
    context_.check();
    context_.report("refining", 0, kRefineShare, b, file_.blocks());
    if (b > 0 && facts.rounds[b] != facts.rounds[b - 1]) undo_spooled(mesh);
    FusionBlock block = blocks.take();
    left = undo_block(&block, mesh);
    note_rest(block.errors().last(left));
  }
  undo_spooled(mesh);
  note_rest(std::span(facts.errors).subspan(b));
  if (b == file_.blocks() && left == 0) check_count(report_.undone);
}

// As far as the goal allows. Returns how many records are left.
std::size_t Job::undo_block(FusionBlock* block, RefinableMesh* mesh) {
  const std::uint64_t goal = tets_goal();
  for (std::size_t i = 0; i < block->size(); ++i) {
    const FusionRecord record = block->next();
    tets_ += record.tets.size();
    if (report_.undone >= end_ || tets_ > goal) return block->size() - i;
    ++report_.undone;
    if (spool_) {
      spool_->add(record, block->chunks()[i]);
    } else {
      expect_next(*block, mesh);
      mesh->undo(record);
    }
  }
  return 0;
}

void Job::undo_spooled(RefinableMesh* mesh) {
  if (!spool_) return;
  spool_->take([&](const FusionLog& log) {
    context_.check();
    for (std::size_t i = 0; i < log.size(); ++i) {
      mesh->undo(log[i]);
      limit_.keep([&] { let_go(*mesh); });
    }
  });
}

void Job::undo_needed(RefinableMesh* mesh) {
  const std::uint64_t goal = tets_goal();
  bool goes_on = true;
  for_each_fusion(kRegionShare, kRefineShare, mesh,
                  [&](const FusionRecord& record, std::uint64_t i) {
                    if (needed_[i] != 0) {
                      goes_on = goes_on && i < end_ && mesh->tets() + record.tets.size() <= goal;
                      if (goes_on) {
                        mesh->undo(record);
                        ++report_.undone;
                        limit_.keep([&] { let_go(*mesh); });
                        return;
                      }
                      report_.error_inside = std::max(report_.error_inside, double{record.error});
                    }
                    report_.error = std::max(report_.error, double{record.error});
                  });
}

// When all fusions have been undone.
void Job::add_rest(RefinableMesh* mesh) {
  const auto keep = [&] { limit_.keep([&] { let_go(*mesh); }); };
  for_each_part(file_.parts_of_spare(),
                [&](std::size_t i) { mesh->add_points(file_.spare(i), keep); });
  for_each_part(file_.parts_of_rewound(), [&](std::size_t i) { mesh->rewind(file_.rewound(i)); });
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
  write.report_to(context_, kRefineShare);
  report_.tets = mesh->tets();
  report_.points = mesh->points();
  clock->begin("write");
  write_level(*mesh, file_, request_.output, write, folder_,
              [&] { limit_.keep([&] { let_go(*mesh); }); });
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
