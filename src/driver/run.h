// A run that is opened: what was asked for, the mesh that it is asked of, and where it works.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "base/resources.h"
#include "base/run_context.h"
#include "driver/arrays/carried_arrays.h"
#include "driver/arrays/steering.h"
#include "driver/request/options.h"
#include "driver/workplace.h"
#include "io/source/mesh_sink.h"
#include "io/source/mesh_source.h"
#include "io/source/mesh_stream.h"
#include "kernel/fuse/fuse_limits.h"
#include "mesh/regions/region_of_interest.h"

namespace tetfusion {

// The mesh, and what its arrays are to the run.
struct RunInput {
  std::unique_ptr<MeshSource> source;
  std::unique_ptr<MeshStream> stream;  // null before read_steering(), perhaps, and after the import
  std::vector<SteeringChoice> steering;
  std::vector<std::size_t> regions;  // of the description's cell arrays
  CarriedArrays carried;
  WeightColumn weights;  // of chunks
  RegionOfInterest interest;

  const MeshDescription& description() const { return source->description(); }
};

// What the parts of a run share. The request and the context outlive it.
struct Run {
  const SimplifyRequest& request;
  const RunContext& context;
  MeshSink* sink = nullptr;  // where the result goes instead of to files
  RunInput input;
  Workplace place;
  PhaseClock clock;

  bool keeps_logs() const { return !request.progressive.empty(); }
};

// Opens the mesh that the request names, or takes `source`, which may be null, as may `sink`.
// Throws all that there is to be said against the options, and against the options for this mesh,
// before the mesh is read: Error(kUsage), Error(kMemory); what open_mesh() throws. Sets the number
// of threads. Writes nothing.
Run open_run(const SimplifyRequest& request, std::unique_ptr<MeshSource> source, MeshSink* sink,
             const RunContext& context);

// The fields that steer, with a stream that is opened if there is none: it must stay as long as
// they are read. Says what steers where nobody has chosen. Throws Error(kUsage) where nothing says
// how far to go.
Steering read_steering(Run* run);

}  // namespace tetfusion
