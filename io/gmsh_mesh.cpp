#include "io/gmsh_mesh.h"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>

#include "mesh/blocks.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

// Where node k of VTK's wedge stands in Gmsh's prism, which sees its first triangle from inside.
constexpr std::array<std::size_t, 6> kWedge = {0, 2, 1, 3, 5, 4};

std::string_view from(std::string_view section, const char* at) {
  return section.substr(static_cast<std::size_t>(at - section.data()));
}

// Takes what was passed out of memory.
class Releaser {
 public:
  Releaser(const FormatFile& file, const char* begin) : file_(file), released_(begin) {}
  void passed(const char* at) {
    constexpr std::ptrdiff_t kStep = std::ptrdiff_t{1} << 20;
    if (at - released_ < kStep) return;
    file_.release(released_, at);
    released_ = at;
  }

 private:
  const FormatFile& file_;
  const char* released_;
};

// What numbers in a row say: the first one, or that they are in no order.
class NumberRun {
 public:
  explicit NumberRun(Vector<std::uint64_t>* all) : all_(all) {}
  void add(std::uint64_t number) {
    if (count_ == 0) first_ = number;
    ascends_ = ascends_ && number == first_ + count_;
    ++count_;
    if (all_ != nullptr) all_->push_back(number);
  }
  bool ascends() const { return ascends_; }
  std::uint64_t first() const { return first_; }

 private:
  Vector<std::uint64_t>* all_;
  std::uint64_t first_ = 0;
  std::uint64_t count_ = 0;
  bool ascends_ = true;
};

// Goes through a section from place to place: its head first, then rows; in version 4 in blocks.
template <class Place>
class SectionWalker {
 public:
  Place place() const {
    Place here = place_;
    here.at = in_.at();
    return here;
  }
  const GmshCursor& cursor() const { return in_; }

 protected:
  SectionWalker(const FormatFile& file, const GmshHead& head, std::string_view section)
      : head_(head), in_(file, section, head.binary, head.swapped) {
    if (!head_.is_4) {
      in_.count();
      if (in_.binary()) in_.end_line();
      return;
    }
    place_.blocks = in_.size();
    for (int i = 0; i < 3; ++i) in_.size();
  }
  SectionWalker(const FormatFile& file, const GmshHead& head, std::string_view section,
                const Place& place)
      : head_(head), in_(file, from(section, place.at), head.binary, head.swapped), place_(place) {}

  const GmshHead& head_;
  GmshCursor in_;
  Place place_;
};

// ---- nodes ----

class NodeWalker : public SectionWalker<GmshNodePlace> {
 public:
  NodeWalker(const FormatFile& file, const GmshHead& head)
      : SectionWalker(file, head, head.nodes) {}
  NodeWalker(const FormatFile& file, const GmshHead& head, const GmshNodePlace& place)
      : SectionWalker(file, head, head.nodes, place) {}

  // Goes to the next node of version 4, over the heads of blocks, whose numbers `numbers` gets.
  // `done`: nodes before.
  void find_node(std::uint64_t done, NumberRun* numbers) {
    if (!head_.is_4) return;
    while (place_.left == 0) {
      if (place_.blocks == 0) {
        in_.fail("expected " + std::to_string(head_.node_count) + " nodes, found " +
                 std::to_string(done));
      }
      begin_block(numbers);
      if (place_.left > head_.node_count - done) {
        in_.fail("there are more than the " + std::to_string(head_.node_count) +
                 " nodes announced");
      }
    }
  }
  // Nodes may not follow the last one; empty blocks may.
  void end(NumberRun* numbers) {
    while (head_.is_4 && place_.blocks > 0) {
      begin_block(numbers);
      if (place_.left > 0) {
        in_.fail("there are more than the " + std::to_string(head_.node_count) +
                 " nodes announced");
      }
    }
    in_.rest_is_blank();
  }

  // After find_node().
  void skip(NumberRun* numbers) {
    take_number(numbers);
    in_.skip_numbers(3 + place_.more, 8);
  }
  Vec3<double> read() {
    take_number(nullptr);
    const double x = in_.real();
    const double y = in_.real();
    const Vec3<double> point{x, y, in_.real()};
    in_.skip_numbers(place_.more, 8);
    return point;
  }

