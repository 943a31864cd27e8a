#include "io/gmsh_mesh.h"

#include <array>
#include <cstdlib>
#include <limits>
#include <string>
#include <utility>

#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

// Where node k of VTK's wedge stands in Gmsh's prism, which sees its first triangle from inside.
constexpr std::array<std::size_t, 6> kWedge = {0, 2, 1, 3, 5, 4};

class NodeReader {
 public:
  NodeReader(const FormatFile& file, const GmshHead& head)
      : head_(head), in_(file, head.nodes, head.binary, head.swapped) {}

  GmshNodes run() {
    nodes_.points.reserve(head_.node_count);
    numbers_.reserve(head_.node_count);
    if (head_.is_4) {
      read_blocks();
    } else {
      read_list();
    }
    in_.rest_is_blank();
    nodes_.places = NumberMap(numbers_);
    if (nodes_.places.has_twins()) {
      in_.fail("node " + std::to_string(nodes_.places.twin()) + " is there twice");
    }
    return std::move(nodes_);
  }

 private:
  void read_list() {
    in_.count();
    if (in_.binary()) in_.end_line();
    for (std::uint64_t i = 0; i < head_.node_count; ++i) {
      const char* const at = in_.at();
      const std::int64_t number = in_.integer();
      if (number < 0) in_.fail_at(at, "a node has the number " + std::to_string(number));
      numbers_.push_back(static_cast<std::uint64_t>(number));
      add_point();
    }
  }

  void read_blocks() {
    const std::uint64_t blocks = in_.size();
    for (int i = 0; i < 3; ++i) in_.size();
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const std::int64_t dimension = in_.integer();
      in_.integer();
      const bool parametric = in_.integer() != 0;
      const std::int64_t more = parametric ? dimension : 0;
      if (more < 0 || more > 3) in_.fail("expected a dimension of 0 to 3");
      const auto values = 3 + static_cast<std::uint64_t>(more);
      const std::uint64_t count = in_.rows(in_.size(), 8 + 8 * values, 1 + values);
      if (count > head_.node_count - nodes_.points.size()) in_.fail(too_many());
      for (std::uint64_t i = 0; i < count; ++i) numbers_.push_back(in_.size());
      for (std::uint64_t i = 0; i < count; ++i) {
        add_point();
        for (std::int64_t k = 0; k < more; ++k) in_.real();
      }
    }
    if (nodes_.points.size() != head_.node_count) {
      in_.fail("expected " + std::to_string(head_.node_count) + " nodes, found " +
               std::to_string(nodes_.points.size()));
    }
  }

  std::string too_many() const {
    return "there are more than the " + std::to_string(head_.node_count) + " nodes announced";
  }

  void add_point() {
    const double x = in_.real();
    const double y = in_.real();
    nodes_.points.push_back({x, y, in_.real()});
  }

  const GmshHead& head_;
  GmshCursor in_;
  GmshNodes nodes_;
  Vector<std::uint64_t> numbers_;
};

class ElementReader {
 public:
  ElementReader(const FormatFile& file, const GmshHead& head, const NumberMap& nodes)
      : head_(head), nodes_(nodes), in_(file, head.elements, head.binary, head.swapped) {}

  GmshElements run() {
    const std::uint64_t count = head_.element_count;
    out_.cells.types.reserve(count);
    out_.cells.ids.reserve(4 * count);
    out_.physical.reserve(count);
    out_.geometrical.reserve(count);
    out_.numbers.reserve(count);
    if (head_.is_4) {
      read_blocks();
    } else if (in_.binary()) {
      read_headed_lists();
    } else {
      read_list();
    }
    in_.rest_is_blank();
    return std::move(out_);
  }

 private:
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

  void add_tags(std::uint64_t number, std::int64_t physical, std::int64_t geometrical) {
    out_.numbers.push_back(number);
    out_.physical.push_back(small(physical));
    out_.geometrical.push_back(small(geometrical));
  }

