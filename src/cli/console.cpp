#include "cli/console.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <map>
#include <string_view>

#include "base/error.h"
#include "base/numbers.h"
#include "base/resources.h"
#include "io/files/output_file.h"
#include "io/mesh_format.h"

namespace tetfusion {

namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

extern "C" void on_interrupt(int signal_number) {
  interrupted.store(true, std::memory_order_relaxed);
  std::signal(signal_number, SIG_DFL);
}

ProgressBar::Style bar_style(const ConsoleOptions& options) {
  if (options.quiet || options.progress == "never") return ProgressBar::Style::kNone;
  const char* terminal = std::getenv("TERM");
  const bool erases = terminal == nullptr || std::string_view(terminal) != "dumb";
  if (::isatty(STDERR_FILENO) == 1 && erases) return ProgressBar::Style::kBar;
  return options.progress == "always" ? ProgressBar::Style::kLines : ProgressBar::Style::kNone;
}

std::uint64_t parse_time_step(const std::string& text) {
  constexpr std::size_t kMostDigits = 18;
  if (text == "last") return kLastTimeStep;
  const auto is_digit = [](unsigned char c) { return std::isdigit(c) != 0; };
  if (text.empty() || text.size() > kMostDigits ||
      !std::all_of(text.begin(), text.end(), is_digit)) {
    throw Error(ErrorCode::kUsage,
                fmt::format("--time-step {}: give a whole number, counted from 0, or last", text));
  }
  return std::stoull(text);
}

std::uint64_t parse_memory(const std::string& text) {
  const auto bytes = parse_bytes(text);
  if (!bytes || *bytes == 0) {
    throw Error(
        ErrorCode::kUsage,
        fmt::format("--memory {}: give a size, as in 2G, 512M or 1.5G (powers of 1024)", text));
  }
  const bool has_unit = text.find_first_not_of("0123456789.") != std::string::npos;
  if (!has_unit && *bytes < (std::uint64_t{1} << 20)) {
    throw Error(ErrorCode::kUsage, fmt::format("--memory {0}: that is {1}; is {0}G or {0}M meant?",
                                               text, format_count(*bytes, "byte")));
  }
  return *bytes;
}

}  // namespace

void add_console_options(CLI::App& command, ConsoleOptions* options, const char* verbose) {
  command
      .add_option("--progress", options->progress,
                  "Progress on standard error: auto (a bar, on a terminal only), always (elsewhere "
                  "a line for each tenth and phase), never")
      ->check(CLI::IsMember({"auto", "always", "never"}))
      ->capture_default_str()
      ->group(kMessagesGroup);
  command.add_flag("--quiet,-q", options->quiet, "Say nothing but errors")->group(kMessagesGroup);
  command.add_flag("--verbose,-v", options->verbose, verbose)->group(kMessagesGroup);
}

void add_cell_flags(CLI::App& command, bool* tetrahedralize, bool* linearize, bool* merge_points,
                    bool* drop_patches, std::vector<std::string>* dropped_patches) {
  command
      .add_flag(
          "--tetrahedralize", *tetrahedralize,
          "Split hexahedra, voxels, wedges and pyramids into tetrahedra; polyhedra, too, round a "
          "point in their middle")
      ->group(kInputGroup);
  command
      .add_flag("--linearize", *linearize,
                "Take cells of higher order, as ten-node tetrahedra, as straight-edged ones: by "
                "their corners")
      ->group(kInputGroup);
  command
      .add_flag(
          "--merge-points", *merge_points,
          "Take points with the same coordinates for one, with the values of the first: where "
          "each cell has points of its own. Closes cracks")
      ->group(kInputGroup);
  command
      .add_flag("--drop-patches", *drop_patches,
                "Leave out what there is beside tetrahedra: triangles of boundary patches, which "
                "hold the boundary where they lie, lines and points")
      ->group(kInputGroup);
  command
      .add_option("--drop-patch", *dropped_patches,
                  "Leave out one patch alone, so that the boundary may move there: the name of a "
                  "block, or ARRAY=VALUE of a cell array; may be given again")
      ->allow_extra_args(false)
      ->check(not_empty)
      ->group(kInputGroup);
}

void add_time_step_option(CLI::App& command, std::optional<std::uint64_t>* step,
                          const std::string& by_default) {
  command
      .add_option_function<std::string>(
          "--time-step", [step](const std::string& text) { *step = parse_time_step(text); },
          "Of a file with several time steps of its own (Exodus, EnSight, OpenFOAM, CGNS, "
          "XDMF), or of a list of them (.pvd), the one to read, counted from 0, or last. "
          "Default: " +
              by_default)
      ->group(kInputGroup);
}

void add_input_options(CLI::App& command, std::string* input, OpenOptions* open,
                       const std::string& step_by_default) {
  command.add_option("IN", *input, "The mesh, or - for standard input")
      ->required()
      ->check(not_empty);
  add_cell_options(command, open);
  add_time_step_option(command, &open->time_step, step_by_default);
}

void add_report_option(CLI::App& command, std::string* report) {
  command
      .add_option("--report", *report, "Write a JSON report to this file; - for standard output")
      ->check(not_empty)
      ->group(kOutputGroup);
}

void add_thread_option(CLI::App& command, int* threads) {
  command
      .add_option(
          "--threads", *threads,
          "Threads to use; 0 is what OMP_NUM_THREADS says, or one for each processor that the "
          "command may use. The result does not depend on it")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str()
      ->group(kPerformanceGroup);
}

