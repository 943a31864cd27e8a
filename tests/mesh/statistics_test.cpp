#include "mesh/statistics.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <vector>

#include "base/resources.h"

namespace tetfusion {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInf = std::numeric_limits<double>::infinity();

template <class T>
DataArray array_of(std::uint32_t components, const std::vector<T>& values) {
  DataArray a;
  a.info.type = value_type_of<T>();
  a.info.components = components;
  a.info.tuples = values.size() / components;
  a.bytes.resize(values.size() * sizeof(T));
  if (!values.empty()) std::memcpy(a.bytes.data(), values.data(), a.bytes.size());
  return a;
}

TEST(Statistics, Scalars) {
  const auto s = measure_array(array_of<float>(1, {3, -1, 2}));
  ASSERT_EQ(s.components.size(), 1u);
  EXPECT_EQ(s.components[0].min, -1);
  EXPECT_EQ(s.components[0].max, 3);
  EXPECT_EQ(s.magnitude.min, 1);
  EXPECT_EQ(s.magnitude.max, 3);
  EXPECT_EQ(s.diagonal(), 4);
  EXPECT_FALSE(s.constant());
  EXPECT_EQ(s.non_finite, 0u);
}

TEST(Statistics, Vectors) {
  const auto s = measure_array(array_of<double>(3, {3, 4, 0, 0, 0, 0}));
  EXPECT_EQ(s.components[1].max, 4);
  EXPECT_EQ(s.components[2].width(), 0);
  EXPECT_EQ(s.magnitude.min, 0);
  EXPECT_EQ(s.magnitude.max, 5);
  EXPECT_EQ(s.diagonal(), 5);
}

TEST(Statistics, VectorsWhoseSquaresAreNoNumbers) {
  for (const double scale : {1e200, 1e-200}) {
    const auto s = measure_array(array_of<double>(2, {3 * scale, 4 * scale, 0, scale}));
    EXPECT_DOUBLE_EQ(s.magnitude.min, scale);
    EXPECT_DOUBLE_EQ(s.magnitude.max, 5 * scale);
  }
}

// As simplify and compare see them: a tuple with one of them has no value.
TEST(Statistics, TuplesWithNonFiniteValuesAreLeftOut) {
  const auto s = measure_array(array_of<double>(2, {1, kNan, kInf, 5, 2, 7}));
  EXPECT_EQ(s.non_finite, 2u);
  EXPECT_EQ(s.components[0].max, 2);
  EXPECT_EQ(s.components[1].min, 7);
  EXPECT_EQ(s.magnitude.min, s.magnitude.max);
  EXPECT_FALSE(s.constant());
}

TEST(Statistics, OnlyNonFiniteValues) {
  const auto s = measure_array(array_of<double>(1, {kNan, -kInf}));
  EXPECT_TRUE(s.components[0].empty());
  EXPECT_TRUE(s.magnitude.empty());
  EXPECT_EQ(s.diagonal(), 0);
}

TEST(Statistics, EmptyRangesAddNothing) {
  Range range;
  range.add(Range{});
  EXPECT_TRUE(range.empty());
  range.add(3);
  range.add(Range{});
  EXPECT_EQ(range.min, 3);
  EXPECT_EQ(range.max, 3);
}

TEST(Statistics, Constant) {
  EXPECT_TRUE(measure_array(array_of<std::int32_t>(2, {7, 1, 7, 1})).constant());
  EXPECT_FALSE(measure_array(array_of<std::int32_t>(2, {7, 1, 7, 2})).constant());
}

TEST(Statistics, IntegersOfAllWidths) {
  const auto s = measure_array(array_of<std::int64_t>(1, {-(std::int64_t{1} << 40), 5}));
  EXPECT_EQ(s.components[0].min, -0x1p40);
  EXPECT_EQ(measure_array(array_of<std::uint8_t>(1, {255, 0})).components[0].max, 255);
  EXPECT_EQ(measure_array(array_of<std::int8_t>(1, {-128})).components[0].min, -128);
}

TEST(Statistics, EmptyAndStrings) {
  EXPECT_TRUE(measure_array(array_of<float>(1, {})).components[0].empty());
  DataArray text = array_of<std::uint8_t>(1, {'a', 0});
  text.info.type = ValueType::kString;
  EXPECT_TRUE(measure_array(text).components.empty());
}

TEST(Statistics, ManyBlocks) {
  std::vector<double> values(300000);
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<double>(i);
  const auto s = measure_array(array_of<double>(1, values));
  EXPECT_EQ(s.components[0].min, 0);
  EXPECT_EQ(s.components[0].max, 299999);
}

}  // namespace
}  // namespace tetfusion
