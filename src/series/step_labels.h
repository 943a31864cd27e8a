// What tells the steps of a series apart: the labels that stand for {step}.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace tetfusion {

// The labels of files: what differs between their names, numbers not cut (with sign, digits behind
// the point and exponent, where these are told from what else may stand there); of a single one
// the last number in its name. Where that does not tell them apart, or there is none, they are
// counted from 0.
std::vector<std::string> label_steps(const std::vector<std::string>& paths);

// Of step i of so many, counted from 0: all with the same number of digits, so that files sort.
std::string count_label(std::size_t i, std::size_t all);

bool is_number_label(const std::string& label);
// Of such a label, to be compared: whole numbers to the last digit, up to 2^64.
std::pair<double, std::uint64_t> number_in(const std::string& label);

}  // namespace tetfusion
