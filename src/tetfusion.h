// TetFusion as a library: a tetrahedral mesh in memory goes in, a smaller one comes out.
//
//   tetfusion::Mesh mesh;
//   mesh.points = coordinates;           // std::vector<double>, x y z x y z ...
//   mesh.connectivity = corners;         // std::vector<std::int64_t>, four a tetrahedron
//   mesh.point_arrays.push_back({"pressure", 1, pressure});
//   tetfusion::Options options;
//   options.reduction = 0.9;
//   tetfusion::Result result = tetfusion::simplify(mesh, options);
//   if (!result.status.ok()) report(result.status.message);
//
// Nothing is copied on the way in, nothing is written to a file (but see Options::scratch), nothing
// is printed, and no exception comes out. The result is that of the command `tetfusion simplify`
// with the same options on a file with the same mesh, bit for bit: a function of the mesh and of
// the options alone, whatever the threads and the memory.
#pragma once

#if __cplusplus < 202002L
#error "tetfusion.h needs C++20: compile with -std=c++20, or CMake's cxx_std_20"
#endif

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#define TETFUSION_PUBLIC __attribute__((visibility("default")))

namespace tetfusion {

// ---- What went wrong ----

// The values are the exit codes of the command.
enum class Code : int {
  kDone = 0,
  kUsage = 2,           // the options contradict each other or the mesh
  kBadInput = 3,        // the mesh is not what it should be: the message says which cell or array
  kIo = 4,              // the scratch folder could not be written, or its disk is full
  kMemory = 5,          // the memory is too small: the message says how much is needed
  kGoalNotReached = 6,  // with Options::strict; there is a result
  kInterrupted = 130    // Observer::cancelled said so
};

struct Status {
  Code code = Code::kDone;
  std::string message;  // what, where, and what to do; empty when all is well

  bool ok() const { return code == Code::kDone; }
};

// ---- Values ----

enum class Type : std::uint8_t {
  kInt8,
  kUInt8,
  kInt16,
  kUInt16,
  kInt32,
  kUInt32,
  kInt64,
  kUInt64,
  kFloat32,
  kFloat64
};

constexpr std::size_t bytes_of(Type type) {
  constexpr std::size_t kBytes[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kBytes[static_cast<std::size_t>(type)];
}

// Of an arithmetic type but bool, by its size and sign: long and long long are both kInt64.
template <class T>
constexpr Type type_of() {
  static_assert(std::is_arithmetic_v<T> && !std::is_same_v<std::remove_cv_t<T>, bool> &&
                sizeof(T) <= 8);
  if constexpr (std::is_floating_point_v<T>) {
    return sizeof(T) == 4 ? Type::kFloat32 : Type::kFloat64;
  } else {
    constexpr int kPower = sizeof(T) == 1 ? 0 : sizeof(T) == 2 ? 1 : sizeof(T) == 4 ? 2 : 3;
    return static_cast<Type>(2 * kPower + (std::is_unsigned_v<T> ? 1 : 0));
  }
}

// A view of the caller's numbers, which must not change while it is in use.
class Values {
 public:
  Values() = default;
  Values(Type type, const void* data, std::size_t size) : type_(type), data_(data), size_(size) {}
  template <class T>
  Values(std::span<T> values)  // NOLINT(google-explicit-constructor)
      : Values(type_of<std::remove_cv_t<T>>(), values.data(), values.size()) {}
  template <class T, class Allocator>
  Values(const std::vector<T, Allocator>& values)  // NOLINT(google-explicit-constructor)
      : Values(type_of<T>(), values.data(), values.size()) {}
  // Of a temporary nothing would be left.
  template <class T, class Allocator>
  Values(const std::vector<T, Allocator>&&) = delete;

  Type type() const { return type_; }
  const void* data() const { return data_; }
  std::size_t size() const { return size_; }  // numbers, not tuples
  bool empty() const { return size_ == 0; }

 private:
  Type type_ = Type::kFloat64;
  const void* data_ = nullptr;
  std::size_t size_ = 0;
};

// Numbers of its own, in memory from std::malloc.
class OwnedValues {
 public:
  OwnedValues() = default;
  // Uninitialised. Throws std::bad_alloc.
  TETFUSION_PUBLIC OwnedValues(Type type, std::size_t size);

  Type type() const { return type_; }
  void* data() { return data_.get(); }
  const void* data() const { return data_.get(); }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }

  // REQUIRES: T has that type.
  template <class T>
  std::span<const T> as() const {
    return {static_cast<const T*>(data()), size_};
  }
  operator Values() const& {  // NOLINT(google-explicit-constructor)
    return {type_, data(), size_};
  }
  operator Values() const&& = delete;

  // Hands the memory over; whoever takes it frees it with std::free. Null where there are no
  // numbers.
  void* release() {
    size_ = 0;
    return data_.release();
  }

 private:
  struct Free {
    void operator()(void* p) const { std::free(p); }
  };
  Type type_ = Type::kFloat64;
  std::unique_ptr<void, Free> data_;
  std::size_t size_ = 0;
};

// ---- Meshes ----

// Tuples over the points or cells of a mesh, one for each.
struct Array {
  std::string name;  // of its own among the arrays of the points, or of the cells; not empty
  std::uint32_t components = 1;
  Values values;
};

// What goes in. Fewer than 2^32 - 1 points and 2^30 tetrahedra.
struct Mesh {
  Values points;        // three coordinates each, Float32 or Float64: the type of the result's
  Values connectivity;  // the numbers of the cells' points, from 0 on; Int32 or Int64