 private:
  void begin_block(NumberRun* numbers) {
    const std::int64_t dimension = in_.integer();
    in_.integer();
    const bool parametric = in_.integer() != 0;
    const std::int64_t more = parametric ? dimension : 0;
    if (more < 0 || more > 3) in_.fail("expected a dimension of 0 to 3");
    place_.more = static_cast<std::uint64_t>(more);
    const std::uint64_t values = 3 + place_.more;
    place_.left = in_.rows(in_.size(), 8 + 8 * values, 1 + values);
    --place_.blocks;
    if (numbers == nullptr) return in_.skip_numbers(place_.left, 8);
    for (std::uint64_t i = 0; i < place_.left; ++i) numbers->add(in_.size());
  }

  void take_number(NumberRun* numbers) {
    if (head_.is_4) {
      --place_.left;
      return;
    }
    const char* const at = in_.at();
    const std::int64_t number = in_.integer();
    if (number < 0) in_.fail_at(at, "a node has the number " + std::to_string(number));
    if (numbers != nullptr) numbers->add(static_cast<std::uint64_t>(number));
  }
};

// ---- elements ----

struct Element {
  std::uint64_t number = 0;
  GmshElementType type;
  std::int32_t physical = 0;
  std::int32_t geometrical = 0;
  std::array<VertexId, 10> ids{};  // in VTK's order
};

class ElementWalker : public SectionWalker<GmshElementPlace> {
 public:
  // `seams` gets the numbers of the elements that are passed over.
  ElementWalker(const FormatFile& file, const GmshHead& head, Vector<std::uint64_t>* seams)
      : SectionWalker(file, head, head.elements), seams_(seams) {}
  ElementWalker(const FormatFile& file, const GmshHead& head, const GmshElementPlace& place)
      : SectionWalker(file, head, head.elements, place) {}

  // Goes over the heads of blocks. `done`: elements before.
  void find_element(std::uint64_t done) {
    while (place_.left == 0) {
      if (head_.is_4) {
        if (place_.blocks == 0) {
          in_.fail("expected " + std::to_string(announced()) + " elements, found " +
                   std::to_string(done + head_.seam_elements));
        }
        begin_block();
      } else if (in_.binary()) {
        begin_headed_list();
      } else {
        place_.left = 1;
      }
      if (place_.left > head_.element_count - done) fail_too_many();
    }
  }
  void end() {
    while (head_.is_4 && place_.blocks > 0) {
      begin_block();
      if (place_.left > 0) fail_too_many();
    }
    in_.rest_is_blank();
  }

  // After find_element(). Without `nodes` ids are passed over.
  void read(const NumberMap* nodes, Element* out) {
    --place_.left;
    if (head_.is_4) {
      out->number = in_.size();
      out->physical = small(place_.physical);
      out->geometrical = small(place_.geometrical);
    } else {
      read_number(out);
      read_tags(out);
    }
    out->type = place_.type;
    const auto count = static_cast<std::uint64_t>(place_.type.nodes);
    if (nodes == nullptr) {
      in_.skip_numbers(count, head_.is_4 ? 8 : 4);
    } else {
      read_nodes(*nodes, count, out);
    }
  }

 private:
  [[noreturn]] void fail_too_many() const {
    in_.fail("there are more than the " + std::to_string(announced()) + " elements announced");
  }
  std::uint64_t announced() const { return head_.element_count + head_.seam_elements; }

  GmshElementType element_type() {
    const char* const at = in_.at();
    const std::int64_t type = in_.integer();
    const GmshElementType known = gmsh_element_type(type);
    if (known.name == nullptr) {
      in_.fail_at(at, "elements of Gmsh's type " + std::to_string(type) +
                          " cannot be read: only tetrahedra, and points, lines and triangles "
                          "beside them");
    }
    return known;
  }

  std::int32_t small(std::int64_t tag) const {
    if (tag < std::numeric_limits<std::int32_t>::min() ||
        tag > std::numeric_limits<std::int32_t>::max()) {
      in_.fail("the tag " + std::to_string(tag) + " needs more than 32 bits");
    }
    return static_cast<std::int32_t>(tag);
  }

  void begin_block() {
    const auto dimension = static_cast<int>(in_.integer());
    const GmshEntity entity = head_.entity(dimension, in_.integer());
    place_.type = element_type();
    place_.physical = entity.physical;
    place_.geometrical = entity.geometrical;
    const auto nodes = static_cast<std::uint64_t>(place_.type.nodes);
    place_.left = in_.rows(in_.size(), 8 + 8 * nodes, 1 + nodes);
    --place_.blocks;
    if (entity.is_seam) pass_over_block(nodes);
  }

