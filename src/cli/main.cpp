// The command `tetfusion`. Exit codes: 0 done; 1 check found the mesh invalid, compare a
// bound broken, or simplify --verify a promise; 2 usage; 3 bad input; 4 reading or writing failed;
// 5 out of memory; 6 the goal was not reached, with --strict; 130 interrupted.
#include <CLI/CLI.hpp>
#include <exception>
#include <new>
#include <string>

#include "base/error.h"
#include "base/resources.h"
#include "base/version.h"
#include "cli/commands.h"
#include "cli/console.h"

namespace {

int run(int argc, char** argv) {
  CLI::App app{
      "Simplifies tetrahedral meshes: TetFusion (Chopra & Meyer, IEEE Visualization 2002)"};
  app.set_version_flag("--version", "tetfusion " + tetfusion::version());
  app.require_subcommand(1);
  app.get_formatter()->column_width(34);
  app.footer("'tetfusion COMMAND --help' explains a command.");
  tetfusion::add_simplify_command(app);
  tetfusion::add_info_command(app);
  tetfusion::add_check_command(app);
  tetfusion::add_compare_command(app);
  tetfusion::add_apply_command(app);
  tetfusion::add_convert_command(app);
  tetfusion::add_generate_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // --help, --version
    tetfusion::print_error(std::string(e.what()) + "; see 'tetfusion --help'");
    return static_cast<int>(tetfusion::ErrorCode::kUsage);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  tetfusion::open_standard_streams();
  tetfusion::catch_interrupts();
  tetfusion::return_freed_memory();
  try {
    return run(argc, argv);
  } catch (const tetfusion::ExitStatus& status) {
    return status.code;
  } catch (const tetfusion::Error& e) {
    tetfusion::print_error(e.what());
    return e.exit_code();
  } catch (const std::bad_alloc&) {
    tetfusion::print_error("out of memory: the mesh is larger than this machine holds");
    return static_cast<int>(tetfusion::ErrorCode::kMemory);
  } catch (const std::exception& e) {
    tetfusion::print_error(e.what());
    return static_cast<int>(tetfusion::ErrorCode::kIo);
  }
}