void add_memory_option(CLI::App& command, std::uint64_t* memory, const char* help) {
  command
      .add_option_function<std::string>(
          "--memory", [memory](const std::string& text) { *memory = parse_memory(text); }, help)
      ->check(not_empty)
      ->group(kPerformanceGroup);
}

CLI::Option* add_nameless_scratch_option(CLI::App& command, std::string* scratch,
                                         const std::string& help) {
  return command
      .add_option("--scratch", *scratch,
                  help +
                      ", in files without names. Default: that of the output, or $TMPDIR or /tmp "
                      "for standard output")
      ->check(CLI::ExistingDirectory)
      ->group(kPerformanceGroup);
}

void add_memory_options(CLI::App& command, std::uint64_t* memory, std::string* scratch) {
  add_memory_option(
      command, memory,
      "Memory to take at most, as in 2G, 512M or 1.5G; a mesh that does not fit is looked at "
      "in chunks, with the same findings. Default: half of what the machine or its control "
      "group allows");
  command
      .add_option("--scratch", *scratch,
                  "Folder in which a folder is made for chunks that do not fit into memory, and "
                  "removed again. Default: $TMPDIR or /tmp")
      ->check(CLI::ExistingDirectory)
      ->group(kPerformanceGroup);
}

void add_encoding_option(CLI::App& command, Encoding* encoding) {
  static const std::map<std::string, Encoding> kNames{{"raw", Encoding::kRaw},
                                                      {"zlib", Encoding::kZlib},
                                                      {"lz4", Encoding::kLz4},
                                                      {"inline", Encoding::kInline},
                                                      {"ascii", Encoding::kAscii}};
  add_choice(command, "--encoding", encoding, kNames,
             "Encoding of the .vtu written: raw, zlib, lz4 (appended), inline (base64), ascii; "
             "of a .vtk or .msh raw (binary) or ascii")
      ->default_str("raw")
      ->group(kOutputGroup);
}

Console::Console(const ConsoleOptions& options)
    : quiet_(options.quiet),
      verbose_(options.verbose && !options.quiet),
      start_(wall_seconds()),
      bar_(bar_style(options), interrupted) {}

void Console::tell_time_step(const std::optional<std::uint64_t>& chosen,
                             const MeshDescription& mesh) {
  if (chosen || mesh.time_steps.size() < 2) return;
  say(fmt::format("{}: of {} time steps number {} is read (--time-step takes another one)",
                  mesh.path, format_count(mesh.time_steps.size()), mesh.time_step));
}

void Console::say(std::string_view message) {
  if (!quiet_) bar_.print_line(message);
}

void Console::detail(std::string_view message) {
  if (verbose_) say(message);
}

void Console::detail_resources() {
  detail(fmt::format("{:.2f} s, {:.2f} s of processor time, {} at the peak",
                     wall_seconds() - start_, cpu_seconds(), format_bytes(peak_rss_bytes())));
}

RunContext Console::context() {
  RunContext context;
  context.progress = [this](std::string_view phase, double share) { bar_.report(phase, share); };
  context.size = [this](std::uint64_t tets) { bar_.set_tets(tets); };
  context.notice = [this](std::string_view message) { say(message); };
  context.cancelled = &interrupted;
  return context;
}

void print_error(std::string_view message) {
  put_message(fmt::format("tetfusion: error: {}", message));
}

void write_text(const std::string& path, const std::string& text) {
  OutputFile file(path);
  file.append(text.data(), text.size());
  file.commit();
}

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_interrupt;  // no SA_RESTART: a read that waits for a pipe ends too
  for (const int s : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction before {};
    const bool is_ignored = ::sigaction(s, nullptr, &before) == 0 && before.sa_handler == SIG_IGN;
    if (!is_ignored) ::sigaction(s, &action, nullptr);  // nohup has it ignored
  }
  // A closed pipe and a file grown too large are write errors with a message.
  for (const int s : {SIGPIPE, SIGXFSZ}) std::signal(s, SIG_IGN);
}

void open_standard_streams() {
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd) {
    if (::fcntl(fd, F_GETFD) >= 0) continue;
    // It gets this number, the lowest that is free.
    static_cast<void>(::open("/dev/null", fd == STDOUT_FILENO ? O_RDONLY : O_RDWR));
  }
}

void check_report(const std::string& path, const std::vector<std::string>& others) {
  refuse_same_file("--report", path, others);
  if (!path.empty()) check_output_path(path);
}

void check_report_beside(const std::string& mesh, const std::string& path,
                         std::vector<std::string> others) {
  if (path == "-" && mesh == "-") {
    throw Error(ErrorCode::kUsage, "the mesh and the report cannot both go to standard output");
  }
  others.push_back(mesh);
  check_report(path, others);
}

double parse_share_of_range(std::string_view option, const std::string& text,
                            std::string_view example) {
  const auto share = parse_share(text);
  if (!share) refuse(fmt::format("{} {}: give a share, as in {}", option, text, example));
  if (*share > 1) {
    refuse(fmt::format("{} {}: that is {:.6g} % of the range; give 100% or less, as in 5% or 0.05",
                       option, text, 100 * *share));
  }
  if (is_bare_one(text)) refuse(fmt::format("{} {}: give 100% or 1%", option, text));
  return *share;
}

std::uint64_t parse_tets(const std::string& option, const std::string& text) {
  const auto count = parse_count(text);
  if (!count) {
    throw Error(ErrorCode::kUsage,
                fmt::format("{} {}: give a whole number, as in 100000, 100k or 2M", option, text));
  }
  return *count;
}

std::string not_empty(const std::string& value) {
  return value.empty() ? "the value is empty" : "";
}

}  // namespace tetfusion
