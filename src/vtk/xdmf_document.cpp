#include "vtk/xdmf_document.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstddef>
#include <filesystem>
#include <system_error>
#include <utility>

#include "base/error.h"
#include "base/numbers.h"
#include "io/files/mapped_file.h"
#include "io/vtk/listed_files.h"

namespace tetfusion {
namespace {

constexpr std::string_view kXmlBlanks = " \t\r\n";
constexpr int kLongestChain = 16;  // of elements that stand for another one

std::string in_quotes(const std::string& text) { return "'" + text + "'"; }

// Without the prefix of a namespace.
std::string_view local_name(pugi::xml_node node) {
  const std::string_view name = node.name();
  return name.substr(name.find(':') + 1);
}

bool is_called(pugi::xml_node node, std::string_view name) {
  return node.type() == pugi::node_element && is_xdmf_word(local_name(node), name);
}

// "/1/2" counts the elements on the way from the document; nothing where there are not so many.
pugi::xml_node node_by_numbers(pugi::xml_node from, std::string_view numbers) {
  while (from && !numbers.empty()) {
    if (numbers.front() != '/') return {};
    numbers.remove_prefix(1);
    std::size_t number = 0;
    const auto [end, error] =
        std::from_chars(numbers.data(), numbers.data() + numbers.size(), number);
    if (error != std::errc{}) return {};
    numbers.remove_prefix(static_cast<std::size_t>(end - numbers.data()));
    pugi::xml_node at;
    for (const pugi::xml_node child : from.children()) {
      if (child.type() == pugi::node_element && number-- == 1) {
        at = child;
        break;
      }
    }
    from = at;
  }
  return from;
}

// What stands between "SCHEME(" and the last bracket; empty where it is of another scheme.
std::string inside(const std::string& pointer, const std::string& scheme) {
  const std::size_t end = pointer.rfind(')');
  if (!pointer.starts_with(scheme + "(") || end == std::string::npos) return "";
  return pointer.substr(scheme.size() + 1, end - scheme.size() - 1);
}

// <!ENTITY name "text">, and no more: what an entity stands for is not looked at again.
std::map<std::string, std::string> entities_in(std::string_view doctype) {
  constexpr std::string_view kBegin = "<!ENTITY";
  std::map<std::string, std::string> entities;
  for (std::size_t at = doctype.find(kBegin); at != std::string_view::npos;
       at = doctype.find(kBegin)) {
    doctype.remove_prefix(at + kBegin.size());
    const std::size_t quote = doctype.find_first_of("\"'");
    if (quote == std::string_view::npos) break;
    const std::string_view name = trimmed(doctype.substr(0, quote));
    const std::size_t end = doctype.find(doctype[quote], quote + 1);
    if (end == std::string_view::npos) break;
    if (name.find_first_of(kXmlBlanks) == std::string_view::npos) {  // else it is a file's
      entities.emplace(name, trimmed(doctype.substr(quote + 1, end - quote - 1)));
    }
    doctype.remove_prefix(end);
  }
  return entities;
}

}  // namespace

bool is_xdmf_word(std::string_view word, std::string_view wanted) {
  return std::equal(word.begin(), word.end(), wanted.begin(), wanted.end(), [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) ==
           std::tolower(static_cast<unsigned char>(b));
  });
}

std::string xdmf_attribute(pugi::xml_node node, std::initializer_list<std::string_view> names,
                           std::string_view otherwise) {
  for (const std::string_view name : names) {
    for (const pugi::xml_attribute attribute : node.attributes()) {
      const std::string_view value = trimmed(attribute.value());
      if (is_xdmf_word(attribute.name(), name) && !value.empty()) return std::string(value);
    }
  }
  return std::string(otherwise);
}

XdmfDocument::XdmfDocument(const std::string& path) : path_(path) {
  const pugi::xml_node root = own_child(open(path)->xml, "Xdmf");
  if (!root) throw Error(ErrorCode::kBadInput, path + ": has no element <Xdmf>");
  for (const pugi::xml_node node : children(root, "Domain")) {
    if (!domain_) {
      domain_ = node;
    } else {
      other_domains_.push_back(xdmf_attribute(node, {"Name"}));
    }
  }
  if (!domain_) fail(root, "has no Domain");
}

XdmfDocument::File* XdmfDocument::open(const std::string& path) const {
  std::unique_ptr<File>& file = files_[path];
  if (file != nullptr) return file.get();
  auto opened = std::make_unique<File>();
  opened->path = path;
  const MappedFile mapped = MappedFile::open(path);
  const auto result = opened->xml.load_buffer(mapped.bytes().data(), mapped.size(),
                                              pugi::parse_default | pugi::parse_doctype);
  mapped.check();
  if (!result) {
    throw Error(ErrorCode::kBadInput,
                path_ + ": " + (path == path_ ? "" : "in " + path + ": ") + "byte " +
                    std::to_string(result.offset) +
                    ": the XML is damaged or cut off: " + result.description());
  }
  for (const pugi::xml_node node : opened->xml.children()) {
    if (node.type() == pugi::node_doctype) opened->entities = entities_in(node.value());
  }
  file = std::move(opened);
  file_of_root_[file->xml.root()] = file.get();
  return file.get();
}

const XdmfDocument::File& XdmfDocument::file_of(pugi::xml_node node) const {
  const auto known = file_of_root_.find(node.root());
  return known != file_of_root_.end() ? *known->second : *files_.at(path_);
}

