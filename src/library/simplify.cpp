#include <exception>
#include <new>
#include <utility>

#include "base/error.h"
#include "base/resources.h"
#include "base/version.h"
#include "driver/simplify.h"
#include "io/files/file_system.h"
#include "io/source/chosen_patches.h"
#include "library/owned_sink.h"
#include "library/requests.h"
#include "library/run_thread.h"

namespace tetfusion {

namespace {

// A new name in the folder, so that several processes can share it, on several hosts, too.
std::string scratch_in(const std::string& folder) {
  if (folder.empty()) return "";
  return folder + "/" + temporary_name();
}

// As Options::memory says.
std::uint64_t memory_of(const Options& options) {
  const int runs = runs_of_process();
  if (options.memory != 0 || runs <= 1) return options.memory;
  return memory_limit() / 2 / static_cast<std::uint64_t>(runs);
}

void run(const Mesh& mesh, const Options& options, const Observer& observer, Result* result) {
  OwnedSink sink(mesh);
  run_observed(observer, [&](const RunContext& context) {
    SimplifyRequest request = to_request(options);
    request.performance.memory = memory_of(options);
    request.performance.scratch = scratch_in(options.scratch);
    auto source = open_view(to_view(mesh), {.tetrahedralize = options.tetrahedralize,
                                            .linearize = options.linearize,
                                            .drop_patches = options.drop_patches});
    if (!options.drop_patch.empty()) {
      source = without_patches(std::move(source), options.drop_patch);
    }
    const double cpu_before = cpu_seconds();
    check_steering(options, source->description());
    SimplifyReport report = simplify(request, std::move(source), &sink, context);
    report.cpu_seconds -= cpu_before;
    if (options.strict && report.has_goal && report.stop_reason != StopReason::kGoal) {
      result->status = {Code::kGoalNotReached, report.stop_sentence()};
    }
    result->report = to_report(report);
  });
  result->mesh = sink.take();
}

}  // namespace

OwnedValues::OwnedValues(Type type, std::size_t size) : type_(type), size_(size) {
  if (size == 0) return;
  if (size > static_cast<std::size_t>(-1) / bytes_of(type)) throw std::bad_alloc();
  data_.reset(std::malloc(size * bytes_of(type)));
  if (!data_) throw std::bad_alloc();
}

Result simplify(const Mesh& mesh, const Options& options, const Observer& observer) noexcept {
  Result result;
  const auto fail = [&](Code code, std::string message) {
    result = Result();
    result.status = {code, std::move(message)};
  };
  try {
    try {
      run(mesh, options, observer, &result);
    } catch (const Error& error) {
      fail(static_cast<Code>(error.exit_code()), in_words_of_library(error.what()));
    } catch (const std::bad_alloc&) {
      fail(Code::kMemory, "out of memory");
    } catch (const std::exception& error) {
      fail(Code::kIo, error.what());
    }
  } catch (...) {  // no memory for the message
    fail(Code::kMemory, {});
  }
  return result;
}

const char* library_version() noexcept {
  static const std::string text = version();
  return text.c_str();
}

}  // namespace tetfusion
