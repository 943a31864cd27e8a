#include "io/gmsh/gmsh_head.h"

#include <algorithm>
#include <cstring>
#include <set>

#include "base/numbers.h"
#include "io/formats/text_tokens.h"
#include "io/formats/xml_text.h"

namespace tetfusion {

namespace {

// Other programs call theirs .msh, too, and this is how they begin.
const char* whose_mesh(std::string_view line) {
  if (line.starts_with("(")) {
    return ". This is a Fluent mesh, it seems: ParaView converts it to .vtu";
  }
  if (line.starts_with("MESH ")) {
    return ". This is a mesh of GiD, it seems, which is not read: let it export .vtu or another "
           "format";
  }
  if (line.find_first_not_of("0123456789 \t\r") == line.npos) {
    return ". This is a mesh of FreeFem, it seems: let it save a .mesh";
  }
  return "";
}

using EntityKey = std::pair<int, std::int64_t>;

GmshLayout layout_of(std::string_view version) {
  GmshLayout layout;
  layout.counts_nodes = version == "1";
  if (version == "4.0") {
    layout.tag_first = true;
    layout.counts = 2;
    layout.point_reals = 6;
  }
  if (version == "4.1") {
    layout.numbers_first = true;
    layout.counts = 4;
  }
  return layout;
}

class GmshHeadParser {
 public:
  explicit GmshHeadParser(const FormatFile& file) : file_(file) {}

  GmshHead run() {
    std::string_view text = file_.text();
    while (next_section(&text)) {
    }
    if (head_.version.empty()) file_.fail("there is no $MeshFormat");
    if (head_.nodes.data() == nullptr) file_.fail("there are no $Nodes");
    if (head_.elements.data() == nullptr) file_.fail("there are no $Elements");
    finish_entities();
    return std::move(head_);
  }

 private:
  GmshCursor cursor(std::string_view section) const {
    return {file_, section, head_.binary, head_.swapped};
  }

  // Takes a section off the front of *text. False at the end of the file.
  bool next_section(std::string_view* text) {
    const std::size_t begin = text->find_first_not_of(" \t\r\n");
    if (begin == text->npos) return false;
    text->remove_prefix(begin);
    if ((*text)[0] != '$') {
      const std::string_view line = text->substr(0, text->find('\n'));
      file_.fail_in_line(text->data(), "expected a section, as $Nodes, found " + quoted(line) +
                                           (head_.version.empty() ? whose_mesh(line) : ""));
    }
    std::size_t line = std::min(text->find('\n'), text->size());
    std::string_view name = text->substr(1, line - 1);
    while (!name.empty() && is_blank(name.back())) name.remove_suffix(1);
    if (line < text->size()) ++line;
    const std::string end = std::string(is_1(name) ? "$END" : "$End").append(name);
    if (is_1(name) && head_.version.empty()) set_version("1");
    const std::string_view after = text->substr(line);
    // In a binary file its end may stand among the numbers, too.
    const std::size_t body = find(after, end, binary_bytes(name, after));
    if (body == after.npos) {
      file_.fail_in_line(text->data(),
                         std::string("$").append(name).append(": there is no ") + end);
    }
    parse_section(name, after.substr(0, body));
    *text = after.substr(body + end.size());
    return true;
  }

  // Sections that have other words in version 1.
  static bool is_1(std::string_view name) { return name == "NOD" || name == "ELM"; }

  // As text.find(), but that the pages of the file do not stay in memory.
  std::size_t find(std::string_view text, std::string_view what, std::size_t from) const {
    constexpr std::size_t kStep = std::size_t{4} << 20;
    for (; from < text.size(); from += kStep) {
      const std::string_view part = text.substr(from, kStep + what.size());
      const std::size_t found = part.find(what);
      if (found != part.npos) return from + found;
      file_.release(part);
    }
    return text.npos;
  }

