// A file, imported in chunks.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "driver/export/export.h"
#include "driver/import/import.h"
#include "driver/rounds/rounds.h"
#include "io/source/mesh_source.h"
#include "io/store/scratch.h"

namespace tetfusion::testing {

struct ImportChoice {
  std::uint64_t chunk_tets = 1'000'000;
  std::vector<std::string> regions = {};
  bool on_disk = false;
  std::vector<std::string> steering = {};
  bool first_round = false;    // done with the import, where that is possible
  bool excerpt = false;        // with it
  std::uint64_t window = 0;    // cells and points a window; 0: as many as usual
  bool surfaces_move = false;  // ImportSettings'
};

template <class Real>
class Import {
 public:
  Import(const std::string& path, const ImportChoice& choice, const RunContext& context = {});

  std::vector<WorkMesh<Real>> chunks() const;  // one, where the mesh is whole
  WorkMesh<Real> joined() const;

  MeshSummary export_to(const std::string& path, ExportSettings settings = {});

  // Runs the round that `first_round` would have run.
  RoundStatistics run_first_round();

 private:
  std::string folder_;  // the scratch folder; removed with the scratch

 public:
  std::unique_ptr<MeshSource> source;
  std::unique_ptr<Scratch> scratch;
  MemoryBudget budget{std::uint64_t{1} << 30};
  CarriedArrays carried;
  WorkMesh<Real> layout;
  std::vector<SteeringField> fields;
  ImportedMesh<Real> imported;
  RoundStatistics first_round;        // if it was done with the import
  std::vector<std::uint64_t> shares;  // and what it was told of the chunks
  WorkMesh<Real> excerpt;             // if one was asked for and made

 private:
  RoundSettings settings() const;

  std::uint64_t chunk_tets_;
  Box box_;
  std::unique_ptr<Rounds<Real>> rounds_;
};

}  // namespace tetfusion::testing