  // For a mesh of tetrahedra alone both may stay empty. Otherwise VTK's way: types[c] is the VTK
  // cell type of cell c (1 vertex, 3 line, 5 triangle, 10 tetrahedron; more with
  // Options::tetrahedralize and Options::linearize), and its points are connectivity[offsets[c]] to
  // [offsets[c + 1] - 1]. Cells of lower dimension are part of the result, and their points stay
  // where they are; but see Options::drop_patches.
  Values offsets;  // one more than there are cells; the type of the connectivity
  std::span<const std::uint8_t> types;

  // Empty, or VTK's vtkGhostType of each cell. Cells that are copies of another part's (1), refined
  // (8) or hidden (32) are no part of the result, and their points stay where they are: so parts
  // that are simplified each for itself still fit.
  std::span<const std::uint8_t> ghosts;

  std::vector<Array> point_arrays, cell_arrays;
  // One of the point arrays: it steers where Options::arrays names none.
  std::string active_scalars;
};

struct OwnedArray {
  std::string name;
  std::uint32_t components = 1;
  OwnedValues values;
};

// What comes out: points that cells use, tetrahedra, and then the cells of lower dimension. The
// arrays are those of the input, by order, name and type, and after them that of
// Options::original_ids.
struct OwnedMesh {
  OwnedValues points;
  // The type of the input's; but Int64 where the last offset has no room in 32 bits, as where many
  // cells were split.
  OwnedValues connectivity;
  OwnedValues offsets;  // that type, too; offsets and types are empty where the input's were
  OwnedValues types;
  std::uint64_t tets = 0;  // so many of the cells, from the first on
  std::vector<OwnedArray> point_arrays, cell_arrays;
};

// ---- Options ----

enum class Operation : std::uint8_t {
  kFuse,    // neighbouring vertices become one, the cheapest first
  kTetFuse  // the paper's: the four vertices of a tetrahedron become one
};

// Of the boundary surface, and of the surfaces between regions.
enum class BoundaryMode : std::uint8_t {
  kExact,   // every triangle stays
  kPlanar,  // the same surface: flat parts and straight edges get new triangles
  kWithin   // it may move by Options::boundary_distance
};

struct SteeringArray {
  std::string name;  // "all", if no array of points is called so: all of floating-point numbers
  bool of_cells = false;
  // Its own, in the place of max_error (with kTetFuse of scalar_tolerance); a share of its range,
  // in (0, 1].
  std::optional<double> tolerance;
};

// Shares are fractions: 0.9 is 90 %. What is left out has the default that `tetfusion simplify
// --help` names; there every option is explained at more length, under the same name, but that
// --array is given several times for `arrays`, --boundary takes the distance, too, and
// --boundary-rule tets is `boundary_tets_stay`.
struct Options {
  // The goal, at most one of the two: the share of the tetrahedra that is to go, in [0, 1); how
  // many are to be left, at least 1. Neither: as far as max_error allows, with kTetFuse until
  // nothing fuses.
  std::optional<double> reduction;
  std::optional<std::uint64_t> tets;
  // With kFuse. No steering field is off by more at any of the input's points, as a share of its
  // range, in (0, 1]. Default: 0.01 without a goal, max_rms and a tolerance of any array, else
  // anything.
  std::optional<double> max_error;
  // With kFuse: what a fusion may do to the steering fields, in the mean of squares, as a share of
  // their ranges, in (0, 1].
  std::optional<double> max_rms;
  bool strict = false;  // a goal that is not reached is Code::kGoalNotReached

  Operation method = Operation::kFuse;
  BoundaryMode boundary = BoundaryMode::kExact;  // kTetFuse: kExact
  double boundary_distance = 0;  // a share of the diagonal of the bounding box, in (0, 1)
  // With a boundary that is not kExact: where two triangles of a surface meet whose normals are so
  // many degrees apart, or more, the edge is sharp, and stays; in (0, 180], of which the last is
  // none. Default: 40.
  std::optional<double> feature_angle;
  // With kFuse: no new tetrahedron has a lower mean ratio, or, where the input has one below it,
  // one that is lower than that by more than a twentieth; in [0, 1). Default: 0.22.
  std::optional<double> min_quality;
  // With kFuse and a boundary that stays: integrals of floating-point arrays stay,
  // but for `regions`, whose values cells keep.
  bool conserve = false;
  // For each fusion, one value a round and the last one repeated: shares of the range, in (0, 1];
  // factors, >= 1. Infinity is off. Default: off; with kTetFuse 0.025 and 5.
  std::vector<double> scalar_tolerance, stretch_factor;
  double aspect_ratio = std::numeric_limits<double>::infinity();  // >= 1
  // No tetrahedron grows beyond this volume, > 0.
  double max_volume = std::numeric_limits<double>::infinity();
  // With kTetFuse: no tetrahedron that touches the boundary is fused, as in the paper's text.
  bool boundary_tets_stay = false;