  // How long the binary part of a section is at least, its text included.
  std::size_t binary_bytes(std::string_view name, std::string_view text) const {
    if (!head_.binary) return 0;
    GmshCursor all = cursor(text);
    if (name == "Nodes") {
      skip_nodes(&all);
    } else if (name == "Elements") {
      skip_elements(&all);
    } else if (name == "Entities" || name == "PartitionedEntities") {
      walk_entities(&all, name != "Entities", [](const EntityKey&, const EntityKey&, auto) {});
    } else if (name == "NodeData" || name == "ElementData") {
      const GmshData data = parse_data(text);
      const GmshDataSection& section = data.sections.front();
      return static_cast<std::size_t>(section.text.data() - text.data()) +
             section.rows * (4 + 8 * data.components);
    }
    return static_cast<std::size_t>(all.at() - text.data());
  }

  void skip_nodes(GmshCursor* all) const {
    const auto [blocks, nodes] = head_.read_counts(all);
    if (!head_.is_4) return all->skip(all->rows(nodes, 4 + 24, 4) * 28);
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const int dimension = head_.read_entity(all).first;
      const bool parametric = all->integer() != 0;
      const std::uint64_t values = 3 + (parametric ? static_cast<std::uint64_t>(dimension) : 0);
      const std::uint64_t count = all->size();
      all->skip(all->rows(count, 8 + 8 * values, 1 + values) * (8 + 8 * values));
    }
  }

  void skip_elements(GmshCursor* all) const {
    if (head_.is_4) return walk_blocks(all, [](const EntityKey&, std::uint64_t) {});
    const std::uint64_t elements = head_.read_counts(all).rows;
    for (std::uint64_t done = 0; done < elements;) {
      const auto nodes = static_cast<std::uint64_t>(known_type(all).nodes);
      const std::int64_t count = all->integer();
      const std::int64_t tags = all->integer();
      if (count <= 0 || tags < 0) all->fail("a block of elements has no right counts");
      const std::uint64_t row = 4 * (1 + static_cast<std::uint64_t>(tags) + nodes);
      all->skip(all->rows(static_cast<std::uint64_t>(count), row, 1) * row);
      done += static_cast<std::uint64_t>(count);
    }
  }

  static GmshElementType known_type(GmshCursor* all) {
    const char* const at = all->at();
    const std::int64_t type = all->integer();
    const GmshElementType known = gmsh_element_type(type);
    if (known.nodes == 0) {
      all->fail_at(at, "elements of Gmsh's type " + std::to_string(type) + " cannot be read");
    }
    return known;
  }

  // Goes over the elements of version 4: f(entity, elements) for each block.
  template <class F>
  void walk_blocks(GmshCursor* all, F f) const {
    const std::uint64_t blocks = head_.read_counts(all).blocks;
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const EntityKey entity = head_.read_entity(all);
      const auto nodes = static_cast<std::uint64_t>(known_type(all).nodes);
      const char* const begin = all->at();
      const std::uint64_t count = all->rows(all->size(), 8 * (1 + nodes), 1 + nodes);
      all->skip_numbers(count * (1 + nodes), 8);
      file_.release(begin, all->at());
      f(entity, count);
    }
  }

  // Calls f(entity, what it is a part of, its groups) for entities or, else, parts of them that a
  // partition has made. Of what is no part the second is 0, 0.
  template <class F>
  void walk_entities(GmshCursor* all, bool partitioned, F f) const {
    if (partitioned) {
      all->size();                                             // partitions
      all->skip_numbers(2 * all->rows(all->size(), 8, 2), 4);  // those of ghosts
    }
    std::array<std::uint64_t, 4> counts{};
    for (std::uint64_t& count : counts) count = all->size();
    for (int d = 0; d < 4; ++d) {
      for (std::uint64_t e = 0; e < counts[static_cast<std::size_t>(d)]; ++e) {
        const EntityKey entity{d, all->integer()};
        EntityKey whole{};
        if (partitioned) {
          whole.first = static_cast<int>(all->integer());
          whole.second = all->integer();
          skip_list(all);  // partitions that have it
        }
        // Where it is, or two corners of its box.
        all->skip_numbers(d == 0 ? head_.layout.point_reals : 6, 8);
        const PhysicalGroups::Tags groups = read_groups(all);
        if (d > 0) skip_list(all);  // what bounds it
        f(entity, whole, groups);
      }
    }
  }

