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
// How many times the mesh as pieces is in memory while its chunks are made, and in the end.
constexpr double kInCore = 1.75, kInTheEnd = 1.05;

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

namespace {

// Of one coordinate.
double real_bytes(const MeshDescription& mesh) {
  return mesh.point_type == ValueType::kFloat32 ? 4 : 8;
}

// What the mesh takes as pieces, and how much of that one chunk is.
struct PieceBytes {
  double vertex = 0, tet = 0;  // a row
  double all = 0;
  double chunks = 0;  // how many there are
  double chunk = 0;
};

PieceBytes bytes_of_pieces(const MeshDescription& mesh, const CarriedArrays& carried,
                           const SteeringBytes& steering, std::uint64_t chunk_tets,
                           const ReaderNeeds& reader) {
  constexpr double kVertex = 5;   // its number, and marks
  constexpr double kTet = 17;     // four corners, and marks
  constexpr double kRemoved = 8;  // where a removed point is in its chunk
  const auto points = static_cast<double>(mesh.points);
  const auto cells = static_cast<double>(mesh.cells);
  const double place = 3 * real_bytes(mesh);
  PieceBytes out;
  out.vertex =
      place + kVertex + static_cast<double>(steering.vertex + carried.point_data.row_bytes());
  out.tet = kTet + static_cast<double>(steering.tet + carried.cell_data.row_bytes());
  const double tets = cells - static_cast<double>(reader.lower.cells);
  out.all = tets * out.tet + kCopies * points * out.vertex;
  out.chunks = std::ceil(cells / static_cast<double>(chunk_tets));
  const double removed = steering.removed_point == 0
                             ? 0
                             : place + kRemoved + static_cast<double>(steering.removed_point);
  // In the beginning, or in the end, when most of a chunk are points that were removed
  // (Rounds::begin): in the whole mesh these take less than the tetrahedra and vertices that went.
  out.chunk =
      std::max(out.all / std::max(out.chunks, 1.0),
               removed * std::min(points, kRemovedPerTet * static_cast<double>(chunk_tets)));
  return out;
}

// What is put aside of the original, to be fitted to in the end.
double bytes_aside(const MeshDescription& mesh, const SteeringBytes& steering) {
  constexpr double kCell = 5 * sizeof(double);  // centre, volume, and where it is
  const double point =
      steering.positions_aside * 3 * real_bytes(mesh) + static_cast<double>(steering.point_aside);
  const double cell = kCell + static_cast<double>(steering.cell_aside);
  return (steering.point_aside > 0 ? point * static_cast<double>(mesh.points) : 0) +
         (steering.cell_aside > 0 ? cell * static_cast<double>(mesh.cells) : 0);
}

// Of all threads: windows of the input, or a fit, and chunks in hand.
double bytes_at_work(const MeshDescription& mesh, const SteeringBytes& steering,
                     const PieceBytes& pieces, std::uint64_t chunk_tets, int threads) {
  const auto widest = static_cast<std::uint64_t>(std::max(pieces.vertex, pieces.tet));
  const double windows =
      static_cast<double>(threads) *
      static_cast<double>(std::max(kWindows, plan_window(kLeastRows, widest, 0, 1).bytes));
  const bool fits_points = steering.point_aside > 0, fits_cells = steering.cell_aside > 0;
  const auto fit =
      static_cast<double>(fits_points || fits_cells ? fit_memory(fits_points ? mesh.points : 0,
                                                                 fits_cells ? mesh.cells : 0,
                                                                 std::min(mesh.cells, chunk_tets))
                                                    : 0);
  const double at_work = std::min(static_cast<double>(threads), std::max(pieces.chunks, 1.0));
  return std::max(windows, at_work * fit) + at_work * kCopiesOfChunk * pieces.chunk;
}

// The most of what a run has beside that, at one time or another.
double bytes_of_phases(const MeshDescription& mesh, const SteeringBytes& steering,
                       const PieceBytes& pieces, std::uint64_t chunk_tets, double at_work) {
  constexpr double kInterface = 110;  // reports of a vertex there, and judging it: 100 measured
  const auto points = static_cast<double>(mesh.points);
  const double between =
      pieces.chunks > 1
          ? pieces.chunks * interface_vertices(static_cast<double>(chunk_tets)) * kInterface
          : 0;
  const auto mean = static_cast<double>(steering.point_mean);
  // While the input is read: the chunk of each point, whether it is the excerpt's, whether others
  // lie in the same place, and means of cells.
  const double of_points = (4 + 2.0 / 8 + mean) * points;
  // Before anything else these are made, of positions and weights.
  const double means = mean > 0 ? (4 * sizeof(double) + mean) * points : 0;
  const double excerpt = pieces.chunks > 1
                             ? kCopiesOfChunk * pieces.all *
                                   std::min(1.0, kExcerptTets / static_cast<double>(mesh.cells))
                             : 0;
  return std::max({at_work + std::max(of_points, between), means, excerpt});
}

}  // namespace

MemoryNeeds estimate_needs(const MeshDescription& mesh, const SteeringBytes& steering,
                           std::uint64_t chunk_tets, int threads, const ReaderNeeds& reader) {
  const CarriedArrays carried(mesh);
  const PieceBytes pieces = bytes_of_pieces(mesh, carried, steering, chunk_tets, reader);
  const double aside = bytes_aside(mesh, steering);
  // Field data is in memory as a whole while a result is written.
  const double fixed = static_cast<double>(kProcessBytes) + static_cast<double>(reader.bytes) +
                       lower_bytes(reader.lower, steering.tet + carried.cell_data.row_bytes()) +
                       static_cast<double>(mesh.field_data.bytes()) +
                       bytes_of_phases(mesh, steering, pieces, chunk_tets,
                                       bytes_at_work(mesh, steering, pieces, chunk_tets, threads));
  MemoryNeeds needs;
  needs.pieces = static_cast<std::uint64_t>(pieces.all);
  needs.out_of_core = static_cast<std::uint64_t>(fixed);
  // What was scattered for the chunks stays until the first round is over, and that leaves pieces.
  // In the end there is more room; only if hardly anything has gone, what is put aside, which is
  // then sorted, may take more.
  needs.in_core = static_cast<std::uint64_t>(
      fixed + std::max(kInCore * pieces.all + aside, kInTheEnd * pieces.all + 2 * aside));
  // What was scattered for the chunks, and the first round's pieces; later the generation that is
  // read, the one that is written, and the one that is durable, each half as large. Up to 1.95
  // measured; in part of that are files kept to be overwritten, which go where room is short.
  constexpr double kOnDisk = 2;
  needs.scratch = static_cast<std::uint64_t>(
      std::max(kOnDisk * pieces.all + aside, kInTheEnd * pieces.all + 2 * aside));
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
  needs->in_core = std::max(
      needs->in_core,
      bytes + beside.most() +
          static_cast<std::uint64_t>(kInCore * share * static_cast<double>(needs->pieces)));
}

}  // namespace tetfusion
