#include "io/vtk/xml_scan.h"

#include <algorithm>

#include "base/error.h"
#include "mesh/data_array.h"

namespace tetfusion {

namespace {

constexpr std::string_view kBlanks = " \t\r\n";
constexpr std::size_t kNotFound = std::string_view::npos;

class Scanner {
 public:
  explicit Scanner(const MappedFile& file)
      : mapped_(file),
        file_(reinterpret_cast<const char*>(file.bytes().data()), file.size()),
        path_(file.path()) {}

  XmlHead run() {
    while (pos_ < file_.size() && !head_.has_appended) {
      const std::size_t tag = next_tag();
      take_text(pos_, tag);
      pos_ = tag;
      if (pos_ < file_.size()) take_markup();
    }
    release(pos_);
    return std::move(head_);
  }

 private:
  // Data between tags may be many gigabytes.
  std::size_t next_tag() {
    constexpr std::size_t kStep = std::size_t{4} << 20;
    for (std::size_t at = pos_; at < file_.size(); at += kStep) {
      if (at > released_ + kStep) release(at);
      const std::size_t found = file_.substr(at, kStep).find('<');
      if (found != kNotFound) return at + found;
    }
    return file_.size();
  }

  void release(std::size_t end) {
    mapped_.dont_need_around(released_, end - released_);
    released_ = end;
  }

  [[noreturn]] void fail(const std::string& what, std::size_t position) const {
    throw Error(ErrorCode::kBadInput,
                path_ + ": " + what + " (byte " + std::to_string(position) + ")");
  }

  bool at(std::string_view word) const { return file_.substr(pos_, word.size()) == word; }

  void skip_past(std::string_view end, const char* what) {
    const std::size_t found = file_.find(end, pos_);
    if (found == kNotFound) fail(std::string("the file ends inside ") + what, pos_);
    pos_ = found + end.size();
  }

  // Text matters directly inside a data element alone, and inside a label of units in it: other
  // InformationKeys have text that nobody needs.
  void take_text(std::size_t begin, std::size_t end) {
    if (!in_data_) return;
    if (nested_ > 0) return take_label(begin, end);
    const std::size_t first = file_.substr(begin, end - begin).find_first_not_of(kBlanks);
    if (first == kNotFound) return;
    if (has_payload_) fail("an array's data is in two parts", begin + first);
    has_payload_ = true;
    const std::size_t last = file_.substr(begin, end - begin).find_last_not_of(kBlanks);
    head_.text += std::to_string(begin + first) + " " + std::to_string(begin + last + 1);
  }

  void take_label(std::size_t begin, std::size_t end) {
    constexpr std::size_t kLongest = 4096;  // it stays in memory: what is longer is no label
    if (in_label_ && nested_ == 1 && end - begin <= kLongest) {
      head_.text += file_.substr(begin, end - begin);
    }
  }

  void take_markup() {
    if (at("<!--")) return skip_past("-->", "a comment");
    if (at("<![CDATA[")) fail("CDATA sections are not supported", pos_);
    if (at("<?")) return skip_past("?>", "a processing instruction");
    if (at("<!")) return skip_past(">", "a declaration");
    take_tag();
  }

  // The position after the tag that starts at pos_. A '>' inside quotes does not end it.
  std::size_t tag_end() const {
    char quote = 0;
    for (std::size_t i = pos_ + 1; i < file_.size(); ++i) {
      const char c = file_[i];
      if (quote != 0) {
        if (c == quote) quote = 0;
      } else if (c == '"' || c == '\'') {
        quote = c;
      } else if (c == '>') {
        return i + 1;
      }
    }
    fail("the file ends inside a tag", pos_);
  }

  void take_tag() {
    const std::size_t end = tag_end();
    const std::string_view tag = file_.substr(pos_, end - pos_);
    const bool closing = tag.size() > 2 && tag[1] == '/';
    const bool empty = tag.size() > 2 && tag[tag.size() - 2] == '/';
    const std::size_t name_begin = closing ? 2 : 1;
    const std::size_t name_end = tag.find_first_of(" \t\r\n/>", name_begin);
    const std::string_view name = tag.substr(name_begin, name_end - name_begin);
    head_.text += tag;
    pos_ = end;
    if (name == "AppendedData" && !closing && !empty) return take_appended();
    if (in_data_) {
      if (closing && nested_ == 0) {
        in_data_ = false;
      } else if (closing) {
        --nested_;
      } else if (!empty) {
        ++nested_;
        if (nested_ == 1) in_label_ = name == "InformationKey" && tag.find(kUnitsKey) != kNotFound;
      }
    } else if (!closing && !empty && (name == "DataArray" || name == "Array")) {
      in_data_ = true;
      has_payload_ = false;
    }
  }

  void take_appended() {
    const std::size_t mark = file_.find_first_not_of(kBlanks, pos_);
    if (mark == kNotFound || file_[mark] != '_') {
      fail("the appended data does not begin with an underscore", std::min(mark, file_.size()));
    }
    constexpr std::string_view kEndTag = "</AppendedData";
    // Raw data may hold anything, an end tag too: the last one is the real one, and near the file's
    // end.
    constexpr std::size_t kEndPart = 4096;
    const std::size_t tail = std::max(mark + 1, file_.size() - std::min(kEndPart, file_.size()));
    const std::size_t found = file_.substr(tail).rfind(kEndTag);
    head_.has_appended = true;
    head_.appended_begin = mark + 1;
    head_.appended_end = found == kNotFound ? file_.size() : tail + found;
    head_.text += "</AppendedData></VTKFile>";
  }

  const MappedFile& mapped_;
  std::string_view file_;
  const std::string& path_;
  std::size_t pos_ = 0;
  std::size_t released_ = 0;  // what comes before is not mapped any more
  bool in_data_ = false;
  bool has_payload_ = false;
  std::size_t nested_ = 0;  // elements open inside the data element
  bool in_label_ = false;   // the outermost of them says units
  XmlHead head_;
};

}  // namespace

XmlHead scan_xml_head(const MappedFile& file) { return Scanner(file).run(); }

std::string_view vtk_file_type(std::string_view file) {
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  constexpr std::string_view kRoot = "<VTKFile";
  constexpr std::size_t kReach = 4096;
  file = file.substr(0, kReach);
  if (file.starts_with(kByteOrderMark)) file.remove_prefix(kByteOrderMark.size());
  const std::size_t first = file.find_first_not_of(kBlanks);
  if (first == kNotFound || file[first] != '<') return {};
  const std::size_t root = file.find(kRoot, first);
  if (root == kNotFound) return {};
  const std::string_view tag = file.substr(root, file.find('>', root) - root);
  std::size_t name = tag.find("type");  // but not that of header_type
  while (name != kNotFound && kBlanks.find(tag[name - 1]) == kNotFound)
    name = tag.find("type", name + 1);
  if (name == kNotFound) return {};
  const std::size_t open = tag.find_first_of("\"'", name);
  if (open == kNotFound) return {};
  const std::size_t close = tag.find(tag[open], open + 1);
  return close == kNotFound ? std::string_view{} : tag.substr(open + 1, close - open - 1);
}

}  // namespace tetfusion
