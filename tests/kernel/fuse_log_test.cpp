#include "kernel/fuse_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "kernel/greedy_pass.h"
#include "support/meshes.h"
#include "support/work_meshes.h"

namespace tetfusion {
namespace {

template <class T>
DataArray make_array(std::uint32_t components, const Vector<T>& values) {
  DataArray array;
  array.info.name = "array";
  array.info.type = value_type_of<T>();
  array.info.components = components;
  array.info.tuples = values.size() / components;
  array.bytes.resize(values.size() * sizeof(T));
  std::memcpy(array.bytes.data(), values.data(), array.bytes.size());
  return array;
}

template <class T>
Vector<T> values_of(const DataArray& array) {
  const auto values = array.as<T>();
  return {values.begin(), values.end()};
}

FuseLog one_fusion() {
  FuseLog log;
  log.records.push_back({{1, 0, 4, 3}});
  log.nearest.push_back(2);
  log.pass_ends.push_back(1);
  return log;
}

TEST(CarryPointArray, FloatsTakeTheMean) {
  DataArray array = make_array<float>(2, {1, 10, 2, 20, 3, 30, 4, 40, 5, 50});
  carry_point_array(one_fusion(), {}, &array);
  EXPECT_EQ(values_of<float>(array), (Vector<float>{1, 10, 3, 30, 3, 30, 4, 40, 5, 50}));
}

TEST(CarryPointArray, IntegersTakeTheNearest) {
  DataArray array = make_array<std::int64_t>(1, {10, 11, 12, 13, 14});
  carry_point_array(one_fusion(), {}, &array);
  EXPECT_EQ(values_of<std::int64_t>(array), (Vector<std::int64_t>{10, 14, 12, 13, 14}));
}

TEST(CarryPointArray, FollowsTheRows) {
  DataArray array = make_array<double>(1, {0, 5, 1, 7, 2, 3, 4});
  const Vector<std::uint64_t> rows{0, 2, 4, 5, 6};  // points 0, 1, 2, 3, 4
  carry_point_array(one_fusion(), rows, &array);
  EXPECT_EQ(values_of<double>(array), (Vector<double>{0, 5, (1 + 0 + 4 + 3) / 4.0, 7, 2, 3, 4}));
}

TEST(CarryPointArray, LaterPassesSeeWhatEarlierOnesDid) {
  FuseLog log = one_fusion();
  log.records.push_back({{1, 2, 2, 2}});
  log.nearest.push_back(0);
  log.pass_ends.push_back(2);
  DataArray array = make_array<double>(1, {1, 2, 7, 4, 5});
  carry_point_array(log, {}, &array);
  EXPECT_EQ(array.as<double>()[1], (3.0 + 7 + 7 + 7) / 4);
}

TEST(CarryPointArray, NanStaysNan) {
  DataArray array = make_array<double>(1, {1, 2, 7, std::nan(""), 5});
  carry_point_array(one_fusion(), {}, &array);
  EXPECT_TRUE(std::isnan(array.as<double>()[1]));
}

TEST(CarryPointArray, ALinearFieldStaysLinear) {
  WorkMesh<double> mesh = testing::to_work_mesh(testing::five_split_cube(12, 0.2, 11));
  const auto f = [](const Vec3<double>& p) { return 2 * p.x - 3 * p.y + 0.5 * p.z + 1; };
  Vector<double> values;
  for (const auto& p : mesh.positions) values.push_back(f(p));
  DataArray array = make_array<double>(1, values);
  FuseLog log;
  GreedyPass<double> pass;
  PassLimits limits;
  while (pass.run(limits, {}, &mesh, &log).fused > 0) ++limits.number;
  ASSERT_GT(log.pass_ends.size(), 2u);
  carry_point_array(log, {}, &array);
  for (std::size_t v = 0; v < mesh.vertex_count(); ++v) {
    EXPECT_NEAR(array.as<double>()[mesh.point_ids[v]], f(mesh.positions[v]), 1e-13);
  }
}

}  // namespace
}  // namespace tetfusion
