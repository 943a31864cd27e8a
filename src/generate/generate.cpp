#include "generate/generate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "base/error.h"
#include "base/numbers.h"
#include "generate/permutation.h"
#include "io/mesh_format.h"
#include "io/mesh_output.h"
#include "io/vtk/cell_order.h"
#include "io/vtk/vtu_writer.h"
#include "mesh/time_value.h"

namespace tetfusion {

namespace {

// Rounding of a coordinate in [0, 1], doubled for that of the computation before it.
constexpr double kFloat32Error = 0x1p-24;
constexpr double kFloat64Error = 0x1p-50;

constexpr std::uint64_t kRegions = 4;

// Fields at a position, all of them by basic arithmetic and square roots: exactly the same
// everywhere. Two smooth bumps, one hot, one cold, over a gentle slope.
float temperature(const Vec3<double>& p) {
  const auto bump = [&](double x, double y, double z, double width) {
    const double u = p.x - x, v = p.y - y, w = p.z - z;
    return 1 / (1 + (u * u + v * v + w * w) / (width * width));
  };
  return static_cast<float>(300 + 80 * bump(0.3, 0.4, 0.6, 0.2) - 50 * bump(0.8, 0.7, 0.2, 0.3) +
                            20 * p.z);
}

// A step of width 0.03, shaped like a hyperbolic tangent.
float front(const Vec3<double>& p, double time) {
  const double radius = std::sqrt(p.x * p.x + p.y * p.y + p.z * p.z);
  const double s = std::clamp((radius - (0.2 + 0.1 * time)) / 0.03, -1e100, 1e100);
  return static_cast<float>(0.5 + 0.5 * (s / std::sqrt(1 + s * s)));
}

// A whirl round the vertical axis through the middle, that spreads upwards.
Vec3<float> velocity(const Vec3<double>& p) {
  const double u = p.x - 0.5, v = p.y - 0.5, w = p.z - 0.5;
  const double strength = 2 / (1 + 8 * (u * u + v * v));
  return {static_cast<float>(-v * strength), static_cast<float>(u * strength),
          static_cast<float>(0.25 * w * strength)};
}

// The lattice in the order of the file. Thread-safe.
class Generator {
 public:
  explicit Generator(const GenerateOptions& options)
      : options_(options),
        lattice_({options.kind, choose_cubes(options.kind, options.tets), options.jitter,
                  options.grading, options.seed}) {
    if (!options.shuffle) return;
    point_order_.emplace(lattice_.points(), options.seed + 1);
    tet_order_.emplace(lattice_.tets(), options.seed + 2);
  }

  const Lattice& lattice() const { return lattice_; }

  // The position of the file's point i as it will be written.
  Vec3<double> position(std::uint64_t i) const {
    const Vec3<double> p = lattice_.position(point_order_ ? point_order_->forward(i) : i);
    if (options_.double_precision) return p;
    return {static_cast<float>(p.x), static_cast<float>(p.y), static_cast<float>(p.z)};
  }

  void connectivity(std::uint64_t first_tet, std::uint64_t count, std::int64_t* out) const {
    CubeCursor cursor(lattice_);
    for (std::uint64_t i = first_tet; i < first_tet + count; ++i) {
      const std::uint64_t t = lattice_tet(i);
      const Index3& cube = cursor.at(t / lattice_.per_cube());
      for (const std::uint64_t id : lattice_.tet(cube, t % lattice_.per_cube())) {
        *out++ = static_cast<std::int64_t>(point_order_ ? point_order_->inverse(id) : id);
      }
    }
  }

  void regions(std::uint64_t first_tet, std::uint64_t count, std::int32_t* out) const {
    CubeCursor cursor(lattice_);
    const std::uint64_t layers = lattice_.options().cubes[2];
    for (std::uint64_t i = first_tet; i < first_tet + count; ++i) {
      const Index3& cube = cursor.at(lattice_tet(i) / lattice_.per_cube());
      *out++ = static_cast<std::int32_t>(1 + cube[2] * kRegions / layers);
    }
  }

 private:
  // Tetrahedra of one cube mostly come one after another.
  class CubeCursor {
   public:
    explicit CubeCursor(const Lattice& lattice) : lattice_(lattice), cube_(lattice.cube(0)) {}
    const Index3& at(std::uint64_t index) {
      if (index != index_) cube_ = lattice_.cube(index);
      index_ = index;
      return cube_;
    }

   private:
    const Lattice& lattice_;
    std::uint64_t index_ = 0;
    Index3 cube_;
  };

  std::uint64_t lattice_tet(std::uint64_t i) const {
    return tet_order_ ? tet_order_->forward(i) : i;
  }

