// What a user is told of a run, in words.
#pragma once

#include <string>
#include <vector>

#include "base/error.h"
#include "base/run_context.h"
#include "driver/arrays/steering.h"
#include "driver/request/input_facts.h"
#include "driver/request/options.h"
#include "io/source/mesh_source.h"
#include "io/source/mesh_stream.h"

namespace tetfusion {

// Of an array that could have.
void say_does_not_steer(const std::string& name, const RunContext& context);

// For arrays that nobody has named; `mesh` has them, cell arrays that say regions, and others that
// follow.
void say_what_steers(std::vector<std::string> arrays, const MeshDescription& mesh,
                     const std::vector<std::size_t>& regions, const RunContext& context);

// Of an array of cells that steers.
void say_means_steer(const std::string& name, const RunContext& context);

// Where none steers, though some were tried: behind a sentence that says so, the others that could;
// empty if there is none.
std::string what_could_steer(const std::vector<SteeringChoice>& tried, const MeshDescription& mesh);

// Where there is no goal either: what to give. What was tried is the same everywhere, so a run goes
// on with it where it is named.
Error no_end_in_sight(const std::string& input, const std::vector<SteeringChoice>& tried,
                      const MeshDescription& mesh);

// What was turned, dropped, or left as it is; `linearized`: cells have lost their mid-edge nodes.
void say_what_is_odd(const InputFacts& facts, const MeshDescription& mesh, bool linearized,
                     const RunContext& context);
// Of that, what became of points that were joined.
void say_what_was_joined(const InputFacts& facts, const MeshDescription& mesh,
                         const RunContext& context);
// How much the values differ, in a few words; empty where nobody knows.
std::string describe_difference(const LargestDifference& largest, const AttributeSet& point_data);
// Where errors are bounded, and points that were joined had other values.
void say_whose_bounds(const RunContext& context);

// The cell arrays whose interfaces are kept, and those that may want it, with what to type, unless
// the user has chosen by name. `stream` is the mesh's, with so many tetrahedra.
void say_which_are_regions(const MeshDescription& mesh, const MeshStream& stream,
                           std::uint64_t tets, const std::vector<std::size_t>& regions,
                           bool by_name, const RunContext& context);

// The point arrays that may be sets of nodes, whose borders are lost where the surface gets other
// triangles: of few integers, one component, and none that steers.
void say_which_may_be_node_sets(const MeshDescription& mesh, const MeshStream& stream,
                                const std::vector<SteeringChoice>& steering,
                                const RunContext& context);

// The arrays of directions, whose lengths are lost where values are means.
void say_which_are_directions(const MeshDescription& mesh, const MeshStream& stream,
                              const RunContext& context);

}  // namespace tetfusion
