// The command with its work in a shuffled order, and some of it late: scrambled SEED ARGUMENTS...
#include <unistd.h>

#include <charconv>
#include <cstring>
#include <iostream>
#include <vector>

#include "cli/command_line.h"
#include "support/scrambled_schedule.h"

int main(int argc, char** argv) {
  std::uint64_t seed = 0;
  const char* const end = argc > 2 ? argv[1] + std::strlen(argv[1]) : nullptr;
  if (argc < 3 || std::from_chars(argv[1], end, seed).ptr != end) {
    std::cerr << "Usage: scrambled SEED COMMAND [ARGUMENTS]\n";
    return 2;
  }
  const tetfusion::testing::ScrambledSchedule schedule(seed);
  std::vector<const char*> arguments{argv[0]};
  arguments.insert(arguments.end(), argv + 2, argv + argc);
  const int code =
      tetfusion::run_command_line(static_cast<int>(arguments.size()), arguments.data());
  std::cerr << schedule.moved() << " pieces of work began at another's turn\n";
  return code;
}
