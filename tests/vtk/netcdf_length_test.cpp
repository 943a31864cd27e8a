#include "vtk/netcdf_length.h"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace tetfusion {
namespace {

class Header {
 public:
  explicit Header(char version) : text_("CDF"), version_(version) { text_ += version; }

  Header& number(std::uint64_t value, int bytes = 4) {
    for (int i = bytes - 1; i >= 0; --i) text_ += static_cast<char>(value >> (8 * i) & 0xFF);
    return *this;
  }
  Header& count(std::uint64_t value) { return number(value, version_ == 5 ? 8 : 4); }
  Header& name(std::string_view name) {
    count(name.size());
    text_ += name;
    text_.resize((text_.size() + 3) / 4 * 4);
    return *this;
  }
  Header& list(std::uint64_t tag, std::uint64_t items) { return number(tag).count(items); }
  // Of type `type`, over these dimensions.
  Header& variable(std::string_view called, std::initializer_list<std::uint64_t> dimensions,
                   std::uint64_t type, std::uint64_t begin) {
    name(called).count(dimensions.size());
    for (const std::uint64_t d : dimensions) count(d);
    return list(0, 0).number(type).count(0).number(begin, version_ == 1 ? 4 : 8);
  }

  std::uint64_t length(std::uint64_t records) const {
    return netcdf_length(std::as_bytes(std::span(text_)), records);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  char version_;
};

// Dimensions: 0 has the records, 1 has 5, 2 has 3.
Header begun(char version, std::uint64_t records) {
  Header header(version);
  header.count(records).list(10, 3).name("time").count(0).name("nodes").count(5).name("d").count(3);
  header.list(12, 1).name("title").number(2).count(5);  // five letters and their padding
  return header.number('a' << 24).number('b' << 24);
}

TEST(NetcdfLength, OfVariablesWithoutRecords) {
  for (const char version : {1, 2, 5}) {
    Header header = begun(version, 0);
    header.list(11, 2).variable("x", {2, 1}, 6, 400).variable("ids", {1}, 4, 200);
    EXPECT_EQ(header.length(9), 400u + 5 * 3 * 8);
  }
}

TEST(NetcdfLength, OfRecords) {
  for (const char version : {1, 2, 5}) {
    Header header = begun(version, 4);
    // A record is 8 and 4 bytes, as 3 are padded.
    header.list(11, 3).variable("t", {0}, 6, 1000).variable("b", {0, 2}, 1, 1008);
    header.variable("x", {1}, 5, 400);
    EXPECT_EQ(header.length(9), 1008u + 3 * 12 + 3);
    EXPECT_EQ(header.length(2), 1008u + 1 * 12 + 3);
    EXPECT_EQ(header.length(0), 420u);
    Header alone = begun(version, 4);  // without padding between
    alone.list(11, 1).variable("b", {0, 2}, 1, 1000);
    EXPECT_EQ(alone.length(9), 1000u + 4 * 3);
  }
}

TEST(NetcdfLength, OfWhatDoesNotSay) {
  EXPECT_EQ(netcdf_length({}, 1), 0u);
  const Header whole = begun(1, 0).list(11, 1).variable("x", {1}, 6, 400);
  EXPECT_EQ(whole.length(1), 440u);
  for (std::size_t size = 0; size < whole.text().size(); ++size) {
    EXPECT_EQ(netcdf_length(std::as_bytes(std::span(whole.text()).first(size)), 1), 0u);
  }
  std::string other = whole.text();
  other[0] = 'H';
  EXPECT_EQ(netcdf_length(std::as_bytes(std::span(other)), 1), 0u);
}

}  // namespace
}  // namespace tetfusion