  GenerateOptions options_;
  Lattice lattice_;
  std::optional<Permutation> point_order_;
  std::optional<Permutation> tet_order_;
};

void check_options(const GenerateOptions& options) {
  if (options.tets == 0 || options.tets > kMaxGeneratedTets) {
    throw Error(ErrorCode::kUsage, fmt::format("the number of tetrahedra must be between 1 and {}",
                                               format_count(kMaxGeneratedTets)));
  }
  if (!std::isfinite(options.time))
    throw Error(ErrorCode::kUsage, "the time must be a finite number");
}

void check_rounding(const GenerateOptions& options, const Lattice& lattice) {
  if (lattice.survives_rounding(options.double_precision ? kFloat64Error : kFloat32Error)) return;
  throw Error(
      ErrorCode::kUsage,
      fmt::format("{} coordinates are too coarse for {} tetrahedra with this jitter and grading: "
                  "rounding could invert some; {}use fewer tetrahedra, less jitter or less grading",
                  options.double_precision ? "Float64" : "Float32", format_count(lattice.tets()),
                  options.double_precision ? "" : "use Float64 (--double), or "));
}

VtuLayout layout_of(const Lattice& lattice, const GenerateOptions& options, Encoding encoding) {
  VtuLayout layout;
  layout.points = lattice.points();
  layout.cells = lattice.tets();
  layout.corners = 4 * lattice.tets();
  layout.point_type = options.double_precision ? ValueType::kFloat64 : ValueType::kFloat32;
  layout.point_data.arrays = {{"temperature", ValueType::kFloat32, 1, {}, 0},
                              {"front", ValueType::kFloat32, 1, {}, 0},
                              {"velocity", ValueType::kFloat32, 3, {"x", "y", "z"}, 0}};
  layout.point_data.active = {{"Scalars", "temperature"}, {"Vectors", "velocity"}};
  layout.cell_data.arrays = {{"region", ValueType::kInt32, 1, {}, 0}};
  layout.cell_data.active = {{"Scalars", "region"}};
  DataArray time{{kTimeValue, ValueType::kFloat64, 1, {}, 1}, {}};
  time.bytes.resize(sizeof(double));
  std::memcpy(time.bytes.data(), &options.time, sizeof(double));
  layout.field_data.push_back(std::move(time));
  layout.encoding = encoding;
  return layout;
}

template <class Real>
void put_positions(const Generator& generator, VtuWriter* writer) {
  writer->put_computed<Real>([&](std::uint64_t first, std::uint64_t count, Real* out) {
    for (std::uint64_t i = first; i < first + count; ++i) {
      const Vec3<double> p = generator.position(i);
      *out++ = static_cast<Real>(p.x);
      *out++ = static_cast<Real>(p.y);
      *out++ = static_cast<Real>(p.z);
    }
  });
}

void put_fields(const Generator& generator, double time, VtuWriter* writer) {
  writer->put_computed<float>([&](std::uint64_t first, std::uint64_t count, float* out) {
    for (std::uint64_t i = first; i < first + count; ++i)
      *out++ = temperature(generator.position(i));
  });
  writer->put_computed<float>([&](std::uint64_t first, std::uint64_t count, float* out) {
    for (std::uint64_t i = first; i < first + count; ++i)
      *out++ = front(generator.position(i), time);
  });
  writer->put_computed<float>([&](std::uint64_t first, std::uint64_t count, float* out) {
    for (std::uint64_t i = first; i < first + count; ++i) {
      const Vec3<float> v = velocity(generator.position(i));
      *out++ = v.x;
      *out++ = v.y;
      *out++ = v.z;
    }
  });
  writer->put_computed<std::int32_t>(
      [&](std::uint64_t first, std::uint64_t count, std::int32_t* out) {
        generator.regions(first, count, out);
      });
}

void put_cells(const Generator& generator, VtuWriter* writer) {
  // Runs begin and end with a tetrahedron: put_computed() cuts at multiples of a power of two.
  writer->put_computed<std::int64_t>(
      [&](std::uint64_t first, std::uint64_t count, std::int64_t* out) {
        generator.connectivity(first / 4, count / 4, out);
      });
  put_ends_and_types({generator.lattice().tets(), nullptr}, writer);
}

}  // namespace

GeneratedSize generate_mesh(const GenerateOptions& options, const std::string& path,
                            const WriteOptions& write) {
  check_options(options);
  const Generator generator(options);
  const Lattice& lattice = generator.lattice();
  check_rounding(options, lattice);
  check_mesh_output(path, write.encoding);
  MeshOutput output(path, write.encoding);
  VtuWriter writer(output.file(), layout_of(lattice, options, output.encoding()),
                   [&](double share) {
                     if (write.progress) write.progress(output.vtu_share() * share);
                   });
  put_fields(generator, options.time, &writer);
  if (options.double_precision) {
    put_positions<double>(generator, &writer);
  } else {
    put_positions<float>(generator, &writer);
  }
  put_cells(generator, &writer);
  writer.finish();
  output.commit(write.progress);
  return {lattice.points(), lattice.tets()};
}

}  // namespace tetfusion
