// The main job: a mesh file in, a simplified mesh file out; or a mesh in memory, likewise.
#pragma once

#include <memory>

#include "base/run_context.h"
#include "driver/request/options.h"
#include "driver/request/report.h"
#include "io/source/mesh_sink.h"
#include "io/source/mesh_source.h"

namespace tetfusion {

// Reads request.input, runs rounds of request.behaviour.method until the goal is reached or nothing
// fuses, and writes request.output (and a file a level, with request.behaviour.lods). Each file
// appears under its name when it is whole. The files' bytes are a function of the input and the
// behaviour options alone.
//
// Throws Error: kUsage for options that contradict each other or the mesh, kBadInput, kIo, kMemory,
// kInterrupted, kBroken where a result is not what was promised (verify); OutOfReach. On a throw no
// output has been touched, but for levels that were already whole.
SimplifyReport simplify(const SimplifyRequest& request, const RunContext& context = {});

// The same with a mesh that is opened already; the request's input is a word for messages.
SimplifyReport simplify(const SimplifyRequest& request, std::unique_ptr<MeshSource> source,
                        const RunContext& context = {});

// The same from and to memory: the mesh goes to `sink` when all is done. Of the request input and
// output are words for messages, and levels, pieces and resuming do not exist; with performance's
// scratch empty nothing goes to the disk, and what does not fit is Error(kMemory).
SimplifyReport simplify(const SimplifyRequest& request, std::unique_ptr<MeshSource> source,
                        MeshSink* sink, const RunContext& context = {});

}  // namespace tetfusion
