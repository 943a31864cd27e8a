// What the command says to people: notices, progress, errors; all on standard error. And the
// options that several subcommands share.
#pragma once

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/run_context.h"
#include "cli/progress_bar.h"
#include "io/mesh_format.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

struct ConsoleOptions {
  std::string progress = "auto";  // auto, always, never
  bool quiet = false;
  bool verbose = false;
};

// The headings of --help, in the order in which options are added.
inline constexpr const char* kInputGroup = "Input";
inline constexpr const char* kOutputGroup = "Output";
inline constexpr const char* kPerformanceGroup = "Performance";
inline constexpr const char* kMessagesGroup = "Messages";

// Adds --progress, --quiet and --verbose.
void add_console_options(CLI::App& command, ConsoleOptions* options,
                         const char* verbose = "Say more: time and memory");
// Adds --tetrahedralize, --linearize, --merge-points, --drop-patches and --drop-patch.
void add_cell_flags(CLI::App& command, bool* tetrahedralize, bool* linearize, bool* merge_points,
                    bool* drop_patches, std::vector<std::string>* dropped_patches);
// The same; `options`: OpenOptions, or what has the members of the same names.
template <class Options>
void add_cell_options(CLI::App& command, Options* options) {
  add_cell_flags(command, &options->tetrahedralize, &options->linearize, &options->merge_points,
                 &options->drop_patches, &options->dropped_patches);
}
// Adds --time-step; `by_default`: what is read without it.
inline constexpr const char* kStepByOutput =
    "the first of a file, or all where OUT is named as that of a series";
void add_time_step_option(CLI::App& command, std::optional<std::uint64_t>* step,
                          const std::string& by_default);
// Adds --threads.
void add_thread_option(CLI::App& command, int* threads);
// Adds --memory: bytes, of "2G" or "512M".
void add_memory_option(CLI::App& command, std::uint64_t* memory, const char* help);
// Adds --scratch, for what lies on the disk without a name; `help` says what that is.
CLI::Option* add_nameless_scratch_option(CLI::App& command, std::string* scratch,
                                         const std::string& help);
// Adds --memory and --scratch, for commands that only look.
void add_memory_options(CLI::App& command, std::uint64_t* memory, std::string* scratch);
// Adds an option that takes one of these names, in any case.
template <class T>
CLI::Option* add_choice(CLI::App& command, const char* option, T* value,
                        const std::map<std::string, T>& names, const char* help) {
  std::vector<std::string> all;
  for (const auto& [name, what] : names) all.push_back(name);
  CLI::Option* const added = command.add_option_function<std::string>(
      option,
      [=](const std::string& text) {
        const auto same = [&](const auto& entry) {
          return CLI::detail::to_lower(text) == entry.first;
        };
        const auto found = std::find_if(names.begin(), names.end(), same);
        if (found == names.end()) {
          throw CLI::ValidationError(
              option, fmt::format("\"{}\" is none of {}", text, fmt::join(all, ", ")));
        }
        *value = found->second;
      },
      help);
  return added->type_name(fmt::format("TEXT:{{{}}}", fmt::join(all, ",")));
}
// Adds --encoding.
void add_encoding_option(CLI::App& command, Encoding* encoding);
// Adds --report.
void add_report_option(CLI::App& command, std::string* report);
// Adds IN, what add_cell_options() adds, and --time-step.
void add_input_options(CLI::App& command, std::string* input, OpenOptions* open,
                       const std::string& step_by_default);

// All functions may be called from any thread.
class Console {
 public:
  explicit Console(const ConsoleOptions& options);

  // Where a file has several time steps, and nobody has chosen one of them.
  void tell_time_step(const std::optional<std::uint64_t>& chosen, const MeshDescription& mesh);
  void say(std::string_view message);     // unless quiet
  void detail(std::string_view message);  // with --verbose only
  void detail_resources();                // time and memory so far, with --verbose only
  RunContext context();                   // reports here; cancelled by Ctrl-C

 private:
  const bool quiet_;
  const bool verbose_;
  const double start_;
  ProgressBar bar_;
};

void print_error(std::string_view message);

// Writes text to a file whole or not at all; "-" is standard output.
void write_text(const std::string& path, const std::string& text);

// Before hours of work: Error(kUsage) if a report would overwrite one of these, Error(kIo) if it
// cannot be written. Empty: there is none.
void check_report(const std::string& path, const std::vector<std::string>& others);
// The same beside a mesh that is written; Error(kUsage) if both go to standard output.
void check_report_beside(const std::string& mesh, const std::string& path,
                         std::vector<std::string> others);

// A share of a field's range, of "1%" or "0.01". Throws Error(kUsage), for more than all, too, and
// for a bare 1, as 1% may be meant.
double parse_share_of_range(std::string_view option, const std::string& text,
                            std::string_view example);

// A number of tetrahedra, of "100k" or "2M". Throws Error(kUsage).
std::uint64_t parse_tets(const std::string& option, const std::string& text);

// For CLI::Option::check: a script's empty variable is a mistake, not a missing option.
std::string not_empty(const std::string& value);

// Opens /dev/null in the place of each standard stream that is closed, so that no file gets its
// number; what is written to standard output fails then. Call before any file is opened.
void open_standard_streams();

// From now on Ctrl-C asks running jobs to stop; a second one ends the process at once.
void catch_interrupts();

}  // namespace tetfusion
