#include "base/numbers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>

namespace tetfusion {
namespace {

TEST(Numbers, Shares) {
  EXPECT_DOUBLE_EQ(*parse_share("90%"), 0.9);
  EXPECT_DOUBLE_EQ(*parse_share("0.9"), 0.9);
  EXPECT_DOUBLE_EQ(*parse_share("0.5%"), 0.005);
  EXPECT_TRUE(is_bare_one("1") && is_bare_one("1.0"));
  EXPECT_FALSE(is_bare_one("1%") || is_bare_one("100%") || is_bare_one("0.5") || is_bare_one(""));
  for (const char* bad : {"", "%", "9O%", "0.9 ", "nan", "inf", "1e999", "--1"}) {
    EXPECT_FALSE(parse_share(bad)) << bad;
  }
}

TEST(Numbers, AsFilesHaveThem) {
  EXPECT_EQ(number_in<int>("+1"), 1);
  EXPECT_EQ(number_in<std::uint64_t>("18446744073709551615"), 18446744073709551615u);
  EXPECT_EQ(number_in<double>("+1.5D+02"), 150);
  EXPECT_EQ(number_in<float>("1d0"), 1);
  EXPECT_EQ(number_in<double>("1e-400"), 0);
  EXPECT_EQ(number_in<float>("-1e40"), -std::numeric_limits<float>::infinity());
  for (const char* bad : {"", "+", "-", "+-5", "++5", "1 ", " 1", "1.5.", "D0", "x"}) {
    EXPECT_FALSE(number_in<double>(bad)) << bad;
    EXPECT_FALSE(number_in<int>(bad)) << bad;
  }
  EXPECT_FALSE(number_in<std::int8_t>("128"));
  EXPECT_EQ(trimmed(" \t a b\r\n"), "a b");
  EXPECT_EQ(trimmed(" \n"), "");
}

TEST(Numbers, Counts) {
  EXPECT_EQ(*parse_count("1000000"), 1000000u);
  EXPECT_EQ(*parse_count("1M"), 1000000u);
  EXPECT_EQ(*parse_count("2.5k"), 2500u);
  EXPECT_EQ(*parse_count("1G"), 1000000000u);
  // Products that double precision does not hold exactly.
  EXPECT_EQ(*parse_count("4.1M"), 4100000u);
  EXPECT_EQ(*parse_count("16.1k"), 16100u);
  EXPECT_EQ(*parse_count("2.01M"), 2010000u);
  for (std::uint64_t thousands = 1; thousands < 100'000; thousands += 7) {
    const std::string text = std::to_string(thousands / 1000) + "." +
                             std::to_string(1000 + thousands % 1000).substr(1) + "M";
    ASSERT_EQ(parse_count(text), thousands * 1000) << text;
  }
  for (const char* bad : {"", "M", "-1", "0.5", "1.0000001k", "1.0005k2", "1e300", "1T", "nan"}) {
    EXPECT_FALSE(parse_count(bad)) << bad;
  }
}

TEST(Numbers, Bytes) {
  constexpr std::uint64_t kGiB = std::uint64_t{1} << 30;
  EXPECT_EQ(*parse_bytes("4096"), 4096u);
  EXPECT_EQ(*parse_bytes("0"), 0u);
  EXPECT_EQ(*parse_bytes("2k"), 2048u);
  EXPECT_EQ(*parse_bytes("512M"), kGiB / 2);
  EXPECT_EQ(*parse_bytes("1.5g"), kGiB / 2 * 3);
  EXPECT_EQ(*parse_bytes("2GiB"), 2 * kGiB);
  EXPECT_EQ(*parse_bytes("512MiB"), kGiB / 2);
  EXPECT_EQ(*parse_bytes("1T"), 1024 * kGiB);
  EXPECT_EQ(*parse_bytes("0.1G"), 107374182u);
  for (const char* bad : {"", "G", "GiB", "iB", "4iB", "-1G", "2GB", "2 G", "1.5", "nan", "inf",
                          "1e300G", "99999T"}) {
    EXPECT_FALSE(parse_bytes(bad)) << bad;
  }
}

TEST(Numbers, Formats) {
  EXPECT_EQ(format_count(0), "0");
  EXPECT_EQ(format_count(999), "999");
  EXPECT_EQ(format_count(1499160), "1,499,160");
  EXPECT_EQ(format_count(1, "point"), "1 point");
  EXPECT_EQ(format_count(0, "point"), "0 points");
  EXPECT_EQ(format_count(1, "vertex", "vertices"), "1 vertex");
  EXPECT_EQ(format_count(2000, "vertex", "vertices"), "2,000 vertices");
  EXPECT_EQ(format_bytes(10), "10 bytes");
  EXPECT_EQ(format_bytes(1536), "1.5 KiB");
  EXPECT_EQ(format_memory(0), "0M");
  EXPECT_EQ(format_memory(1), "1M");
  EXPECT_EQ(format_memory(1048577), "2M");
  EXPECT_EQ(format_memory(std::uint64_t{3} << 30), "3072M");
}

TEST(Numbers, KnowsWhatIsOutOfRange) {
  EXPECT_EQ(out_of_range_number<float>("-2.5e-60"), 0);
  EXPECT_TRUE(std::signbit(out_of_range_number<float>("-2.5e-60")));
  EXPECT_EQ(out_of_range_number<double>("2.5e-400"), 0);
  EXPECT_EQ(out_of_range_number<double>("2.5e400"), std::numeric_limits<double>::infinity());
  EXPECT_EQ(out_of_range_number<float>("-2.5e60"), -std::numeric_limits<float>::infinity());
  EXPECT_EQ(out_of_range_number<float>("1.2e-45"), std::numeric_limits<float>::denorm_min());
}

TEST(Numbers, Splits) {
  EXPECT_EQ(split("a,,b", ','), (std::vector<std::string>{"a", "", "b"}));
  EXPECT_EQ(split("", ','), (std::vector<std::string>{""}));
}

}  // namespace
}  // namespace tetfusion