  static PhysicalGroups::Tags read_groups(GmshCursor* all) {
    PhysicalGroups::Tags groups;
    const std::uint64_t count = all->rows(all->size(), 4, 1);
    for (std::uint64_t i = 0; i < count; ++i) {
      const std::int64_t number = all->integer();
      if (number != static_cast<std::int32_t>(number)) {
        all->fail("the tag " + std::to_string(number) + " needs more than 32 bits");
      }
      // It is negative where the group has the entity turned round.
      const std::int64_t tag = std::abs(number);
      const bool is_new = std::find(groups.begin(), groups.end(), tag) == groups.end();
      if (tag != 0 && is_new) groups.push_back(tag);
    }
    return groups;
  }

  static void skip_list(GmshCursor* all) { all->skip_numbers(all->rows(all->size(), 4, 1), 4); }

  void parse_section(std::string_view name, std::string_view text) {
    if (name == "MeshFormat") return parse_format(text);
    if (name == "Comments") return;
    if (head_.version.empty()) file_.fail_in_line(text.data(), "$MeshFormat must come first");
    if (name == "PhysicalNames") return parse_names(text);
    if (name == "Entities" && head_.is_4) return parse_entities(text, false);
    if (name == "PartitionedEntities" && head_.is_4) {
      leave_out(kGmshPartitions);
      return parse_entities(text, true);
    }
    if (name == "Nodes" || name == "NOD") return take(&head_.nodes, &head_.node_count, text);
    if (name == "Elements" || name == "ELM") {
      return take(&head_.elements, &head_.element_count, text);
    }
    if (name == "NodeData") return add_data(parse_data(text), &head_.node_data);
    if (name == "ElementData") return add_data(parse_data(text), &head_.element_data);
    leave_out(std::string(name));
  }

  // What another partition has of an array belongs to that.
  static void add_data(GmshData data, std::vector<GmshData>* all) {
    const GmshDataSection& section = data.sections.front();
    const auto lacks_it = [&](const GmshData& d) {
      return d.name == data.name && d.time == data.time && d.step == data.step &&
             d.components == data.components &&
             std::ranges::none_of(d.sections, [&](const GmshDataSection& s) {
               return s.partition == 0 || s.partition == section.partition;
             });
    };
    const auto found = section.partition == 0 ? all->end() : std::ranges::find_if(*all, lacks_it);
    if (found == all->end()) return all->push_back(std::move(data));
    found->sections.push_back(section);
  }

  void leave_out(const std::string& word) {
    if (names_left_out_.insert(word).second) head_.left_out.push_back(word);
  }

  [[noreturn]] void refuse_version(std::string_view version) const {
    file_.fail("a Gmsh file of version " + quoted(version) +
               ", expected 2.2 or 4.1: Gmsh writes these with -format msh22 or msh41");
  }

  void set_version(std::string_view version) {
    head_.version = std::string(version == "4" ? "4.0" : version);
    head_.is_4 = head_.version == "4.0" || head_.version == "4.1";
    head_.layout = layout_of(head_.version);
  }

