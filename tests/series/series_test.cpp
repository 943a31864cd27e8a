// A shared series from files to files: what fitting does, and faults at any of its file calls.
#include "series/series.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <new>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/resources.h"
#include "driver/simplify.h"
#include "follow/apply_map.h"
#include "follow/point_weights.h"
#include "io/open_mesh.h"
#include "io/progressive/map_file.h"
#include "series/other_arrays.h"
#include "support/faulty_file_system.h"
#include "support/mesh_file.h"
#include "support/meshes.h"
#include "support/temp_dir.h"

namespace tetfusion {
namespace {

namespace fs = std::filesystem;
using testing::bytes_of;
using testing::FaultyFileSystem;
using testing::five_split_cube;
using ::testing::HasSubstr;
using testing::MeshFile;
using testing::point_array;
using testing::TempDir;
using P = Vec3<double>;

MeshFile box_with_wave(std::uint32_t n, double time) {
  MeshFile file;
  file.geometry = five_split_cube(n, 0.15, 4);
  file.point_arrays.push_back(point_array<double>(
      file, "wave", [&](const P& p) { return std::exp(-0.3 * std::pow(p.x - time, 2)) + p.z; }));
  file.point_arrays.push_back(
      point_array<double>(file, "plane", [&](const P& p) { return p.x - time * p.y; }));
  return file;
}

class Series : public ::testing::Test {
 protected:
  Series() {
    for (int i = 0; i < 3; ++i) {
      request.inputs.push_back(folder.file("step" + std::to_string(i) + ".vtu"));
      box_with_wave(6, 2.0 * i).write(request.inputs.back());
    }
    request.job.output = folder.file("out.pvd");
    request.job.behaviour.reduction = 0.4;
    request.job.performance.threads = 1;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& entry : fs::directory_iterator(folder.path())) {
      all.push_back(entry.path().filename().string());
    }
    std::sort(all.begin(), all.end());
    return all;
  }
  MapFile simplify_with_map() {
    request.job.map = folder.file("points.map");
    simplify_series(request);
    return MapFile::open(request.job.map);
  }
  TempDir folder = TempDir::in_memory();
  SeriesRequest request;
};

TEST_F(Series, FitComesNearerThanInterpolation) {
  request.job.map = folder.file("points.map");
  const SeriesReport report = simplify_series(request);
  const MapFile map = MapFile::open(request.job.map);
  const PointWeights weights(map, "");
  for (std::size_t i = 0; i < 3; ++i) {
    const auto step = open_mesh(request.inputs[i]);
    const auto between = apply_map(map, step.get(), {"wave"}, {});
    const auto fitted = fit_arrays(map, weights, step.get(), {{"wave"}}, {});
    EXPECT_LT(fitted[0].rms, between[0].rms);
    EXPECT_EQ(fitted[0].rms, report.steps[i].arrays[0].rms);
    const auto bounded = fit_arrays(map, weights, step.get(), {{"wave", 0.9 * fitted[0].max}}, {});
    EXPECT_LE(bounded[0].max, 0.9 * fitted[0].max);
  }
}

// By hand, of what the map says; and what several threads make of it is the same.
TEST_F(Series, CellsHaveTheMeansOfThoseInThem) {
  MeshFile file = box_with_wave(6, 1);
  const std::size_t count = file.geometry.tets.size();
  const DataArray rows = testing::make_array<double>(
      "f", count, 2, [](std::size_t t, std::size_t k) { return std::sin(0.7 * (2. * t + k)); });
  file.cell_arrays = {rows};
  for (const std::string& path : request.inputs) file.write(path);
  const MapFile map = simplify_with_map();
  const auto step = open_mesh(request.inputs[0]);
  ASSERT_TRUE(has_cells_of(map, step.get(), {}));
  const MovedCells moved = CellMover(map).move(step.get(), {0}, {})[0];
  EXPECT_TRUE(moved.has_means);
  std::vector<double> sums(2 * map.counts().tets), weights(map.counts().tets);
  for (std::size_t c = 0; c < count; ++c) {
    const auto [tet, share] = map.homes()[c];
    if (tet == kNoTet) continue;
    weights[tet] += share;
    for (std::size_t k : {0, 1}) sums[2 * tet + k] += share * rows.as<double>()[2 * c + k];
  }
  std::size_t means = 0;
  for (std::size_t t = 0; t < map.counts().tets; ++t) {
    const auto [cell, is_mean] = map.origins()[t];
    means += is_mean;
    for (std::size_t k : {0, 1}) {
      const double got = moved.array.as<double>()[2 * t + k];
      if (is_mean == 0) {
        EXPECT_EQ(got, rows.as<double>()[2 * cell + k]);
      } else {
        EXPECT_GE(weights[t], 0.125);
        EXPECT_NEAR(got, sums[2 * t + k] / weights[t], 1e-12);
      }
    }
  }
  EXPECT_GT(means, map.counts().tets / 2);
  set_thread_count(4);
  EXPECT_EQ(CellMover(map).move(step.get(), {0}, {})[0].array.bytes, moved.array.bytes);
  const auto other = open_mesh(folder.file("out_0.vtu"));
  EXPECT_FALSE(has_cells_of(map, other.get(), {}));
}

// A point without a value in one of the steps stays, and its neighbours have theirs.
TEST_F(Series, WhatIsNoNumberDoesNotSpread) {
  constexpr std::size_t kHole = 171;  // inside
  MeshFile step = box_with_wave(6, 2);
  step.point_arrays[0].as<double>()[kHole] = std::numeric_limits<double>::quiet_NaN();
  step.write(request.inputs[1]);
  request.job.behaviour.max_error = 0.05;
  const SeriesReport report = simplify_series(request);
  EXPECT_LE(report.steps[1].arrays[0].max, 0.05);
  const auto result = open_mesh(folder.file("out_1.vtu"));
  const DataArray wave = testing::read_point_array(result.get(), "wave");
  std::size_t holes = 0;
  for (std::size_t i = 0; i < wave.info.tuples; ++i) holes += std::isnan(wave.as<double>()[i]);
  EXPECT_EQ(holes, 1u);
}

// The same mesh, but for the array.
TEST_F(Series, WhatOnlySteersIsNotInTheResult) {
  SimplifyRequest job = request.job;
  job.input = request.inputs[0];
  job.behaviour.fit_values = false;  // it would be where it is carried
  const auto run = [&](bool steers_only) {
    job.output = folder.file(steers_only ? "without.vtu" : "with.vtu");
    job.behaviour.arrays = {"sum"};
    OtherArrays arrays;
    auto source = open_mesh(job.input);
    ArrayInfo info = source->description().point_data.arrays[0];
    info.name = "sum";
    info.steers_only = steers_only;
    arrays.points = {
        {info, [](const MeshStream& mesh, std::uint64_t first, std::span<std::byte> out) {
           mesh.read_rows(Association::kPoint, 0, first, out.size() / sizeof(double), out);
         }}};
    simplify(job, with_arrays(std::move(source), std::move(arrays)));
    return open_mesh(job.output);
  };
  const auto with = run(false), without = run(true);
  EXPECT_EQ(with->description().point_data.arrays.size(), 1u);
  EXPECT_EQ(without->description().point_data.arrays.size(), 0u);
  const Geometry a = with->read_geometry(), b = without->read_geometry();
  EXPECT_LT(b.tets.size(), box_with_wave(6, 0).geometry.tets.size());
  EXPECT_EQ(a.tets, b.tets);
  for (const Tet& t : a.tets) {
    for (const VertexId v : t) {
      const P p = testing::point(a, v), q = testing::point(b, v);
      ASSERT_EQ(std::tie(p.x, p.y, p.z), std::tie(q.x, q.y, q.z));
    }
  }
}

// In more than one window, each place's new corners are parts of the window, in the order of the
// points and the ranges, and nothing else is.
TEST_F(Series, PartsAreThePlacesTheOtherWayRound) {
  request.inputs = {folder.file("big0.vtu"), folder.file("big1.vtu")};
  for (int i = 0; i < 2; ++i) box_with_wave(44, 9.0 * i).write(request.inputs[i]);
  const MapFile map = simplify_with_map();
  for (const std::string& where : {std::string(), folder.path().string()}) {
    const PointWeights weights(map, where);
    ASSERT_EQ(weights.windows(), 2u);
    std::size_t kept = 0, stayed = 0;
    for (std::size_t w = 0; w < weights.windows(); ++w) {
      std::map<std::pair<std::size_t, VertexId>, double> wanted, got;
      const auto places = weights.places(w);
      for (std::size_t i = 0; i < places.size(); ++i) {
        const MapPlace& place = map.places()[weights.first_of(w) + i];
        ASSERT_NE(place.cell, kNoCell);
        for (std::size_t k = 0; k < 4; ++k) {
          const auto corner = static_cast<VertexId>(map.corners(place.cell)[k]);
          EXPECT_EQ(places[i].weights[k], place.weights[k]);
          if (place.weights[k] == 0) continue;
          EXPECT_EQ(places[i].corners[k], corner);
          if (weights.is_new()[corner] != 0) wanted[{i, corner}] = place.weights[k];
          stayed += weights.is_new()[corner] == 0 && place.weights[k] == 1 ? 1 : 0;
        }
      }
      VertexId last_range_most = 0;
      for (std::size_t r = 0; r < PointWeights::kRanges; ++r) {
        const auto parts = weights.parts(w, r);
        EXPECT_TRUE(std::is_sorted(parts.begin(), parts.end(),
                                   [](const auto& a, const auto& b) { return a.from < b.from; }));
        VertexId most = last_range_most;
        for (const PointWeights::Part& part : parts) {
          EXPECT_GE(part.to, last_range_most);
          most = std::max(most, part.to + 1);
          EXPECT_TRUE(got.emplace(std::pair(part.from, part.to), part.weight).second);
        }
        last_range_most = most;
      }
      EXPECT_EQ(got, wanted);
      kept += got.size();
    }
    EXPECT_GT(kept, 1000u);
    EXPECT_GT(stayed, 1000u);
  }
}

// One thread adds up what several keep apart, range by range.
TEST_F(Series, AnyNumberOfThreadsFitsTheSame) {
  const MapFile map = simplify_with_map();
  const PointWeights weights(map, "");
  const auto step = open_mesh(request.inputs[1]);
  const auto fitted = [&](int threads) {
    set_thread_count(threads);
    return fit_arrays(map, weights, step.get(), {{"wave", 0.01}}, {})[0].array.bytes;
  };
  const auto by_one = fitted(1), by_four = fitted(4);
  set_thread_count(1);
  EXPECT_TRUE(by_one == by_four);
}

// Towards a goal bounds are not looked at on the way where it is reached without breaking them.
TEST_F(Series, ALooseBoundChangesNothingBesideAGoal) {
  std::vector<Vector<Tet>> meshes;
  for (const double max_error : {0.9, 0.5}) {
    request.job.behaviour.max_error = max_error;
    const SeriesReport report = simplify_series(request);
    EXPECT_EQ(report.tries, 1);
    meshes.push_back(open_mesh(report.steps[1].output)->read_geometry().tets);
  }
  EXPECT_EQ(meshes[0], meshes[1]);
}

TEST_F(Series, ATightBoundHasASayInTheGoal) {
  std::vector<std::string> said;
  RunContext context;
  context.notice = [&](std::string_view text) { said.emplace_back(text); };
  request.job.behaviour.reduction = 0.6;
  request.job.behaviour.max_error = 0.004;
  const SeriesReport report = simplify_series(request, context);
  EXPECT_GT(report.tries, 1);
  EXPECT_THAT(said, ::testing::Contains(HasSubstr("once more, with bounds")));
  for (const StepReport& step : report.steps) EXPECT_LE(step.arrays[0].max, 0.004);
}

// Where what comes back after eight steps gets another sign, the sum of both is nothing.
TEST_F(Series, StepsBeyondTheirBoundAreHeldByThemselves) {
  std::vector<std::string> said;
  RunContext context;
  context.notice = [&](std::string_view text) { said.emplace_back(text); };
  request.inputs.clear();
  for (int i = 0; i < 16; ++i) {
    MeshFile file;
    file.geometry = testing::five_split_cube(10, 0.2, 4);
    file.point_arrays.push_back(testing::point_array<double>(file, "wave", [&](const P& p) {
      return std::tanh(2 * (p.x - 1.2 * (i % 8))) + 0.1 * std::sin(p.y);
    }));
    request.inputs.push_back(folder.file("front_" + std::to_string(100 + i) + ".vtu"));
    file.write(request.inputs.back());
  }
  request.job.behaviour.reduction.reset();
  request.job.behaviour.max_error = 0.03;
  const SeriesReport report = simplify_series(request, context);
  EXPECT_THAT(said, ::testing::Contains(HasSubstr("a bound for the worst steps themselves")));
  ASSERT_EQ(report.steps.size(), 16u);
  for (const StepReport& step : report.steps) EXPECT_LE(step.arrays[0].max, 0.03);
  EXPECT_LT(report.runs[0].output.tets, report.runs[0].input.tets * 9 / 10);
}

TEST_F(Series, AFittedLinearFieldStaysLinear) {
  const MapFile map = simplify_with_map();
  const PointWeights weights(map, "");
  const auto step = open_mesh(request.inputs[2]);
  const auto between = apply_map(map, step.get(), {"plane"}, {});
  const auto fitted = fit_arrays(map, weights, step.get(), {{"plane", 1e-3}}, {});
  for (std::size_t p = 0; p < map.counts().points; ++p) {
    EXPECT_NEAR(fitted[0].array.as<double>()[p], between[0].array.as<double>()[p], 1e-13);
  }
}

// Squares of values beyond 1e154 and below 1e-162 are no numbers any more.
TEST_F(Series, FieldsOfAnyMagnitudeAreFittedAlike) {
  const MapFile map = simplify_with_map();
  const PointWeights weights(map, "");
  const auto moved = [&](double scale) {
    MeshFile file = box_with_wave(6, 2);
    for (double& value : file.point_arrays[0].as<double>()) value *= scale;
    const std::string path = folder.file("scaled.vtu");
    file.write(path);
    const auto step = open_mesh(path);
    std::vector<double> all;
    for (const MovedArray& array : {fit_arrays(map, weights, step.get(), {{"wave", 0.02}}, {})[0],
                                    apply_map(map, step.get(), {"wave"}, {})[0]}) {
      all.insert(all.end(), {array.rms, array.max, array.rounding});
      for (const double value : array.array.as<double>()) all.push_back(value / scale);
    }
    return all;
  };
  const std::vector<double> usual = moved(1);
  EXPECT_GT(usual[0], 0);
  for (const double scale : {0x1p+1018, 0x1p+500, 0x1p-500, 0x1p-900}) {
    EXPECT_EQ(moved(scale), usual) << scale;
  }
}

// A point between corners that all stayed has an error that no value can help.
TEST_F(Series, ABoundThatCannotBeKeptIsSeen) {
  const MapFile map = simplify_with_map();
  const PointWeights weights(map, "");
  const auto step = open_mesh(request.inputs[0]);
  const auto moved = fit_arrays(map, weights, step.get(), {{"wave", 1e-9}}, {});
  EXPECT_GT(moved[0].max, 1e-9);
}

// With two threads meshes are compared while the simplification goes on.
TEST_F(Series, AMeshThatIsAnotherOneEndsTheSimplification) {
  request.job.performance.threads = 2;
  MeshFile other = box_with_wave(6, 4);
  std::swap(other.geometry.tets[3][0], other.geometry.tets[3][1]);
  other.write(request.inputs.back());
  const std::vector<std::string> before = names();
  for (int i = 0; i < 5; ++i) {
    try {
      simplify_series(request);
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kBadInput);
      EXPECT_THAT(error.what(), HasSubstr("cell 3 has the points"));
    }
    EXPECT_EQ(names(), before);
  }
}

