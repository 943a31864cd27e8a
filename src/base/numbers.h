// Numbers as users write them: 90%, 0.9, 2.5M, 1G.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tetfusion {

std::optional<double> parse_number(std::string_view text);  // all of the text, or nothing; finite
std::optional<double> parse_share(std::string_view text);   // "0.5%" is 0.005, "0.005" too
std::optional<std::uint64_t> parse_count(
    std::string_view text);  // "1000000", "1M", "2.5k", "1G" (powers of 1000)
std::vector<std::string> split(std::string_view text, char separator);

std::string format_count(std::uint64_t count);  // 1,499,160
std::string format_bytes(std::uint64_t bytes);  // 1.4 GiB

}  // namespace tetfusion