  void pass_over_block(std::uint64_t nodes) {
    for (; place_.left > 0; --place_.left) {
      const std::uint64_t number = in_.size();
      if (seams_ != nullptr) seams_->push_back(number);
      in_.skip_numbers(nodes, 8);
    }
  }

  void begin_headed_list() {
    place_.type = element_type();
    const std::int64_t count = in_.integer();
    const std::int64_t tags = in_.integer();
    if (count <= 0 || tags < 0) {
      in_.fail("a block of " + std::to_string(count) + " elements with " + std::to_string(tags) +
               " tags each");
    }
    place_.left = static_cast<std::uint64_t>(count);
    place_.tags = static_cast<std::uint64_t>(tags);
  }

  void read_number(Element* out) {
    const char* const at = in_.at();
    const std::int64_t number = in_.integer();
    if (number < 0) in_.fail_at(at, "an element has the number " + std::to_string(number));
    out->number = static_cast<std::uint64_t>(number);
    if (in_.binary()) return;
    place_.type = element_type();
    place_.tags = in_.rows(in_.count(), 1, 1);
  }

  // Physical group, entity, and then what says which processors have the element.
  void read_tags(Element* out) {
    std::int64_t physical = 0;
    std::int64_t geometrical = 0;
    for (std::uint64_t k = 0; k < place_.tags; ++k) {
      const std::int64_t tag = in_.integer();
      if (k == 0) physical = tag;
      if (k == 1) geometrical = tag;
    }
    out->physical = small(physical);
    out->geometrical = small(geometrical);
  }

  // A number takes 32 bits in a binary file of version 2, 64 in one of version 4.
  void read_nodes(const NumberMap& nodes, std::uint64_t count, Element* out) {
    std::array<VertexId, 10> ids{};
    for (std::size_t k = 0; k < count; ++k) {
      in_.skip_blanks_of_text();
      const char* const at = in_.at();
      const std::uint64_t number =
          head_.is_4 ? in_.size() : static_cast<std::uint64_t>(in_.integer());
      const std::uint64_t place = nodes.find(number);
      if (place == NumberMap::kNone) {
        in_.invalid_at(at, "element " + std::to_string(out->number) + " uses node " +
                               std::to_string(static_cast<std::int64_t>(number)) +
                               ", which is not there");
      }
      ids[k] = static_cast<VertexId>(place);
    }
    const bool wedge = out->type.vtk == kVtkWedge;
    for (std::size_t k = 0; k < count; ++k) out->ids[k] = ids[wedge ? kWedge[k] : k];
  }

  Vector<std::uint64_t>* seams_ = nullptr;
};

// Calls f(place, begin, end) for the rows [begin, end) that each of the places from that of row
// `first` on leads to, up to row first + count; from several threads.
template <class F>
void for_each_place(std::uint64_t first, std::uint64_t count, F f) {
  if (count == 0) return;
  const std::uint64_t begin = first / kRowsPerPlace;
  const std::uint64_t end = block_count(first + count, kRowsPerPlace);
  for_each_block(end - begin, 1, [&](std::size_t b, std::size_t, std::size_t) {
    const std::uint64_t place = begin + b;
    f(place, std::max(place * kRowsPerPlace, first),
      std::min((place + 1) * kRowsPerPlace, first + count));
  });
}

// The number of a run, or the map of them all: `index` goes through them.
template <class Index>
NumberMap map_numbers(std::uint64_t count, Index index) {
  const NumberRun run = index(nullptr);
  if (run.ascends()) return NumberMap::ascending(run.first(), count);
  Vector<std::uint64_t> numbers;
  numbers.reserve(count);
  index(&numbers);
  return NumberMap(numbers);
}

}  // namespace

