#include "driver/rounds/memory_plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/numbers.h"
#include "base/resources.h"
#include "driver/arrays/carried_arrays.h"
#include "driver/rounds/original_values.h"
#include "driver/rounds/rounds.h"
#include "verify/verify.h"

namespace tetfusion {

namespace {

constexpr std::uint64_t kMiB = std::uint64_t{1} << 20;
// Windows of the input and what is made of them, a thread; the writer's buffers are less.
constexpr std::uint64_t kWindows = 30 * kMiB;
// Where memory is short; and the least rows a window, however wide.
constexpr std::uint64_t kWindowsShare = 16;
constexpr std::uint64_t kLeastRows = 2048;
// Of a row: where it goes, its turn, and room to grow.
constexpr std::uint64_t kRowBytes = 24;
// It is read, and then copied to the piece of its chunk.
constexpr double kCopiesOfRow = 2.5;
// Of an excerpt (partition/curve_excerpt.h), however small chunks are; 17 thousand measured.
constexpr double kExcerptTets = 20'000;
// Points that several chunks have are there more than once.
constexpr double kCopies = 1.2;

// Vertices on the interface of a chunk. A cube of n vertices has 6 n^(2/3) on its surface; pieces
// of the curve are less compact than cubes, and each interface is counted on one side.
double interface_vertices(double tets) {
  constexpr double kTetsPerVertex = 5.5;
  constexpr double kSurface = 6;
  return kSurface * std::pow(tets / kTetsPerVertex, 2.0 / 3.0);
}

// Their types, where they begin, their corners, and these once more, in order. All of it is there
// again where it is read, where it is put away, and where it is written.
double lower_bytes(const LowerCount& lower, std::uint64_t row_bytes) {
  const std::uint64_t held =
      (1 + sizeof(std::uint64_t) + row_bytes) * lower.cells + 2 * sizeof(VertexId) * lower.corners;
  return 2.0 * static_cast<double>(held);
}

}  // namespace

InputWindow plan_window(std::uint64_t most, std::uint64_t bytes_a_row, std::uint64_t total,
                        int threads) {
  const auto each =
      static_cast<std::uint64_t>(kCopiesOfRow * static_cast<double>(bytes_a_row)) + kRowBytes;
  const std::uint64_t share = total / (kWindowsShare * static_cast<std::uint64_t>(threads));
  const std::uint64_t rows = std::min(most, std::max(kLeastRows, std::max(kWindows, share) / each));
  return {rows, rows * each};
}

MemoryNeeds estimate_needs(const MeshDescription& mesh, const SteeringBytes& steering,
                           std::uint64_t chunk_tets, int threads, const ReaderNeeds& reader) {
  const auto cells = static_cast<double>(mesh.cells);
  const CarriedArrays carried(mesh);
  const std::uint64_t cell_row = steering.tet + carried.cell_data.row_bytes();
  const auto points = static_cast<double>(mesh.points);
  const double real = mesh.point_type == ValueType::kFloat32 ? 4 : 8;
  const double vertex =
      3 * real + 5 + static_cast<double>(steering.vertex + carried.point_data.row_bytes());
  const double tet = 17 + static_cast<double>(cell_row);
  const double tets = cells - static_cast<double>(reader.lower.cells);
  const double pieces = tets * tet + kCopies * points * vertex;
  const double chunks = std::ceil(cells / static_cast<double>(chunk_tets));
  const double removed =
      steering.removed_point == 0 ? 0 : 3 * real + 8 + static_cast<double>(steering.removed_point);
  // In the beginning, or in the end, when most of a chunk are points that were removed
  // (Rounds::begin): in the whole mesh these take less than the tetrahedra and vertices that went.
  const double chunk =
      std::max(pieces / std::max(chunks, 1.0),
               removed * std::min(points, kRemovedPerTet * static_cast<double>(chunk_tets)));

  // Reports of the interface, and what judging it needs: 100 measured.
  constexpr double kInterfaceBytes = 110;
  const double between =
      chunks > 1 ? chunks * interface_vertices(static_cast<double>(chunk_tets)) * kInterfaceBytes
                 : 0;
  const auto mean = static_cast<double>(steering.point_mean);
  const double of_points = (4 + 1.0 / 8 + mean) * points;
  // Before anything else these are made, of positions and weights.
  const double means = mean > 0 ? (4 * sizeof(double) + mean) * points : 0;
  const double point_aside =
      steering.positions_aside * 3 * real + static_cast<double>(steering.point_aside);
  const double cell_aside = 5 * sizeof(double) + static_cast<double>(steering.cell_aside);
  const bool fits_points = steering.point_aside > 0, fits_cells = steering.cell_aside > 0;
  const double aside =
      (fits_points ? point_aside * points : 0) + (fits_cells ? cell_aside * cells : 0);
  const auto fit =
      static_cast<double>(fits_points || fits_cells ? fit_memory(fits_points ? mesh.points : 0,
                                                                 fits_cells ? mesh.cells : 0,
                                                                 std::min(mesh.cells, chunk_tets))
                                                    : 0);
  const auto widest = static_cast<std::uint64_t>(std::max(vertex, tet));
  const double windows =
      static_cast<double>(threads) *
      static_cast<double>(std::max(kWindows, plan_window(kLeastRows, widest, 0, 1).bytes));
  const double at_work = std::min(static_cast<double>(threads), std::max(chunks, 1.0));
  const double work = std::max(windows, at_work * fit) + at_work * 6 * chunk;
  const double excerpt = chunks > 1 ? 6 * pieces * std::min(1.0, kExcerptTets / cells) : 0;
  // Field data is in memory as a whole while a result is written.
  const auto fields = static_cast<double>(mesh.field_data.bytes());
  const double fixed = static_cast<double>(kProcessBytes) + static_cast<double>(reader.bytes) +
                       lower_bytes(reader.lower, cell_row) + fields +
                       std::max({work + std::max(of_points, between), means, excerpt});
  MemoryNeeds needs;
  needs.pieces = static_cast<std::uint64_t>(pieces);
  needs.out_of_core = static_cast<std::uint64_t>(fixed);
  // What was scattered for the chunks stays until the first round is over, and that leaves pieces.
  // In the end there is more room; only if hardly anything has gone, what is put aside, which is
  // then sorted, may take more.
  needs.in_core = static_cast<std::uint64_t>(
      fixed + std::max(1.75 * pieces + aside, 1.05 * pieces + 2 * aside));
  // What was scattered for the chunks, and the first round's pieces; later the generation that is
  // read, the one that is written, and the one that is durable, each half as large. Up to 1.95
  // measured; in part of that are files kept to be overwritten, which go where room is short.
  needs.scratch =
      static_cast<std::uint64_t>(std::max(2.0 * pieces + aside, 1.05 * pieces + 2 * aside));
  return needs;
}

MemoryNeeds fit_threads(std::uint64_t memory,
                        const std::function<MemoryNeeds(int threads)>& needs_with,
                        const RunContext& context) {
  const int wanted = thread_count();
  MemoryNeeds needs = needs_with(wanted);
  if (needs.out_of_core <= memory || wanted == 1) return needs;
  int enough = 1;  // or there is no such number
  for (int too_many = wanted; too_many - enough > 1;) {
    const int middle = enough + (too_many - enough) / 2;
    (needs_with(middle).out_of_core <= memory ? enough : too_many) = middle;
  }
  needs = needs_with(enough);
  if (needs.out_of_core <= memory) {
    context.say(fmt::format("uses {} of {} threads: all would need {} of memory, and it may use {}",
                            enough, wanted, format_bytes(needs_with(wanted).out_of_core),
                            format_bytes(memory)));
    set_thread_count(enough);
  }
  return needs;
}

void include_verification(const MeshDescription& mesh, std::uint64_t tets,
                          std::uint64_t point_bytes, std::uint64_t tet_bytes, MemoryNeeds* needs) {
  const double share = static_cast<double>(std::min(tets, mesh.cells)) /
                       static_cast<double>(std::max<std::uint64_t>(mesh.cells, 1));
  const double points = share * static_cast<double>(mesh.points);
  // Two triangles a point of the surface, as that of a cube; of both meshes.
  const double triangles = 4 * interface_vertices(static_cast<double>(mesh.cells));
  const std::uint64_t bytes = kProcessBytes + tet_bytes * std::min(tets, mesh.cells) +
                              point_bytes * static_cast<std::uint64_t>(points);
  const ComparisonNeeds beside = estimate_comparison(mesh, tets, static_cast<std::uint64_t>(points),
                                                     static_cast<std::uint64_t>(triangles));
  needs->out_of_core = std::max(needs->out_of_core, bytes + beside.least());
  needs->in_core =
      std::max(needs->in_core,
               bytes + beside.most() +
                   static_cast<std::uint64_t>(1.75 * share * static_cast<double>(needs->pieces)));
}

}  // namespace tetfusion
