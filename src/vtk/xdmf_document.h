// The XML of an XDMF file, in which elements stand for others: by xi:include, by a Reference, by
// entities.
#pragma once

#include <initializer_list>
#include <map>
#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace tetfusion {

// Words of XDMF are the same in letters of either size.
bool is_xdmf_word(std::string_view word, std::string_view wanted);

// The value of the first of these attributes that the element has and that is not empty, without
// blanks round it. XDMF 2 and 3 call some differently.
std::string xdmf_attribute(pugi::xml_node node, std::initializer_list<std::string_view> names,
                           std::string_view otherwise = {});

class XdmfDocument {
 public:
  // Throws Error(kBadInput) where it is damaged or something else, Error(kIo).
  explicit XdmfDocument(const std::string& path);

  const std::string& path() const { return path_; }

  // The first one; the names of the others.
  pugi::xml_node domain() const { return domain_; }
  const std::vector<std::string>& other_domains() const { return other_domains_; }

  // The elements that are called so, those that others stand for in their place. Throws
  // Error(kBadInput) where one leads nowhere, or in a circle.
  std::vector<pugi::xml_node> children(pugi::xml_node node, std::string_view name) const;

  // The first of them; nothing where there is none.
  pugi::xml_node child(pugi::xml_node node, std::string_view name) const;

  // Of those that are written there, and not elsewhere.
  static pugi::xml_node own_child(pugi::xml_node node, std::string_view name);

  // The text in parts, as comments cut it. They live as long as this.
  static std::vector<std::string_view> text_parts(pugi::xml_node node);

  // The same in one, with its entities resolved, without blanks round it.
  std::string text(pugi::xml_node node) const;

  // Throws Error(kBadInput): "run.xdmf: byte 123: DataItem 'x' what".
  [[noreturn]] void fail(pugi::xml_node node, const std::string& what) const;

 private:
  void add(pugi::xml_node node, std::string_view name, int depth,
           std::vector<pugi::xml_node>* out) const;
  pugi::xml_node referred(pugi::xml_node node) const;
  std::vector<pugi::xml_node> included(pugi::xml_node node) const;
  std::vector<pugi::xml_node> select(pugi::xml_node node, const std::string& where) const;
  void take_entities(std::string_view doctype);

  std::string path_;
  pugi::xml_document document_;
  pugi::xml_node domain_;
  std::vector<std::string> other_domains_;
  std::map<std::string, std::string> entities_;
};

}  // namespace tetfusion
