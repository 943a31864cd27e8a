// What the command says to people: notices, a progress bar, errors; all on standard error. And the
// options that several subcommands share.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "base/run_context.h"
#include "io/mesh_sink.h"

namespace tetfusion {

struct ConsoleOptions {
  std::string progress = "auto";  // auto, always, never
  bool quiet = false;
  bool verbose = false;
};

// Adds --progress, --quiet and --verbose.
void add_console_options(CLI::App& command, ConsoleOptions* options);
// Adds --threads.
void add_thread_option(CLI::App& command, int* threads);
// Adds --encoding.
void add_encoding_option(CLI::App& command, Encoding* encoding);

class Console {
 public:
  explicit Console(const ConsoleOptions& options);
  ~Console();
  Console(const Console&) = delete;
  Console& operator=(const Console&) = delete;

  void say(std::string_view message);     // unless quiet
  void detail(std::string_view message);  // with --verbose only
  RunContext context();                   // reports here; cancelled by Ctrl-C

 private:
  void draw(std::string_view phase, double share);
  void erase_bar();

  bool quiet_;
  bool verbose_;
  bool bar_;
  bool drawn_ = false;
  double start_;
  double last_draw_ = -1;
  std::string last_phase_;
};

void print_error(std::string_view message);

// Writes text to a file whole or not at all; "-" is standard output.
void write_text(const std::string& path, const std::string& text);

// Throws Error(kUsage) when a report would overwrite a mesh. Names that are empty or "-" are no
// files.
void refuse_same_file(const std::string& report, const std::vector<std::string>& meshes);

// For CLI::Option::check: a script's empty variable is a mistake, not a missing option.
std::string not_empty(const std::string& value);

// Opens /dev/null in the place of each standard stream that is closed. Call before any file is
// opened.
void open_standard_streams();

// From now on Ctrl-C asks running jobs to stop; a second one ends the process.
void catch_interrupts();

}  // namespace tetfusion
