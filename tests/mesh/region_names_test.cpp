#include "mesh/regions/region_names.h"

#include <gtest/gtest.h>

#include <string>

namespace tetfusion {
namespace {

ArrayInfo integers(const std::string& name) { return {name, ValueType::kInt32, 1, {}, 0}; }

TEST(RegionNames, AreThoseOfMaterials) {
  for (const char* name : {"material", "MaterialIds", "gmsh:physical", "tetgen:ref", "ZoneId",
                           "PartIds", "partid", "part_3", "subregions", "ObjectId"}) {
    EXPECT_TRUE(looks_like_region(integers(name))) << name;
    EXPECT_FALSE(may_be_region(integers(name))) << name;  // it is taken, so not told of
  }
  for (const char* name : {"partition", "particle", "department", "party", "rank_block",
                           "process_region", "parallel_part", "avtGhostZones"}) {
    EXPECT_FALSE(looks_like_region(integers(name))) << name;
  }
  EXPECT_FALSE(looks_like_region({"material", ValueType::kFloat32, 1, {}, 0}));
  EXPECT_FALSE(looks_like_region({"material", ValueType::kInt32, 2, {}, 0}));
}

TEST(RegionNames, MayMeanRegionsWhereTheyDoNotSayWhatTheyAre) {
  for (const char* name :
       {"mat", "MAT_ID", "CellEntityIds", "gmsh:geometrical", "domains", "tag1", "cell_tags",
        "bodyId", "ElementGroups", "marker", "cell_scalars", "f_1", "unit"}) {
    EXPECT_TRUE(may_be_region(integers(name))) << name;
    EXPECT_FALSE(looks_like_region(integers(name))) << name;
  }
  for (const char* name : {"vtkGhostType", "rank", "RankId", "partition", "index", "id", "cell_ids",
                           "ElementId", "GlobalElementIds", "number", "avtGhostZones", ""}) {
    EXPECT_FALSE(may_be_region(integers(name))) << name;
  }
  EXPECT_FALSE(may_be_region({"mat", ValueType::kFloat64, 1, {}, 0}));
  EXPECT_TRUE(is_region_of_floats({"MaterialIds", ValueType::kFloat64, 1, {}, 0}));
  EXPECT_FALSE(is_region_of_floats({"mat", ValueType::kFloat64, 1, {}, 0}));
  EXPECT_FALSE(is_region_of_floats({"MaterialAxis", ValueType::kFloat32, 3, {}, 0}));
  EXPECT_FALSE(is_region_of_floats(integers("MaterialIds")));
}

TEST(RegionNames, SomeMayBePartitions) {
  for (const char* name : {"part", "PartId", "partition", "Rank", "proc_zone"}) {
    EXPECT_TRUE(may_be_partition(integers(name))) << name;
  }
  for (const char* name : {"material", "particle_zone", "procedure", "region"}) {
    EXPECT_FALSE(may_be_partition(integers(name))) << name;
  }
}

// By whatever name, if a user gives it.
TEST(RegionNames, AnyNumbersOfOneComponentCanBeRegions) {
  EXPECT_TRUE(can_be_region(integers("a")));
  EXPECT_TRUE(can_be_region({"a", ValueType::kFloat32, 1, {}, 0}));
  EXPECT_TRUE(can_be_region({"a", ValueType::kFloat64, 1, {}, 0}));
  EXPECT_FALSE(can_be_region({"a", ValueType::kFloat64, 3, {}, 0}));
  EXPECT_FALSE(can_be_region({"a", ValueType::kString, 1, {}, 0}));
  EXPECT_FALSE(is_integer_label({"a", ValueType::kFloat64, 1, {}, 0}));
}

}  // namespace
}  // namespace tetfusion
