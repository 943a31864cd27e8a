#include "fuzz/mutate_xml.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <random>
#include <string>
#include <string_view>
#include <vector>

namespace tetfusion::fuzz {

namespace {

using Random = std::minstd_rand;

struct Span {
  std::size_t begin = 0;
  std::size_t end = 0;
};

// What the readers know, and numbers at the edges of their types.
constexpr std::array kValues = {"Int8",
                                "UInt8",
                                "Int16",
                                "UInt16",
                                "Int32",
                                "UInt32",
                                "Int64",
                                "UInt64",
                                "Float32",
                                "Float64",
                                "String",
                                "ascii",
                                "binary",
                                "appended",
                                "raw",
                                "base64",
                                "LittleEndian",
                                "BigEndian",
                                "vtkZLibDataCompressor",
                                "vtkLZ4DataCompressor",
                                "vtkLZMADataCompressor",
                                "connectivity",
                                "offsets",
                                "types",
                                "vtkGhostType",
                                "vtkOriginalPointIds",
                                "GlobalNodeIds",
                                "UnstructuredGrid",
                                "PUnstructuredGrid",
                                "0.1",
                                "1.0",
                                "2.2",
                                "0",
                                "1",
                                "2",
                                "3",
                                "4",
                                "5",
                                "8",
                                "10",
                                "24",
                                "255",
                                "65535",
                                "2147483647",
                                "4294967295",
                                "4294967296",
                                "9223372036854775807",
                                "18446744073709551615",
                                "-1",
                                "",
                                "0.vtu",
                                "1.vtu",
                                "m.pvtu"};

std::size_t below(Random* random, std::size_t n) { return n == 0 ? 0 : (*random)() % n; }

std::vector<Span> attribute_values(std::string_view text) {
  std::vector<Span> found;
  for (std::size_t at = text.find("=\""); at != text.npos; at = text.find("=\"", at)) {
    const std::size_t begin = at + 2;
    const std::size_t end = text.find('"', begin);
    if (end == text.npos) break;
    found.push_back({begin, end});
    at = end;
  }
  return found;
}

// Between the end of a tag and the next one: `appended` data too, which begin with '_'.
std::vector<Span> contents(std::string_view text) {
  std::vector<Span> found;
  for (std::size_t at = text.find('>'); at != text.npos; at = text.find('>', at + 1)) {
    const std::size_t end = std::min(text.find('<', at + 1), text.size());
    if (end > at + 8) found.push_back({at + 1, end});
  }
  const std::size_t data = text.find('_', std::min(text.find("<AppendedData"), text.size()));
  const std::size_t last = text.rfind("</AppendedData");
  if (data != text.npos && last != text.npos && data < last) found.push_back({data + 1, last});
  return found;
}

// <Tag ...> with all that it holds, where it is closed.
std::vector<Span> elements(std::string_view text) {
  std::vector<Span> found;
  for (std::size_t at = text.find('<'); at != text.npos; at = text.find('<', at + 1)) {
    if (at + 1 >= text.size() || std::isalpha(static_cast<unsigned char>(text[at + 1])) == 0)
      continue;
    const std::size_t name_end = text.find_first_of(" >\n/", at);
    const std::size_t tag_end = text.find('>', at);
    if (name_end == text.npos || tag_end == text.npos) break;
    if (text[tag_end - 1] == '/') {
      found.push_back({at, tag_end + 1});
      continue;
    }
    const std::string close = "</" + std::string(text.substr(at + 1, name_end - at - 1)) + ">";
    const std::size_t end = text.find(close, tag_end);
    if (end != text.npos) found.push_back({at, end + close.size()});
  }
  return found;
}

constexpr std::string_view kAlphabet =
    "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

std::string encode(std::string_view bytes) {
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned group = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      group = group << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : kAlphabet[group >> (18 - 6 * k) & 63];
  }
  return out;
}

// Nothing where it is not base64.
std::string decode(std::string_view text) {
  std::string out;
  unsigned group = 0;
  unsigned count = 0;
  for (const char c : text) {
    if (c == '=' || c == '\n' || c == ' ') continue;
    const std::size_t value = kAlphabet.find(c);
    if (value == kAlphabet.npos) return {};
    group = group << 6 | static_cast<unsigned>(value);
    if (++count % 4 == 0) {
      for (int shift = 16; shift >= 0; shift -= 8) out += static_cast<char>(group >> shift & 255);
      group = 0;
    }
  }
  return out;
}

class Mutation {
 public:
  Mutation(std::string text, std::size_t max_size, unsigned seed, MutateBytes any)
      : text_(std::move(text)), max_size_(max_size), random_(seed), any_(any) {}

  std::string run() {
    switch (below(&random_, 8)) {
      case 0:
      case 1:
        change_value();
        break;
      case 2:
      case 3:
        change_content();
        break;
      case 4:
        change_base64();
        break;
      case 5:
        move_element();
        break;
      default:
        text_ = changed(text_, max_size_);
    }
    if (text_.size() > max_size_) text_.resize(max_size_);
    return text_;
  }

 private:
  std::string changed(std::string bytes, std::size_t most) {
    const std::size_t size = bytes.size();
    bytes.resize(std::max(most, size));
    bytes.resize(any_(reinterpret_cast<std::uint8_t*>(bytes.data()), size, bytes.size()));
    return bytes;
  }
  Span one_of(const std::vector<Span>& spans) {
    return spans.empty() ? Span{} : spans[below(&random_, spans.size())];
  }
  std::string_view view(Span s) const {
    return std::string_view(text_).substr(s.begin, s.end - s.begin);
  }
  void replace(Span s, const std::string& with) { text_.replace(s.begin, s.end - s.begin, with); }
  std::size_t room(Span s) const {
    return max_size_ - std::min(max_size_, text_.size() - (s.end - s.begin));
  }

  void change_value() {
    const std::vector<Span> values = attribute_values(text_);
    const Span to = one_of(values);
    switch (below(&random_, 3)) {
      case 0:
        replace(to, kValues[below(&random_, kValues.size())]);
        break;
      case 1:
        replace(to, std::string(view(one_of(values))));
        break;
      default:
        replace(to, changed(std::string(view(to)), std::min<std::size_t>(room(to), 40)));
    }
  }

  void change_content() {
    const Span at = one_of(contents(text_));
    replace(at, changed(std::string(view(at)), room(at)));
  }

  void change_base64() {
    std::vector<Span> coded;
    for (const Span s : contents(text_)) {
      if (!decode(view(s)).empty()) coded.push_back(s);
    }
    const Span at = one_of(coded);
    if (at.end == 0) return change_value();
    replace(at, encode(changed(decode(view(at)), room(at) / 4 * 3)));
  }

  // Removed, doubled, or put in another one's place.
  void move_element() {
    const std::vector<Span> all = elements(text_);
    const Span from = one_of(all);
    const Span to = one_of(all);
    const std::string copy(view(from));
    switch (below(&random_, 3)) {
      case 0:
        replace(from, {});
        break;
      case 1:
        text_.insert(from.end, copy);
        break;
      default:
        replace(to, copy);
    }
  }

  std::string text_;
  std::size_t max_size_;
  Random random_;
  MutateBytes any_;
};

}  // namespace

std::size_t mutate_xml(std::uint8_t* data, std::size_t size, std::size_t max_size, unsigned seed,
                       MutateBytes any) {
  const std::string text =
      Mutation({reinterpret_cast<const char*>(data), size}, max_size, seed, any).run();
  std::memcpy(data, text.data(), text.size());
  return text.size();
}

}  // namespace tetfusion::fuzz
