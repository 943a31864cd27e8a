// The command `tetfusion`. Exit codes: 0 done; 1 check found the mesh invalid, compare a
// bound broken, or simplify --verify a promise; 2 usage; 3 bad input; 4 reading or writing failed;
// 5 out of memory; 6 the goal was not reached, with --strict; 130 interrupted.
#include "base/resources.h"
#include "cli/command_line.h"
#include "cli/console.h"

int main(int argc, char** argv) {
  tetfusion::open_standard_streams();
  tetfusion::catch_interrupts();
  tetfusion::return_freed_memory();
  return tetfusion::run_command_line(argc, argv);
}
