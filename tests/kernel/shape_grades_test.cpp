#include "kernel/shapes/shape_grades.h"

#include <gtest/gtest.h>

#include <cmath>

namespace tetfusion {
namespace {

TEST(ShapeGrades, WhatIsNotBelowTheFloorHasTheFirst) {
  const ShapeGrades grades(0.25);
  EXPECT_EQ(grades.floor(), 0x1p-6);
  for (const double q : {0x1p-6, 0.1, 1.0}) EXPECT_EQ(grades.grade_of(q), 0);
  EXPECT_EQ(grades.least(0), grades.floor());
}

// Each allows between 0.978 and 0.95 of the mean ratio that it was given for.
TEST(ShapeGrades, OthersAllowATwentiethLess) {
  for (const double floor : {0.05, 0.22, 0.9}) {
    const ShapeGrades grades(floor);
    int last = 0;
    for (double q = std::nextafter(floor, 0.0); q > 1e-3 * floor; q *= 0.999) {
      const std::uint8_t grade = grades.grade_of(q * q * q);
      const double allowed = std::cbrt(grades.least(grade));
      EXPECT_GE(grade, last);
      EXPECT_LE(allowed, 0.978 * q * (1 + 1e-12)) << q;
      EXPECT_GE(allowed, 0.95 * q) << q;
      last = grade;
    }
    EXPECT_GT(last, 200);
    EXPECT_LT(last, 255);
  }
}

TEST(ShapeGrades, NothingIsTooBadForTheLast) {
  const ShapeGrades grades(0.22);
  for (const double q : {1e-30, 0.0, -0.1}) EXPECT_EQ(grades.grade_of(q), 255);
  EXPECT_EQ(grades.least(255), 0);
  EXPECT_GT(grades.least(254), 0);
}

// Without a floor nothing is below it but what is turned over.
TEST(ShapeGrades, NoFloorNoGrades) {
  const ShapeGrades grades;
  EXPECT_EQ(grades.grade_of(0), 0);
  EXPECT_EQ(grades.least(grades.grade_of(-1)), 0);
}

}  // namespace
}  // namespace tetfusion