TEST_F(Series, AnAbandonedSimplificationSaysSo) {
  const std::atomic<bool> failed{true};
  RunContext context;
  context.abandoned = &failed;
  SimplifyRequest job = request.job;
  job.input = request.inputs[0];
  job.output = folder.file("one.vtu");
  EXPECT_THROW(simplify(job, context), Abandoned);
}

TEST_F(Series, EveryFaultLeavesWholeFilesAlone) {
  simplify_series(request);
  const std::vector<std::string> whole = names();
  std::vector<std::string> bytes;
  for (const std::string& name : whole) bytes.push_back(bytes_of(folder.file(name)));
  const auto remove_outputs = [&] {
    for (const std::string& name : names()) {
      if (name.starts_with("out")) fs::remove_all(folder.path() / name);
    }
  };
  std::int64_t calls = 0;
  {
    remove_outputs();
    FaultyFileSystem system;
    simplify_series(request);
    calls = system.calls();
  }
  int failed = 0;
  for (std::int64_t n = 0; n < calls; ++n) {
    remove_outputs();
    bool threw = false;
    {
      FaultyFileSystem system;
      system.fail(n, n % 2 == 0 ? EIO : ENOSPC);
      try {
        simplify_series(request);
      } catch (const Error& error) {
        threw = true;
        EXPECT_NE(error.code(), ErrorCode::kBroken) << error.what();
      } catch (const std::bad_alloc&) {  // the command says so, with exit code 5
        threw = true;
      }
    }
    failed += threw ? 1 : 0;
    const std::vector<std::string> left = names();
    for (const std::string& name : left) {
      const auto at = std::find(whole.begin(), whole.end(), name);
      ASSERT_NE(at, whole.end()) << name << " is left after call " << n;
      EXPECT_EQ(bytes_of(folder.file(name)), bytes[static_cast<std::size_t>(at - whole.begin())])
          << name << " after call " << n;
    }
    if (!threw) {
      EXPECT_EQ(left, whole) << n;
    }
  }
  EXPECT_GT(failed, 40);
}

TEST_F(Series, AFullDiskSaysWhichStepsAreDone) {
  simplify_series(request);
  fs::remove(folder.file("out_2.vtu"));
  fs::create_directory(folder.file("out_2.vtu"));  // in the way of the last step
  EXPECT_THROW(simplify_series(request), Error);
  fs::remove(folder.file("out_2.vtu"));
  std::uintmax_t size = 0;
  for (int i = 0; i < 2; ++i)
    size = fs::file_size(folder.file("out_" + std::to_string(i) + ".vtu"));
  bool seen = false;
  for (std::int64_t room = 0; room < 60 && !seen; ++room) {
    FaultyFileSystem system;
    system.fill_up_after(room * static_cast<std::int64_t>(size) / 2);
    try {
      simplify_series(request);
      break;
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ErrorCode::kIo);
      const std::string what = error.what();
      seen = what.find("steps written: 2 of 3, the last is") != std::string::npos;
    }
  }
  EXPECT_TRUE(seen);
}

}  // namespace
}  // namespace tetfusion
