#include "partition/interface_table.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <tuple>
#include <vector>

#include "mesh/work_mesh.h"
#include "partition/id_ranges.h"
#include "support/interface_tables.h"
#include "support/meshes.h"

namespace tetfusion {
namespace {

auto tied(const InterfaceReport& r) { return std::tie(r.id, r.low, r.high, r.marks, r.touched); }

void expect_same(const InterfaceTable& a, const InterfaceTable& b) {
  ASSERT_EQ(a.entries().size(), b.entries().size());
  for (std::size_t i = 0; i < a.entries().size(); ++i) {
    EXPECT_EQ(tied(a.entries()[i]), tied(b.entries()[i]));
  }
}

Vector<InterfaceReport> random_reports(std::size_t count, std::uint64_t ids) {
  Vector<InterfaceReport> reports;
  for (std::size_t i = 0; i < count; ++i) {
    const auto pick = [&](std::uint64_t k, double below) {
      return static_cast<std::uint32_t>(below * testing::uniform(5, 5 * i + k));
    };
    const std::uint32_t low = pick(1, 100);
    reports.push_back({pick(0, double(ids)) * 40'000'003u, low, low + pick(2, 30),
                       static_cast<std::uint8_t>(1 << pick(3, 3)), pick(4, 4) == 0});
  }
  return reports;
}

TEST(InterfaceTable, JoinsWhatIsSaidOfAVertex) {
  const InterfaceTable table = testing::table_of({{7, 3, 5, kLocked, false},
                                                  {2, 1, 1, 0, false},
                                                  {7, 4, 9, kOnBoundary, true},
                                                  {7, 2, 2, 0, false}});
  ASSERT_EQ(table.entries().size(), 2u);
  ASSERT_NE(table.find(7), nullptr);
  EXPECT_EQ(tied(*table.find(7)), tied(InterfaceReport{7, 2, 9, kLocked | kOnBoundary, true}));
  EXPECT_EQ(tied(*table.find(2)), tied(InterfaceReport{2, 1, 1, 0, false}));
  for (const VertexId id : {0u, 1u, 3u, 6u, 8u, kNoVertex}) EXPECT_EQ(table.find(id), nullptr);
}

TEST(InterfaceTable, MayHaveOneLargeId) {
  for (const VertexId id : {0x7FFFFFFFu, 0x80000000u, kNoVertex - 1}) {
    const InterfaceTable table = testing::table_of({{id, 1, 2, kLocked, true}});
    ASSERT_NE(table.find(id), nullptr);
    EXPECT_EQ(table.find(id)->low, 1u);
    EXPECT_EQ(table.find(id - 1), nullptr);
    EXPECT_EQ(table.find(5), nullptr);
  }
}

TEST(InterfaceTable, MayBeEmpty) {
  EXPECT_EQ(InterfaceTable().find(0), nullptr);
  EXPECT_TRUE(testing::table_of({}).entries().empty());
}

std::vector<Vector<InterfaceReport>> sorted_parts(const Vector<InterfaceReport>& reports) {
  std::vector<Vector<InterfaceReport>> parts(5);  // the last one stays empty
  for (std::size_t i = 0; i < reports.size(); ++i) parts[i % 7 % 4].push_back(reports[i]);
  for (auto& part : parts) sort_by_id(&part);
  return parts;
}

TEST(InterfaceTable, IsTheSameFromParts) {
  const Vector<InterfaceReport> reports = random_reports(2000, 60);
  expect_same(InterfaceTable(sorted_parts(reports)), testing::table_of(reports));
  EXPECT_TRUE(InterfaceTable(std::vector<Vector<InterfaceReport>>(3)).entries().empty());
}

// Those of an id come together, however few are taken at once.
TEST(IdRanges, HoldAllItemsOnceInOrder) {
  const Vector<InterfaceReport> reports = random_reports(2000, 60);
  for (const std::size_t at_once : {std::size_t{1}, std::size_t{7}, std::size_t{5000}}) {
    Vector<InterfaceReport> all;
    std::size_t ranges = 0;
    for_each_id_range(
        sorted_parts(reports),
        [&](const Vector<InterfaceReport>& items) {
          if (!items.empty() && !all.empty()) {
            EXPECT_LT(all.back().id, items.front().id);
          }
          all.insert(all.end(), items.begin(), items.end());
          ++ranges;
        },
        at_once);
    EXPECT_EQ(ranges, reports.size() / at_once + 1);
    ASSERT_EQ(all.size(), reports.size());
    EXPECT_TRUE(std::ranges::is_sorted(all, {}, &InterfaceReport::id));
    const auto by_all = [](const InterfaceReport& a, const InterfaceReport& b) {
      return tied(a) < tied(b);
    };
    Vector<InterfaceReport> expected = reports;
    std::ranges::sort(expected, by_all);
    std::ranges::sort(all, by_all);
    for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(tied(all[i]), tied(expected[i]));
  }
}

TEST(InterfaceTable, IsTheSameForAnyOrderOfReports) {
  Vector<InterfaceReport> reports = random_reports(2000, 60);
  const InterfaceTable table = testing::table_of(reports);
  EXPECT_EQ(table.entries().size(), 60u);
  std::ranges::reverse(reports);
  expect_same(testing::table_of(reports), table);
  for (std::uint64_t seed = 0; seed < 5; ++seed) {
    for (std::size_t i = reports.size() - 1; i > 0; --i) {
      const auto j = static_cast<std::size_t>(double(i + 1) * testing::uniform(seed, i));
      std::swap(reports[i], reports[j]);
    }
    expect_same(testing::table_of(reports), table);
  }
}

TEST(InterfaceTable, AgreesWithAMap) {
  const Vector<InterfaceReport> reports = random_reports(3000, 500);
  std::map<VertexId, InterfaceReport> expected;
  for (const InterfaceReport& r : reports) {
    InterfaceReport& all = expected.try_emplace(r.id, r).first->second;
    all.low = std::min(all.low, r.low);
    all.high = std::max(all.high, r.high);
    all.marks |= r.marks;
    all.touched = all.touched || r.touched;
  }
  const InterfaceTable table = testing::table_of(reports);
  ASSERT_EQ(table.entries().size(), expected.size());
  for (const auto& [id, report] : expected) {
    const InterfaceReport* found = table.find(id);
    ASSERT_NE(found, nullptr);
    EXPECT_EQ(tied(*found), tied(report));
    EXPECT_EQ(table.find(id + 1), nullptr);
  }
}

}  // namespace
}  // namespace tetfusion
