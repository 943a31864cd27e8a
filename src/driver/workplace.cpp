#include "driver/workplace.h"

#include <fmt/format.h>

#include <algorithm>
#include <exception>
#include <filesystem>
#include <system_error>

#include "base/numbers.h"
#include "base/resources.h"
#include "driver/export/progressive.h"
#include "driver/fingerprint.h"
#include "driver/request/stages.h"
#include "driver/run_setup.h"
#include "driver/scratch_place.h"
#include "follow/make_map.h"
#include "io/store/section_file.h"

namespace tetfusion {

namespace {

MemoryNeeds needs_of(const SimplifyRequest& request, const MeshDescription& mesh,
                     const SteeringBytes& steering, const ReaderNeeds& reader, int threads) {
  MemoryNeeds needs = estimate_needs(mesh, steering, request.behaviour.chunk_tets, threads, reader);
  // Without a goal nobody knows how large the result will be.
  const auto goal = plan_stages(request, mesh.cells).front().tets;
  if (looks_at_result(request) && goal) {
    const bool maps = !request.map.empty();
    include_verification(mesh, *goal, maps ? kMapPointBytes : 0, maps ? kMapTetBytes : 0, &needs);
  }
  if (!request.progressive.empty()) include_logs(request, mesh, threads, &needs);
  for (std::uint64_t* bytes : {&needs.in_core, &needs.out_of_core}) {
    *bytes = std::max(*bytes, request.performance.memory_afterwards);
  }
  return needs;
}

}  // namespace

Workplace::Workplace(const SimplifyRequest& request, const MeshDescription& mesh,
                     const SteeringBytes& steering, const ReaderNeeds& reader,
                     const RunContext& context)
    : request_(request) {
  const PerformanceOptions& options = request.performance;
  const std::uint64_t total = memory_to_use(options.memory);
  needs_ = fit_threads(
      total, [&](int threads) { return needs_of(request, mesh, steering, reader, threads); },
      context);
  on_disk_ = options.on_disk || needs_.in_core > total;
  if (needs_.out_of_core > total) {
    throw Error(
        ErrorCode::kMemory,
        fmt::format("{}: simplifying this mesh needs about {} of memory with its chunks on "
                    "disk (and {} with everything in memory), but it may use {}: give "
                    "--memory {}M or more",
                    request.input, format_bytes(needs_.out_of_core), format_bytes(needs_.in_core),
                    format_bytes(total), (needs_.out_of_core >> 20) + 1));
  }
  budget_ = std::make_unique<MemoryBudget>(total);
}

bool Workplace::choose_place(bool to_memory) {
  const PerformanceOptions& options = request_.performance;
  std::error_code unknown;
  const bool resume = options.resume && std::filesystem::exists(scratch_folder(request_), unknown);
  if (!on_disk_ && !resume) {
    // The same command with less memory would need it; a copy of what is no file may lie anywhere.
    if (!options.scratch.empty() && std::filesystem::is_regular_file(request_.input, unknown)) {
      check_scratch_folder(options.scratch);
    }
    return false;
  }
  if (to_memory && options.scratch.empty()) {
    throw Error(
        ErrorCode::kMemory,
        fmt::format("{}: simplifying this mesh in memory needs about {}, but it may use {}: give "
                    "--memory {}M or more, or --scratch DIR",
                    request_.input, format_bytes(needs_.in_core), format_bytes(budget_->total()),
                    (needs_.in_core >> 20) + 1));
  }
  if (request_.output == "-" && options.scratch.empty()) {
    throw Error(
        ErrorCode::kUsage,
        "the mesh does not fit into the memory that may be used, and beside standard output "
        "there is no folder to keep it in: give --scratch DIR");
  }
  on_disk_ = true;
  return resume;
}

ScratchOptions Workplace::scratch_options(const MeshDescription& mesh) const {
  return {scratch_folder(request_), fingerprint(request_, mesh), request_.performance.resume,
          needs_.scratch};
}

std::optional<Checkpoint> Workplace::open(const MeshDescription& mesh, bool to_memory) {
  const bool resume = choose_place(to_memory);
  if (!on_disk_) {
    scratch_ = memory_scratch();
    return std::nullopt;
  }
  keeps_work_ = request_.performance.keep_work && !to_memory;
  scratch_ = disk_scratch(scratch_options(mesh));
  if (!resume) return std::nullopt;
  resumable_ = true;  // what cannot be read now may be another time
  std::optional<Checkpoint> left = scratch_->resume();
  resumable_ = left.has_value();
  return left;
}

void Workplace::check_place(const MeshDescription& mesh) {
  choose_place(false);
  if (on_disk_) check_disk_scratch(scratch_options(mesh));
}

void Workplace::commit(const std::string& generation, std::span<const std::byte> state) {
  scratch_->commit(generation, state);
  resumable_ = true;
}

void Workplace::remove() {
  if (scratch_) scratch_->remove();
}

void Workplace::give_up(const Error& error) {
  if (!resumable_) {
    try {
      remove();
    } catch (const std::exception&) {
      // The first failure is the one to report.
    }
    throw;
  }
  if (dynamic_cast<const DamagedFile*>(&error) != nullptr) throw;  // nobody goes on from it
  const auto hint = [&] {
    switch (error.code()) {
      case ErrorCode::kIo:
      case ErrorCode::kInterrupted:
        return ": the same command with --resume goes on from there";
      case ErrorCode::kMemory:  // the error says what to give
        return ": then --resume goes on from there";
      default:
        return "";  // it would fail again
    }
  };
  throw Error(error.code(), fmt::format("{}; the work so far is kept in {}{}", error.what(),
                                        scratch_folder(request_), hint()));
}

}  // namespace tetfusion
