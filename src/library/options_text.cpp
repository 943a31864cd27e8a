#include "library/options_text.h"

#include <fmt/format.h>

#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/error.h"

namespace tetfusion {

namespace {

using Json = nlohmann::json;

// What a value is not: the name of the option is put before it.
struct NotOfKind {
  const char* kind;
};

// For a message; a deep value is not gone through.
std::string text_like(const Json& value) {
  if (value.is_structured()) return value.is_array() ? "such a list" : "such an object";
  return value.dump();
}

double number_of(const Json& value) {
  if (value == "inf") return std::numeric_limits<double>::infinity();
  if (!value.is_number()) throw NotOfKind{"a number"};
  return value.get<double>();
}

std::uint64_t count_of(const Json& value) {
  if (!value.is_number_unsigned()) throw NotOfKind{"a whole number, at least 0"};
  return value.get<std::uint64_t>();
}

bool flag_of(const Json& value) {
  if (!value.is_boolean()) throw NotOfKind{"true or false"};
  return value.get<bool>();
}

std::string text_of(const Json& value) {
  if (!value.is_string()) throw NotOfKind{"a text"};
  return value.get<std::string>();
}

template <class F>
auto list_of(const Json& value, F f) {
  std::vector<decltype(f(value))> list;
  if (!value.is_array()) {
    list.push_back(f(value));
  } else {
    for (const Json& item : value) list.push_back(f(item));
  }
  return list;
}

template <class Enum>
auto one_of(const std::map<std::string, Enum>& choices, const char* kind) {
  return [=](const Json& value) {
    const auto it = value.is_string() ? choices.find(value.get<std::string>()) : choices.end();
    if (it == choices.end()) throw NotOfKind{kind};
    return it->second;
  };
}

SteeringArray array_of(const Json& value) {
  constexpr NotOfKind kNone{"a name, or an object with name, of_cells and tolerance"};
  SteeringArray array;
  if (value.is_string()) {
    array.name = text_of(value);
    return array;
  }
  if (!value.is_object() || !value.contains("name")) throw kNone;
  for (const auto& [key, part] : value.items()) {
    if (key == "name") {
      array.name = text_of(part);
    } else if (key == "of_cells") {
      array.of_cells = flag_of(part);
    } else if (key != "tolerance") {
      throw kNone;
    } else if (!part.is_null()) {
      array.tolerance = number_of(part);
    }
  }
  return array;
}

using Take = std::function<void(const Json&, Options*)>;

template <class T, class F>
Take into(T Options::*member, F f) {
  return [=](const Json& value, Options* options) { options->*member = f(value); };
}

template <class F>
auto each(F f) {
  return [=](const Json& value) { return list_of(value, f); };
}

const std::map<std::string, Take, std::less<>>& takers() {
  using O = Options;
  static const std::map<std::string, Take, std::less<>> kTakers{
      {"reduction", into(&O::reduction, number_of)},
      {"tets", into(&O::tets, count_of)},
      {"max_error", into(&O::max_error, number_of)},
      {"max_rms", into(&O::max_rms, number_of)},
      {"strict", into(&O::strict, flag_of)},
      {"method", into(&O::method, one_of<Operation>({{"fuse", Operation::kFuse},
                                                     {"tetfuse", Operation::kTetFuse}},
                                                    "\"fuse\" or \"tetfuse\""))},
      {"boundary", into(&O::boundary, one_of<BoundaryMode>({{"exact", BoundaryMode::kExact},
                                                            {"planar", BoundaryMode::kPlanar},
                                                            {"within", BoundaryMode::kWithin}},
                                                           "\"exact\", \"planar\" or \"within\""))},
      {"boundary_distance", into(&O::boundary_distance, number_of)},
      {"feature_angle", into(&O::feature_angle, number_of)},
      {"min_quality", into(&O::min_quality, number_of)},
      {"conserve", into(&O::conserve, flag_of)},
      {"scalar_tolerance", into(&O::scalar_tolerance, each(number_of))},
      {"stretch_factor", into(&O::stretch_factor, each(number_of))},
      {"aspect_ratio", into(&O::aspect_ratio, number_of)},
      {"max_volume", into(&O::max_volume, number_of)},
      {"boundary_tets_stay", into(&O::boundary_tets_stay, flag_of)},
      {"arrays", into(&O::arrays, each(array_of))},
      {"regions", into(&O::regions, each(text_of))},
      {"roi", into(&O::roi, each(text_of))},
      {"weight", into(&O::weight, text_of)},
      {"original_ids", into(&O::original_ids, flag_of)},
      {"tetrahedralize", into(&O::tetrahedralize, flag_of)},
      {"linearize", into(&O::linearize, flag_of)},
      {"drop_patches", into(&O::drop_patches, flag_of)},
      {"drop_patch", into(&O::drop_patch, each(text_of))},
      {"chunk_tets", into(&O::chunk_tets, count_of)},
      {"threads", into(&O::threads,
                       [](const Json& value) {
                         const std::uint64_t count = count_of(value);
                         if (count > std::numeric_limits<int>::max()) {
                           throw NotOfKind{"a number of threads"};
                         }
                         return static_cast<int>(count);
                       })},
      {"memory", into(&O::memory, count_of)},
      {"scratch", into(&O::scratch, text_of)}};
  return kTakers;
}

}  // namespace

bool is_option(std::string_view name) { return takers().find(name) != takers().end(); }

Options read_options(std::string_view text) {
  Options options;
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object()) refuse("the options are no JSON object");
  for (const auto& [name, value] : json.items()) {
    const auto taker = takers().find(name);
    if (taker == takers().end()) refuse(fmt::format("there is no option \"{}\"", name));
    if (value.is_null()) continue;
    try {
      taker->second(value, &options);
    } catch (const NotOfKind& wrong) {
      refuse(fmt::format("{} must be {}, not {}", name, wrong.kind, text_like(value)));
    }
  }
  return options;
}

}  // namespace tetfusion