GmshMesh::GmshMesh(const FormatFile& file, const GmshHead& head) : file_(file), head_(head) {
  nodes_ = map_numbers(head.node_count, [&](Vector<std::uint64_t>* all) {
    node_places_.clear();
    NumberRun numbers(all);
    NodeWalker walker(file_, head_);
    Releaser releaser(file_, head_.nodes.data());
    for (std::uint64_t i = 0; i < head_.node_count; ++i) {
      walker.find_node(i, &numbers);
      if (i % kRowsPerPlace == 0) {
        node_places_.push_back(walker.place());
        releaser.passed(walker.cursor().at());
      }
      walker.skip(&numbers);
    }
    walker.end(&numbers);
    return numbers;
  });
  file_.release(head.nodes);
  if (nodes_.has_twins()) {
    GmshCursor(file, head.nodes.substr(head.nodes.size()), head.binary, head.swapped)
        .fail("node " + std::to_string(nodes_.twin()) + " is there twice");
  }
  const bool wanted = !head.element_data.empty();
  // Numbers of elements that are passed over come last, so that values for these are known as such.
  const std::uint64_t seams = wanted ? head.seam_elements : 0;
  elements_ = map_numbers(head.element_count + seams, [&](Vector<std::uint64_t>* all) {
    element_places_.clear();
    types_ = {};
    NumberRun numbers(all);
    Vector<std::uint64_t> passed;
    ElementWalker walker(file_, head_, wanted ? &passed : nullptr);
    Releaser releaser(file_, head_.elements.data());
    Element element;
    for (std::uint64_t i = 0; i < head_.element_count; ++i) {
      walker.find_element(i);
      if (i % kRowsPerPlace == 0) {
        element_places_.push_back(walker.place());
        releaser.passed(walker.cursor().at());
      }
      walker.read(nullptr, &element);
      ++types_[element.type.vtk];
      numbers.add(wanted ? element.number : i);
    }
    walker.end();
    for (const std::uint64_t number : passed) numbers.add(number);
    return numbers;
  });
  file_.release(head.elements);
}

void GmshMesh::read_points(std::uint64_t first, std::uint64_t count, Vec3<double>* out) const {
  for_each_place(first, count, [&](std::uint64_t p, std::uint64_t begin, std::uint64_t end) {
    const GmshNodePlace& place = node_places_[p];
    NodeWalker walker(file_, head_, place);
    for (std::uint64_t i = p * kRowsPerPlace; i < end; ++i) {
      walker.find_node(i, nullptr);
      if (i < begin) {
        walker.skip(nullptr);
      } else {
        out[i - first] = walker.read();
      }
    }
    file_.release(place.at, walker.cursor().at());
  });
}

// Calls f(p, i, element) for a range of elements: for those of one place p in order.
template <class F>
void GmshMesh::walk_elements(std::uint64_t first, std::uint64_t count, const NumberMap* nodes,
                             F f) const {
  for_each_place(first, count, [&](std::uint64_t p, std::uint64_t begin, std::uint64_t end) {
    const GmshElementPlace& place = element_places_[p];
    ElementWalker walker(file_, head_, place);
    Element element;
    for (std::uint64_t i = p * kRowsPerPlace; i < end; ++i) {
      walker.find_element(i);
      walker.read(i < begin ? nullptr : nodes, &element);
      if (i >= begin) f(p, i, element);
    }
    file_.release(place.at, walker.cursor().at());
  });
}

ListedCells GmshMesh::read_cells(std::uint64_t first, std::uint64_t count) const {
  ListedCells cells;
  cells.types.resize(count);
  const std::uint64_t first_place = first / kRowsPerPlace;
  std::vector<Vector<VertexId>> ids(block_count(first + count, kRowsPerPlace) - first_place);
  walk_elements(first, count, &nodes_, [&](std::uint64_t p, std::uint64_t i, const Element& e) {
    cells.types[i - first] = e.type.vtk;
    Vector<VertexId>& to = ids[p - first_place];
    to.insert(to.end(), e.ids.begin(), e.ids.begin() + e.type.nodes);
  });
  std::size_t all = 0;
  for (const auto& some : ids) all += some.size();
  cells.ids.reserve(all);
  for (auto& some : ids) {
    cells.ids.insert(cells.ids.end(), some.begin(), some.end());
    some = {};
  }
  return cells;
}

void GmshMesh::read_tags(bool physical, std::uint64_t first, std::uint64_t count,
                         std::int32_t* out) const {
  walk_elements(first, count, nullptr, [&](std::uint64_t, std::uint64_t i, const Element& e) {
    out[i - first] = physical ? e.physical : e.geometrical;
  });
}

}  // namespace tetfusion
