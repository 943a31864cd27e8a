#include "cli/command_line.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <exception>
#include <memory>
#include <new>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "base/error.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/console.h"

namespace tetfusion {

namespace {

// "TEXT ..." for options that take several values at once, but not for those that are given again.
class Formatter : public CLI::Formatter {
 public:
  std::string make_option_opts(const CLI::Option* option) const override {
    std::string text = CLI::Formatter::make_option_opts(option);
    constexpr std::string_view kSeveral = " ...";
    const std::size_t at = text.find(kSeveral);
    if (at != std::string::npos && !option->get_allow_extra_args()) text.erase(at, kSeveral.size());
    return text;
  }
};

// What is wrong, and whose help says more; `first` is what stands where a command should.
std::string sentence_of(const CLI::ParseError& error) {
  const std::string said = error.what();
  if (said == "--output is required") return said + ", as in -o out.vtu";
  const std::size_t end = said.find(": At Most 1 required");
  return end == std::string::npos ? said
                                  : said.substr(0, end) + " is given more than once: give it once";
}

std::string explain(const CLI::ParseError& error, const CLI::App& app, const std::string& first) {
  const auto is_meant = [&](const CLI::App* command) { return command->get_name() == first; };
  if (!app.get_subcommands(is_meant).empty()) {
    return fmt::format("{}; see 'tetfusion {} --help'", sentence_of(error), first);
  }
  const bool is_word = !first.empty() && first.front() != '-';
  const std::string what =
      is_word ? fmt::format("there is no command \"{}\"", first) : error.what();
  return what + "; see 'tetfusion --help'";
}

int parse_and_run(int argc, const char* const* argv) {
  CLI::App app{
      "Simplifies tetrahedral meshes: TetFusion (Chopra & Meyer, IEEE Visualization 2002)"};
  app.set_version_flag("--version", "tetfusion " + version());
  app.require_subcommand(1);
  app.formatter(std::make_shared<Formatter>());
  app.get_formatter()->column_width(34);
  app.footer("'tetfusion COMMAND --help' explains a command.");
  add_simplify_command(app);
  add_refine_command(app);
  add_info_command(app);
  add_check_command(app);
  add_compare_command(app);
  add_apply_command(app);
  add_convert_command(app);
  add_generate_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) {  // --help, --version
      std::ostringstream text;
      app.exit(e, text, text);
      write_text("-", text.str());
      return 0;
    }
    print_error(explain(e, app, argc > 1 ? argv[1] : ""));
    return static_cast<int>(ErrorCode::kUsage);
  }
  return 0;
}

}  // namespace

int run_command_line(int argc, const char* const* argv) noexcept try {
  return parse_and_run(argc, argv);
} catch (const ExitStatus& status) {
  return static_cast<int>(status.code);
} catch (const Error& e) {
  print_error(e.what());
  return e.exit_code();
} catch (const std::bad_alloc&) {
  print_error("out of memory: the mesh is larger than this machine holds");
  return static_cast<int>(ErrorCode::kMemory);
} catch (const std::logic_error& e) {
  print_error(fmt::format("internal error: {}; please report it, with the command", e.what()));
  return static_cast<int>(ErrorCode::kIo);
} catch (const std::exception& e) {
  print_error(e.what());
  return static_cast<int>(ErrorCode::kIo);
}

}  // namespace tetfusion
