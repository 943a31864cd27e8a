// What the command says to people: notices, a progress bar, errors; all on standard error. And the options that
// several subcommands share.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <string_view>

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

// From now on Ctrl-C asks running jobs to stop; a second one ends the process.
void catch_interrupts();

}  // namespace tetfusion
