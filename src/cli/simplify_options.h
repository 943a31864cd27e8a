// The options of 'simplify' as they are typed, and what they mean.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "cli/console.h"
#include "driver/request/options.h"

namespace tetfusion {

// The options as they are typed.
struct SimplifyArguments {
  SimplifyRequest request;
  std::vector<std::string> inputs;
  std::string series;  // empty: as the names say
  ConsoleOptions console;
  std::string boundary = "exact";
  std::string reduction, tets, max_error, max_rms, min_quality, lods, chunk_tets, report;
  std::string scalar_tolerance, stretch_factor;
  std::string feature_angle;
  std::string aspect_ratio = "off";
  std::string max_volume = "off";
  std::vector<std::string> regions;
  bool dry_run = false;
  bool strict = false;
};

void add_simplify_options(CLI::App& command, SimplifyArguments* a);

// After the command line was read: fills in a->request. Throws Error(kUsage) for what has no
// meaning.
void parse_simplify_arguments(SimplifyArguments* a);

}  // namespace tetfusion