  // Default: Mesh::active_scalars, else the first floating-point array of the points; of these the
  // first that is not the same everywhere.
  std::vector<SteeringArray> arrays;
  // Arrays of the cells, of one component, whose interfaces stay, as `boundary` says;
  // floating-point numbers tell regions apart where they differ. Default: those of integers that
  // are named like material, region, physical, tissue, block, zone, part, label, and ObjectId,
  // medit:ref and tetgen:ref. Empty: none.
  std::optional<std::vector<std::string>> regions;
  // Where the mesh stays as it is, as in "box=X0,X1,Y0,Y1,Z0,Z1", "sphere=X,Y,Z,RADIUS",
  // "pressure>0.5".
  std::vector<std::string> roi;
  // With kFuse: an array of the points, or "cell:NAME" of the cells, of finite values >= 0; errors
  // count so many times as much there. Empty: all count alike.
  std::string weight;

  // The result has an array of the points more, OriginalPointIds (kInt64): the number that a point
  // which stayed has in the input, -1 of one that is new. Where cells are split or straightened,
  // points that no cell uses are not counted.
  bool original_ids = false;

  bool tetrahedralize = false;  // split hexahedra, voxels, wedges and pyramids
  bool linearize = false;       // take cells of higher order by their corners
  // Leave out cells of lower dimension, of any type, that else hold their points where they are.
  bool drop_patches = false;
  // Some of these alone, so that the boundary may move there: "ARRAY=VALUE", of a cell array of
  // numbers, which some cell of lower dimension must have.
  std::vector<std::string> drop_patch;

  // Tetrahedra in each of the chunks that threads work on, at least 1. The result depends on it.
  std::uint64_t chunk_tets = 200'000;

  // What follows does not change the result.
  // 0: what OMP_NUM_THREADS says, or one for each processor that the process may use. Fewer are
  // used where the memory is not enough for so many.
  int threads = 0;
  // Bytes that the run may take, beside the mesh that goes in and the one that comes out. 0: half
  // of what the machine or its control group allows, divided by the runs that go on in the process
  // when this one begins.
  std::uint64_t memory = 0;
  // A folder that is there: what does not fit into the memory goes to one that is made in it, and
  // removed in the end. Empty: too little memory is Code::kMemory.
  std::string scratch;
};

// ---- Running ----

// All are called from the thread that has called simplify(), and may be empty. An exception that
// leaves one ends the run with Code::kInterrupted.
struct Observer {
  // How much of the run is done, 0 to 1, and what goes on. The share never falls.
  std::function<void(double share, std::string_view phase)> progress;
  // Asked about thirty times a second; true ends the run.
  std::function<bool()> cancelled;
  // Sentences for the user: what was locked, what was left out.
  std::function<void(std::string_view sentence)> notice;
};

struct MeshFacts {
  std::uint64_t points = 0;  // that cells use
  std::uint64_t tets = 0;
  std::uint64_t boundary_triangles = 0;
  double volume = 0;
};

// What is odd about the input, and was left alone or out.
struct OddFacts {
  std::uint64_t rewound = 0;  // wound the other way: turned
  std::uint64_t degenerate = 0, inverted = 0, duplicate_tets = 0, nonconforming_faces = 0;
  std::uint64_t unused_points = 0, ghost_cells = 0;
  std::uint64_t locked_vertices = 0;  // for another reason than the boundary
};

struct Report {
  MeshFacts input, output;
  OddFacts odd;
  double reduction = 0;  // the share of the tetrahedra that went
  bool goal_reached = false;
  std::string stop_sentence;  // which limit ended the run
  std::vector<std::string> steering, regions;
  double deviation = 0;  // how far the surface may have moved: a bound, share of the diagonal
  std::uint64_t rounds = 0, chunks = 0;
  double seconds = 0, cpu_seconds = 0;  // cpu_seconds: all threads of the process, meanwhile
  std::uint64_t scratch_bytes = 0;      // of the disk, at most at once
  int threads = 0;
  std::string json;  // all of this and more: what the command writes with --report
};

// If !status.ok() there is no mesh, except with kGoalNotReached.
struct Result {
  Status status;
  OwnedMesh mesh;
  Report report;
};

// May be called from any thread, and from several at once, but not from an observer. Each run has
// threads of its own, so many as its options say; they are gone when it ends.
TETFUSION_PUBLIC Result simplify(const Mesh& mesh, const Options& options = {},
                                 const Observer& observer = {}) noexcept;

TETFUSION_PUBLIC const char* library_version() noexcept;  // "0.1.0"

}  // namespace tetfusion
