// From a macroLoD to a file: chunks are compacted, every vertex gets its number, and the sections
// of the file are written one after another from the chunks.
#pragma once

#include <functional>
#include <string>

#include "base/memory_budget.h"
#include "base/run_context.h"
#include "driver/import/import.h"
#include "driver/request/options.h"
#include "driver/request/report.h"
#include "driver/rounds/rounds.h"
#include "io/mesh_format.h"
#include "io/source/mesh_sink.h"
#include "io/write_mesh.h"

namespace tetfusion {

struct ExportSettings {
  std::string path;  // NAME.pvtu: several files (export_pieces.h)
  Encoding encoding = Encoding::kRaw;
  int threads = 1;
  // From any of the threads. May throw: nothing is written then.
  std::function<void(double share)> progress;
  // Of a .pvtu file, but for one of cells of lower dimension; at most one for each tetrahedron.
  // 0: as many as have at most four million tetrahedra each.
  std::uint32_t pieces = 0;
  // Where the mesh goes instead of to a file (export_memory.h); path and encoding do not matter
  // then.
  MeshSink* sink = nullptr;
  // The result has the array kOriginalIds (options.h), after the input's.
  bool original_ids = false;
  // The mesh has ImportSettings::keeps_numbers; they are not written.
  bool has_numbers = false;
  // What kOriginalIds would hold, of all points of the result, and the numbers of its cells; may be
  // null. They are filled before inspect() is called.
  Vector<std::int64_t>* point_ids = nullptr;
  Vector<TetId>* cell_numbers = nullptr;
  // Called when all is written, but has no name yet, with a path where it can be read. May throw:
  // the old file stays then.
  std::function<void(const std::string& path, const MeshSummary& written)> inspect = {};
  // WriteOptions::before_name, after inspect(). Not called where the mesh goes to a sink.
  std::function<void()> before_name = {};
  std::string label = {};  // WriteOptions::label
};

// What is to be written: the mesh with the carried arrays and the input's field data. All of it
// outlives the job.
template <class Real>
struct ExportJob {
  const MacroLod<Real>& mesh;
  const WorkMesh<Real>& layout;  // empty: what a row holds
  const LowerPart<Real>& lower;
  const CarriedArrays& carried;
  FittedValues<Real>* fitted = nullptr;  // values of new points; null: they keep what they have
  MeshSource* source = nullptr;          // the input
  const ExportSettings& settings;
  const RunContext& context;
  MemoryBudget* budget = nullptr;
  Scratch* scratch = nullptr;

  // Before what was written gets its name. Throws Error.
  void check() const {
    context.check();
    scratch->check();
  }
  void report(double done) const {
    if (settings.progress) settings.progress(done);
  }
};

// The array kOriginalIds.
ArrayInfo original_ids_info();
// Throws Error(kUsage) where the mesh has one already.
void require_no_original_ids(const std::string& input, const MeshDescription& mesh);

// Throws what export_mesh() would throw for such a name, before any work.
void check_export(const std::string& path, Encoding encoding);
// Says what of that mesh a file of that name, which may hold {lod}, cannot hold, marks included.
void tell_left_out(const std::string& path, const MeshDescription& mesh, const std::string& label,
                   const RunContext& context);
// Removes what a run to that name left that was killed: see remove_dead_pieces(). Does not fail.
void clear_leftovers(const std::string& path) noexcept;

// Points are numbered chunk by chunk, a point between chunks with the lowest of them, those that
// only cells of lower dimension use last. The mesh stays as it is. Returns what was written.
template <class Real>
MeshSummary export_mesh(const ExportJob<Real>& job);

}  // namespace tetfusion