  // A number takes 32 bits in a binary file of version 2, 64 in one of version 4.
  void add_nodes(const GmshElementType& type) {
    std::array<VertexId, 10> ids{};
    for (int k = 0; k < type.nodes; ++k) {
      in_.skip_blanks_of_text();
      const char* const at = in_.at();
      const std::uint64_t number =
          head_.is_4 ? in_.size() : static_cast<std::uint64_t>(in_.integer());
      const std::uint64_t place = nodes_.find(number);
      if (place == NumberMap::kNone) {
        in_.invalid_at(at, "element " + std::to_string(out_.numbers.back()) + " uses node " +
                               std::to_string(static_cast<std::int64_t>(number)) +
                               ", which is not there");
      }
      ids[static_cast<std::size_t>(k)] = static_cast<VertexId>(place);
    }
    out_.cells.types.push_back(type.vtk);
    for (std::size_t k = 0; k < static_cast<std::size_t>(type.nodes); ++k) {
      out_.cells.ids.push_back(ids[type.vtk == kVtkWedge ? kWedge[k] : k]);
    }
  }

  std::uint64_t element_number() {
    const char* const at = in_.at();
    const std::int64_t number = in_.integer();
    if (number < 0) in_.fail_at(at, "an element has the number " + std::to_string(number));
    return static_cast<std::uint64_t>(number);
  }

  // Physical group, entity, and then what says which processors have the element.
  void read_tags(std::uint64_t number, std::uint64_t count) {
    std::int64_t physical = 0;
    std::int64_t geometrical = 0;
    for (std::uint64_t k = 0; k < count; ++k) {
      const std::int64_t tag = in_.integer();
      if (k == 0) physical = tag;
      if (k == 1) geometrical = tag;
    }
    add_tags(number, physical, geometrical);
  }

  void read_list() {
    in_.count();
    for (std::uint64_t i = 0; i < head_.element_count; ++i) {
      const std::uint64_t number = element_number();
      const GmshElementType type = element_type();
      const std::uint64_t tags = in_.count();
      read_tags(number, in_.rows(tags, 1, 1));
      add_nodes(type);
    }
  }

  void read_headed_lists() {
    in_.count();
    in_.end_line();
    for (std::uint64_t done = 0; done < head_.element_count;) {
      const GmshElementType type = element_type();
      const std::int64_t count = in_.integer();
      const std::int64_t tags = in_.integer();
      if (count <= 0 || static_cast<std::uint64_t>(count) > head_.element_count - done ||
          tags < 0) {
        in_.fail("a block of " + std::to_string(count) + " elements with " + std::to_string(tags) +
                 " tags each");
      }
      for (std::int64_t i = 0; i < count; ++i) {
        read_tags(element_number(), static_cast<std::uint64_t>(tags));
        add_nodes(type);
      }
      done += static_cast<std::uint64_t>(count);
    }
  }

  void read_blocks() {
    const std::uint64_t blocks = in_.size();
    for (int i = 0; i < 3; ++i) in_.size();
    for (std::uint64_t b = 0; b < blocks; ++b) {
      const auto dimension = static_cast<int>(in_.integer());
      const std::int64_t entity = in_.integer();
      const GmshElementType type = element_type();
      const auto found = head_.physical.find({dimension, entity});
      // A group that is the entity turned round has a negative tag.
      const std::int64_t physical = found == head_.physical.end() ? 0 : std::abs(found->second);
      const auto nodes = static_cast<std::uint64_t>(type.nodes);
      const std::uint64_t count = in_.rows(in_.size(), 8 + 8 * nodes, 1 + nodes);
      if (count > head_.element_count - out_.numbers.size()) {
        in_.fail("there are more than the " + std::to_string(head_.element_count) +
                 " elements announced");
      }
      for (std::uint64_t i = 0; i < count; ++i) {
        add_tags(in_.size(), physical, entity);
        add_nodes(type);
      }
    }
    if (out_.numbers.size() != head_.element_count) {
      in_.fail("expected " + std::to_string(head_.element_count) + " elements, found " +
               std::to_string(out_.numbers.size()));
    }
  }

  const GmshHead& head_;
  const NumberMap& nodes_;
  GmshCursor in_;
  GmshElements out_;
};

}  // namespace

GmshNodes read_gmsh_nodes(const FormatFile& file, const GmshHead& head) {
  return NodeReader(file, head).run();
}

GmshElements read_gmsh_elements(const FormatFile& file, const GmshHead& head,
                                const NumberMap& nodes) {
  return ElementReader(file, head, nodes).run();
}

}  // namespace tetfusion
