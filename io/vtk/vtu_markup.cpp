#include "io/vtk/vtu_markup.h"

#include <fmt/format.h>

#include <bit>

#include "io/formats/xml_text.h"

namespace tetfusion {

std::string vtk_file_tag(std::string_view type, std::string_view more) {
  return fmt::format(
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"{}\" version=\"1.0\" byte_order=\"{}\" "
      "header_type=\"UInt64\"{}>\n",
      type, std::endian::native == std::endian::little ? "LittleEndian" : "BigEndian", more);
}

std::string array_attributes(const ArrayInfo& info) {
  std::string text =
      fmt::format("type=\"{}\" Name=\"{}\"", vtk_name(info.type), xml_escape(info.name));
  if (info.components != 1) text += fmt::format(" NumberOfComponents=\"{}\"", info.components);
  for (std::size_t i = 0; i < info.component_names.size(); ++i) {
    if (info.component_names[i].empty()) continue;
    text += fmt::format(" ComponentName{}=\"{}\"", i, xml_escape(info.component_names[i]));
  }
  return text;
}

std::string units_element(const ArrayInfo& info) {
  if (info.units.empty()) return {};
  return fmt::format("<InformationKey name=\"{}\" location=\"{}\">{}</InformationKey>", kUnitsKey,
                     kUnitsKeyClass, xml_escape(info.units));
}

std::string active_attributes(const AttributeSet& set) {
  std::string text;
  for (const auto& [kind, name] : set.active) {
    if (set.find(name) == AttributeSet::npos) continue;
    text += fmt::format(" {}=\"{}\"", kind, xml_escape(name));
  }
  return text;
}

}  // namespace tetfusion