std::vector<std::string> XdmfDocument::included_files() const {
  std::vector<std::string> paths;
  for (const auto& [path, file] : files_) {
    if (path != path_ && file != nullptr) paths.push_back(path);
  }
  return paths;
}

std::vector<pugi::xml_node> XdmfDocument::children(pugi::xml_node node,
                                                   std::string_view name) const {
  std::vector<pugi::xml_node> found;
  for (const pugi::xml_node child : node.children()) add(child, name, 0, &found);
  return found;
}

pugi::xml_node XdmfDocument::child(pugi::xml_node node, std::string_view name) const {
  if (const pugi::xml_node own = own_child(node, name)) {
    std::vector<pugi::xml_node> found;
    add(own, name, 0, &found);
    return found.front();
  }
  const std::vector<pugi::xml_node> found = children(node, name);
  return found.empty() ? pugi::xml_node() : found.front();
}

pugi::xml_node XdmfDocument::own_child(pugi::xml_node node, std::string_view name) {
  return node.find_child([&](pugi::xml_node child) { return is_called(child, name); });
}

void XdmfDocument::add(pugi::xml_node node, std::string_view name, int depth,
                       std::vector<pugi::xml_node>* out) const {
  if (depth > kLongestChain) fail(node, "stands for itself");
  if (is_called(node, "include")) {
    for (const pugi::xml_node other : included(node)) add(other, name, depth + 1, out);
  } else if (is_called(node, name)) {
    if (xdmf_attribute(node, {"Reference"}).empty()) {
      out->push_back(node);
    } else {
      add(referred(node), name, depth + 1, out);
    }
  }
}

// The path to the other one is the attribute's value, or the text where that is "XML".
pugi::xml_node XdmfDocument::referred(pugi::xml_node node) const {
  std::string where = xdmf_attribute(node, {"Reference"});
  if (is_xdmf_word(where, "XML")) where = text(node);
  const std::vector<pugi::xml_node> found = select(node, where, node);
  const auto same = std::find_if(found.begin(), found.end(), [&](pugi::xml_node other) {
    return is_called(other, local_name(node));
  });
  if (same == found.end()) {
    fail(node, "refers to " + in_quotes(where) + ", where there is no such element");
  }
  return *same;
}

std::vector<pugi::xml_node> XdmfDocument::included(pugi::xml_node node) const {
  const std::string name = xdmf_attribute(node, {"href"});
  pugi::xml_node root = node.root();
  if (!name.empty()) {
    const std::string path = listed_path(path_of(node), "the file that is included", name);
    std::error_code unknown;
    if (!std::filesystem::is_regular_file(path, unknown)) {
      fail(node, "includes " + path + ", which is not there");
    }
    root = open(path)->xml;
  }
  const std::string pointer = xdmf_attribute(node, {"xpointer"});
  std::vector<pugi::xml_node> found;
  if (const std::string numbers = inside(pointer, "element"); !numbers.empty()) {
    if (const pugi::xml_node other = node_by_numbers(root, numbers)) found = {other};
  } else if (const std::string where = inside(pointer, "xpointer"); !where.empty()) {
    found = select(name.empty() ? node : root, where, node);
  }
  if (found.empty()) {
    fail(node, "includes " + in_quotes(pointer) + ", where there is nothing");
  }
  return found;
}

std::vector<pugi::xml_node> XdmfDocument::select(pugi::xml_node from, const std::string& where,
                                                 pugi::xml_node by) const {
  std::vector<pugi::xml_node> found;
  try {
    for (const pugi::xpath_node at : from.select_nodes(where.c_str())) {
      if (at.node().type() == pugi::node_element) found.push_back(at.node());
    }
  } catch (const pugi::xpath_exception& error) {
    fail(by, "refers to " + in_quotes(where) + ", which is no XPath: " + error.what());
  }
  return found;
}

std::vector<std::string_view> XdmfDocument::text_parts(pugi::xml_node node) {
  std::vector<std::string_view> parts;
  for (const pugi::xml_node child : node.children()) {
    const bool is_text = child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata;
    if (is_text) parts.emplace_back(child.value());
  }
  return parts;
}

std::string XdmfDocument::text(pugi::xml_node node) const {
  const std::map<std::string, std::string>& entities = file_of(node).entities;
  std::string all;
  for (std::string_view part : text_parts(node)) {
    for (std::size_t at = part.find('&'); at != std::string_view::npos; at = part.find('&')) {
      all += part.substr(0, at);
      part.remove_prefix(at);
      const std::size_t end = part.find(';');
      const auto entity = end == std::string_view::npos
                              ? entities.end()
                              : entities.find(std::string(part.substr(1, end - 1)));
      all += entity == entities.end() ? "&" : entity->second;
      part.remove_prefix(entity == entities.end() ? 1 : end + 1);
    }
    all += part;
  }
  return std::string(trimmed(all));
}

void XdmfDocument::fail(pugi::xml_node node, const std::string& what) const {
  const std::string name = xdmf_attribute(node, {"Name"});
  throw Error(ErrorCode::kBadInput,
              path_ + ": " + (path_of(node) == path_ ? "" : "in " + path_of(node) + ": ") +
                  "byte " + std::to_string(node.offset_debug()) + ": " +
                  std::string(local_name(node)) + (name.empty() ? "" : " " + in_quotes(name)) +
                  " " + what);
}

}  // namespace tetfusion
