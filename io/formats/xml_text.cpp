#include "io/formats/xml_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace tetfusion {

namespace {

// Bytes of the well-formed UTF-8 character at the start of the text; 0 if there is none.
std::size_t utf8_length(std::string_view text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  const std::uint8_t lead = byte(0);
  const std::size_t length = lead < 0x80   ? 1
                             : lead < 0xC2 ? 0
                             : lead < 0xE0 ? 2
                             : lead < 0xF0 ? 3
                             : lead < 0xF5 ? 4
                                           : 0;
  if (length == 0 || length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xC0) != 0x80) return 0;
  }
  // Overlong forms, surrogates, beyond U+10FFFF, and the two non-characters that XML forbids.
  if (length == 3 && lead == 0xE0 && byte(1) < 0xA0) return 0;
  if (length == 3 && lead == 0xED && byte(1) > 0x9F) return 0;
  if (length == 3 && lead == 0xEF && byte(1) == 0xBF && byte(2) >= 0xBE) return 0;
  if (length == 4 && lead == 0xF0 && byte(1) < 0x90) return 0;
  if (length == 4 && lead == 0xF4 && byte(1) > 0x8F) return 0;
  return length;
}

// Such a character: of C0 or C1, or the one that deletes?
bool is_control(std::string_view text, std::size_t length) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  return (length == 1 && (byte(0) < 0x20 || byte(0) == 0x7F)) ||
         (length == 2 && byte(0) == 0xC2 && byte(1) < 0xA0);
}

}  // namespace

std::string xml_escape(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    const char c = text.front();
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (c == '>') {
      out += "&gt;";
    } else if (c == '"') {
      out += "&quot;";
    } else if (c == '\t' || c == '\n' || c == '\r') {
      out += fmt::format("&#{};", static_cast<int>(c));
    } else if (length == 0 || (length == 1 && static_cast<std::uint8_t>(c) < 0x20)) {
      out += '?';
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

bool is_xml_text(std::string_view text) {
  return std::ranges::count(xml_escape(text), '?') == std::ranges::count(text, '?');
}

std::string legible(std::string_view name) {
  std::string out;
  while (!name.empty()) {
    const std::size_t length = utf8_length(name);
    const auto byte = static_cast<std::uint8_t>(name[0]);
    const bool is_blank = byte == '\t' || byte == '\n' || byte == '\r';
    if (!is_blank && (is_control(name, length) || (length == 0 && byte < 0xA0))) {
      const auto number = length == 2 ? static_cast<std::uint8_t>(name[1]) : byte;
      out += fmt::format("%{:02X}", number);
    } else if (length == 0) {
      out += static_cast<char>(0xC0 | byte >> 6);
      out += static_cast<char>(0x80 | (byte & 0x3F));
    } else {
      out += name.substr(0, length);
    }
    name.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

void make_legible(AttributeSet* set) {
  for (ArrayInfo& info : set->arrays) {
    info.name = legible(info.name);
    info.units = legible(info.units);
    for (std::string& name : info.component_names) name = legible(name);
  }
  for (auto& [mark, name] : set->active) name = legible(name);
}

std::string for_message(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = utf8_length(text);
    if (length == 0 || is_control(text, length)) {
      out += '?';
    } else {
      out += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return out;
}

}  // namespace tetfusion
