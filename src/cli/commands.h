// The command's subcommands, one file each.
#pragma once

#include <CLI/CLI.hpp>

#include "base/error.h"

namespace tetfusion {

// Thrown by a subcommand that has done its work and ends with another exit code than 0.
struct ExitStatus {
  ErrorCode code;
};

void add_simplify_command(CLI::App& app);
void add_refine_command(CLI::App& app);
void add_info_command(CLI::App& app);
void add_check_command(CLI::App& app);
void add_compare_command(CLI::App& app);
void add_apply_command(CLI::App& app);
void add_convert_command(CLI::App& app);
void add_generate_command(CLI::App& app);

}  // namespace tetfusion
