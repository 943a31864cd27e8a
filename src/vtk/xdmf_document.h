// The XML of an XDMF file, in which elements stand for others, of this file or of another one: by
// xi:include, by a Reference, by entities.
#pragma once

#include <initializer_list>
#include <map>
#include <memory>
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

  // The file that the element is in: that one, or one that is included.
  const std::string& path_of(pugi::xml_node node) const { return file_of(node).path; }

  // Those that are included as far as was asked for.
  std::vector<std::string> included_files() const;

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

  // Throws Error(kBadInput): "run.xdmf: byte 123: DataItem 'x' what", and which file where it is an
  // included one.
  [[noreturn]] void fail(pugi::xml_node node, const std::string& what) const;

 private:
  struct File {
    std::string path;
    pugi::xml_document xml;
    std::map<std::string, std::string> entities;
  };

  File* open(const std::string& path) const;
  const File& file_of(pugi::xml_node node) const;
  void add(pugi::xml_node node, std::string_view name, int depth,
           std::vector<pugi::xml_node>* out) const;
  pugi::xml_node referred(pugi::xml_node node) const;
  std::vector<pugi::xml_node> included(pugi::xml_node node) const;
  std::vector<pugi::xml_node> select(pugi::xml_node from, const std::string& where,
                                     pugi::xml_node by) const;

  std::string path_;
  // By their paths; and by the roots of their trees. They are opened when they are asked for.
  mutable std::map<std::string, std::unique_ptr<File>> files_;
  mutable std::map<pugi::xml_node, const File*> file_of_root_;
  pugi::xml_node domain_;
  std::vector<std::string> other_domains_;
};

}  // namespace tetfusion
