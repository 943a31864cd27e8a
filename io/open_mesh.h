// A mesh opened, in whatever format its content says.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "io/source/mesh_source.h"

namespace tetfusion {

// Opens a mesh of any format that this build reads. Throws Error; kUsage for a time step that is
// not there.
std::unique_ptr<MeshSource> open_mesh(const std::string& path, const OpenOptions& options = {});

// By the name of a file alone: may OpenOptions::merge_points be asked for?
bool can_merge_points(const std::string& path);

// MeshDescription::time_steps, without reading the mesh. None of what is no file, as a pipe, of
// which nothing is taken, or is not there. Of the options `memory` and `cancelled` count. Throws
// Error where the file cannot be opened, or is of a format with time steps and damaged.
std::vector<double> time_steps_of(const std::string& path, const OpenOptions& options = {});

// Which of so many `wanted` says, as in OpenOptions. Throws Error(kUsage) where it is not there.
std::size_t choose_time_step(const std::string& path, std::size_t steps,
                             std::optional<std::uint64_t> wanted);

}  // namespace tetfusion
