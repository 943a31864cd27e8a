// What a request and the arrays of a mesh make of a run: how files are opened, how rows of its
// meshes look, and what its import looks for.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/run_context.h"
#include "driver/arrays/carried_arrays.h"
#include "driver/arrays/steering.h"
#include "driver/import/import.h"
#include "driver/request/options.h"
#include "driver/rounds/memory_plan.h"
#include "driver/rounds/original_values.h"
#include "driver/rounds/round_plan.h"
#include "io/source/mesh_source.h"
#include "io/source/mesh_stream.h"

namespace tetfusion {

// With the copy of what can be read only once in that folder.
OpenOptions open_options(const SimplifyRequest& request, const std::string& spool_folder,
                         const RunContext& context);

bool surfaces_move(const BehaviourOptions& behaviour);

// Is each result read again, or mapped, before it gets its name?
bool looks_at_result(const SimplifyRequest& request);

// Must each tetrahedron's number in the input be known in the end?
bool keeps_numbers(const SimplifyRequest& request);

// Of the arrays that are carried, those whose values are fitted to the original's in the end
// (original_values.h). Not where they are promised already, as those that steer are with a bound at
// points, or where the way back begins with those that fusions left. `regions` are cell arrays of
// the description.
ColumnsToFit columns_to_fit(const SimplifyRequest& request, const CarriedArrays& carried,
                            const std::vector<SteeringChoice>& choices,
                            const std::vector<std::size_t>& regions);

// What vertices are moved for in the end: where nothing says how each cell, or error, is to be.
MoveLimits move_limits(const BehaviourOptions& behaviour, const ColumnsToFit& columns,
                       std::span<const SteeringField> fields);

SteeringBytes steering_bytes(const SimplifyRequest& request, const MeshDescription& mesh,
                             const std::vector<SteeringChoice>& choices,
                             const std::vector<std::size_t>& regions);

// Columns of chunks: those of cell arrays of the description.
std::vector<std::uint32_t> region_columns(const CarriedArrays& carried,
                                          const std::vector<std::size_t>& regions);

// An empty mesh with the rows that the rounds need.
template <class Real>
WorkMesh<Real> run_layout(const BehaviourOptions& behaviour, const CarriedArrays& carried,
                          std::uint32_t steering_width);

// `regions` are cell arrays of the description.
ImportSettings import_settings(const BehaviourOptions& behaviour, const CarriedArrays& carried,
                               const std::vector<std::size_t>& regions,
                               std::uint32_t steering_width);

// The fields that steer; one that is carried along knows its column.
std::vector<SteeringField> fields_of(const Steering& steering, const CarriedArrays& carried);

}  // namespace tetfusion
