#include "cli/console.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <map>

#include "base/resources.h"
#include "io/output_file.h"

namespace tetfusion {

namespace {

std::atomic<bool> interrupted{false};
static_assert(std::atomic<bool>::is_always_lock_free, "set from a signal handler");

extern "C" void on_interrupt(int signal_number) {
  interrupted.store(true, std::memory_order_relaxed);
  std::signal(signal_number, SIG_DFL);
}

// A closed or full standard error must not end the job: what cannot be said is lost.
void put(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

constexpr int kBarWidth = 30;
constexpr double kSecondsBetweenDraws = 0.1;

}  // namespace

void add_console_options(CLI::App& command, ConsoleOptions* options) {
  command
      .add_option("--progress", options->progress,
                  "Progress bar on standard error: auto (on a terminal), always, never")
      ->check(CLI::IsMember({"auto", "always", "never"}))
      ->capture_default_str();
  command.add_flag("--quiet,-q", options->quiet, "Say nothing but errors");
  command.add_flag("--verbose,-v", options->verbose, "Say more: a line for each macroLoD");
}

void add_thread_option(CLI::App& command, int* threads) {
  command
      .add_option("--threads", *threads,
                  "Threads to use; 0 is one for each processor. The result does not depend on it")
      ->check(CLI::Range(0, 4096))
      ->capture_default_str();
}

void add_encoding_option(CLI::App& command, Encoding* encoding) {
  static const std::map<std::string, Encoding> kNames{{"raw", Encoding::kRaw},
                                                      {"zlib", Encoding::kZlib},
                                                      {"lz4", Encoding::kLz4},
                                                      {"inline", Encoding::kInline},
                                                      {"ascii", Encoding::kAscii}};
  command
      .add_option("--encoding", *encoding,
                  "Encoding of the .vtu written: raw, zlib, lz4 (appended), inline (base64), ascii")
      ->transform(CLI::CheckedTransformer(kNames, CLI::ignore_case).description(""))
      ->default_str("raw");
}

Console::Console(const ConsoleOptions& options)
    : quiet_(options.quiet),
      verbose_(options.verbose && !options.quiet),
      bar_(options.progress == "always" ||
           (options.progress == "auto" && !options.quiet && ::isatty(STDERR_FILENO) == 1)),
      start_(wall_seconds()) {}

Console::~Console() { erase_bar(); }

void Console::say(std::string_view message) {
  if (quiet_) return;
  erase_bar();
  put(fmt::format("{}\n", message));
}

void Console::detail(std::string_view message) {
  if (verbose_) say(message);
}

RunContext Console::context() {
  RunContext context;
  if (bar_) {
    context.progress = [this](std::string_view phase, double share) { draw(phase, share); };
  }
  context.notice = [this](std::string_view message) { say(message); };
  context.cancelled = &interrupted;
  return context;
}

void Console::draw(std::string_view phase, double share) {
  const double now = wall_seconds();
  if (share < 1 && phase == last_phase_ && now - last_draw_ < kSecondsBetweenDraws) return;
  last_draw_ = now;
  last_phase_ = phase;
  share = std::clamp(share, 0.0, 1.0);
  const int filled = static_cast<int>(share * kBarWidth);
  put(fmt::format("\r\x1b[K[{:=<{}}{: <{}}] {:3.0f} % {:<10} {:6.1f} s", "", filled, "",
                  kBarWidth - filled, 100 * share, phase, now - start_));
  drawn_ = true;
}

void Console::erase_bar() {
  if (drawn_) put("\r\x1b[K");
  drawn_ = false;
}

void print_error(std::string_view message) {
  put(fmt::format("tetfusion: error: {}\n", message));
}

void write_text(const std::string& path, const std::string& text) {
  OutputFile file(path);
  file.append(text.data(), text.size());
  file.commit();
}

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = on_interrupt;  // no SA_RESTART: a read that waits for a pipe ends too
  for (const int s : {SIGINT, SIGTERM, SIGHUP}) ::sigaction(s, &action, nullptr);
  // A closed pipe and a file grown too large are write errors with a message.
  for (const int s : {SIGPIPE, SIGXFSZ}) std::signal(s, SIG_IGN);
}

void open_standard_streams() {
  int fd = 0;
  while (fd >= 0 && fd <= STDERR_FILENO) fd = ::open("/dev/null", O_RDWR);
  if (fd > STDERR_FILENO) ::close(fd);
}

void refuse_same_file(const std::string& report, const std::vector<std::string>& meshes) {
  if (report.empty() || report == "-") return;
  const auto plain = [](const std::string& path) {
    return std::filesystem::absolute(path).lexically_normal();
  };
  for (const std::string& mesh : meshes) {
    std::error_code not_there;
    if (!std::filesystem::equivalent(report, mesh, not_there) && plain(report) != plain(mesh)) continue;
    throw Error(ErrorCode::kUsage,
                fmt::format("--report {}: that is the mesh {}; give the report a name of its own", report,
                            mesh));
  }
}

std::string not_empty(const std::string& value) { return value.empty() ? "the value is empty" : ""; }

}  // namespace tetfusion