  void parse_format(std::string_view text) {
    GmshCursor in(file_, text, false, false);
    set_version(in.word());
    const std::uint64_t type = in.count();
    const std::uint64_t bytes = in.count();
    if (!head_.is_4 && head_.version != "2" && !head_.version.starts_with("2.")) {
      refuse_version(head_.version);
    }
    if (type > 1 || bytes != 8) {
      in.fail("expected 0 or 1 and 8 behind the version, found " + std::to_string(type) + " and " +
              std::to_string(bytes));
    }
    head_.binary = type == 1;
    if (!head_.binary) return;
    if (head_.version == "4.0") {
      file_.fail(
          "a binary Gmsh file of version 4.0, which only Gmsh 4.0 reads: let that write "
          "text, or -format msh22");
    }
    in.end_line();
    GmshCursor one(file_, {in.at(), text.size() - static_cast<std::size_t>(in.at() - text.data())},
                   true, false);
    const std::int64_t order = one.integer();
    head_.swapped = order == 0x01000000;
    if (order != 1 && !head_.swapped) one.fail("expected a binary 1 behind the version");
  }

  void take(std::string_view* section, std::uint64_t* count, std::string_view text) {
    if (section->data() != nullptr) file_.fail_in_line(text.data(), "the section is there twice");
    *section = text;
    GmshCursor in = cursor(text);
    *count = head_.read_counts(&in).rows;
    in.rows(*count, 4, 1);
  }

  void parse_names(std::string_view text) {
    GmshCursor in(file_, text, false, false);
    const std::uint64_t names = in.rows(in.count(), 1, 2);
    for (std::uint64_t i = 0; i < names; ++i) {
      const std::string_view row = in.line();
      const std::size_t open = row.find('"');
      const std::size_t close = row.rfind('"');
      if (open == close) in.fail_at(row.data(), "expected a text in quotes");
      head_.names.push_back(parse_group(row.substr(0, open)));
      head_.names.back().name = legible(row.substr(open + 1, close - open - 1));
      if (close + 1 < row.size()) leave_out("words behind the names of groups");
    }
  }

  // Dimension and tag or, before version 4, the tag alone.
  GmshName parse_group(std::string_view text) const {
    TokenCursor numbers(text, 0);
    const std::string_view first = numbers.next();
    const std::string_view second = numbers.next();
    if (first.empty() || !numbers.next().empty() || (second.empty() && head_.is_4)) {
      file_.fail_in_line(text.data(), "expected the dimension and tag of a group before its name");
    }
    GmshName group;
    if (!second.empty()) {
      group.dimension = file_.number<std::int32_t>(first);
      if (group.dimension < GmshName::kNoDimension || group.dimension > 3) {
        file_.fail_in_line(text.data(), "expected a dimension of 0 to 3, or -1");
      }
    }
    group.tag = file_.number<std::int32_t>(second.empty() ? first : second);
    return group;
  }

  void parse_entities(std::string_view text, bool partitioned) {
    GmshCursor in = cursor(text);
    const auto take = [&](const EntityKey& entity, const EntityKey& whole,
                          const PhysicalGroups::Tags& groups) {
      if (partitioned && whole == entity && groups.empty()) return;  // has the number of the whole
      const bool is_part = partitioned && whole.first == entity.first;
      // Gmsh gives seams the groups of what they cut, though these are of a higher dimension.
      const bool is_seam = partitioned && whole.first > entity.first;
      head_.entities[entity] = {is_seam ? PhysicalGroups::Tags{} : groups, 0,
                                is_part ? whole.second : entity.second, is_seam};
    };
    walk_entities(&in, partitioned, take);
  }

  // Parts without a group of their own have those of the whole. Elements of seams are not counted:
  // kept as cells they would hold the mesh where the partition has cut it.
  void finish_entities() {
    bool has_seams = false;
    bool has_several = false;
    for (auto& [key, entity] : head_.entities) {
      has_seams = has_seams || entity.is_seam;
      const auto whole = head_.entities.find({key.first, entity.geometrical});
      if (entity.groups.empty() && whole != head_.entities.end()) {
        entity.groups = whole->second.groups;
      }
      has_several = has_several || entity.groups.size() > 1;
    }
    PhysicalGroups groups;
    if (has_seams || has_several) {
      GmshCursor in = cursor(head_.elements);
      walk_blocks(&in, [&](const EntityKey& key, std::uint64_t count) {
        const GmshEntity entity = head_.entity(key.first, key.second);
        if (entity.is_seam) head_.seam_elements += count;
        groups.add(key.first, entity.groups, count);
      });
    }
    for (auto& [key, entity] : head_.entities) {
      entity.physical = groups.choose(key.first, entity.groups);
    }
    if (head_.seam_elements > 0) pass_over_seams();
    if (const std::string lost = groups.left_out(head_.names); !lost.empty()) leave_out(lost);
  }

  void pass_over_seams() {
    if (head_.seam_elements > head_.element_count) {
      cursor(head_.elements)
          .fail("there are more elements than the " + format_count(head_.element_count) +
                " announced");
    }
    head_.element_count -= head_.seam_elements;
    leave_out("elements between partitions");
  }

  GmshData parse_data(std::string_view text) const {
    GmshCursor in(file_, text, false, false);  // but for the rows
    GmshData data;
    GmshDataSection section;
    const std::uint64_t texts = in.rows(in.count(), 1, 1);
    for (std::uint64_t i = 0; i < texts; ++i) {
      const std::string name = in.text();
      if (i == 0) data.name = legible(name);
    }
    const std::uint64_t reals = in.rows(in.count(), 1, 1);
    for (std::uint64_t i = 0; i < reals; ++i) {
      const double value = in.real();
      if (i == 0) data.time = value;
    }
    const std::uint64_t integers = in.rows(in.count(), 1, 1);
    if (integers < 3) in.fail("expected a time step, a number of components and one of rows");
    for (std::uint64_t i = 0; i < integers; ++i) {
      const std::int64_t value = in.integer();
      if (i > 0 && value < 0) in.fail("expected a count, found " + std::to_string(value));
      if (i == 0) data.step = value;
      if (i == 1) data.components = static_cast<std::uint64_t>(value);
      if (i == 2) section.rows = static_cast<std::uint64_t>(value);
      if (i == 3) section.partition = value;
    }
    in.end_line();
    if (data.components == 0 || data.components > 64) {
      in.fail(std::to_string(data.components) + " components cannot be read");
    }
    const auto head = static_cast<std::size_t>(in.at() - text.data());
    section.text = text.substr(head);
    cursor(section.text).rows(section.rows, 4 + 8 * data.components, 1 + data.components);
    data.sections.push_back(section);
    if (data.name.empty()) data.name = "data";
    return data;
  }

  const FormatFile& file_;
  GmshHead head_;
  std::set<std::string> names_left_out_;
};

}  // namespace

GmshEntity GmshHead::entity(int dimension, std::int64_t tag) const {
  const auto found = entities.find({dimension, tag});
  return found == entities.end() ? GmshEntity{{}, 0, tag, false} : found->second;
}

GmshHead::Counts GmshHead::read_counts(GmshCursor* in) const {
  Counts counts;
  if (!is_4) {
    counts.rows = in->count();
    if (in->binary()) in->end_line();
    return counts;
  }
  counts.blocks = in->size();
  counts.rows = in->size();
  in->skip_numbers(layout.counts - 2, 8);
  return counts;
}

std::pair<int, std::int64_t> GmshHead::read_entity(GmshCursor* in) const {
  std::int64_t dimension = in->integer();
  std::int64_t tag = in->integer();
  if (layout.tag_first) std::swap(dimension, tag);
  if (dimension < 0 || dimension > 3) in->fail("expected a dimension of 0 to 3");
  return {static_cast<int>(dimension), tag};
}

bool looks_like_gmsh(std::string_view text) {
  return text.starts_with("$MeshFormat") || text.starts_with("$NOD");
}

GmshHead parse_gmsh_head(const FormatFile& file) { return GmshHeadParser(file).run(); }

}  // namespace tetfusion
