#include "io/gmsh/gmsh_elements.h"

#include <algorithm>
#include <limits>
#include <string>

#include "base/numbers.h"
#include "io/source/cell_kinds.h"
#include "mesh/split_cells.h"

namespace tetfusion {

namespace {

// Where node k of VTK's wedge stands in Gmsh's prism, which sees its first triangle from inside.
constexpr std::array<std::size_t, 6> kWedge = {0, 2, 1, 3, 5, 4};

// In another order where a group has the entity turned round.
bool have_same_corners(const GmshElement& a, const GmshElement& b) {
  if (a.corners == b.corners) return true;
  auto of_a = a.corners;
  auto of_b = b.corners;
  std::sort(of_a.begin(), of_a.end());
  std::sort(of_b.begin(), of_b.end());
  return of_a == of_b;
}

// Two cells of one group are no repetition, but a fault of the mesh.
bool is_repeated(const GmshElement& a, const PhysicalGroups::Tags& groups, const GmshElement& b) {
  if (a.type.vtk != b.type.vtk || a.geometrical != b.geometrical) return false;
  if (groups.empty() || b.physical == 0) return false;
  if (std::find(groups.begin(), groups.end(), b.physical) != groups.end()) return false;
  return have_same_corners(a, b);
}

}  // namespace

int GmshElement::dimension() const {
  switch (linear_type(type.vtk)) {
    case kVtkVertex:
      return 0;
    case kVtkLine:
      return 1;
    case kVtkTriangle:
    case kVtkQuad:
      return 2;
    default:
      return 3;
  }
}

GmshElements::GmshElements(const FormatFile& file, const GmshHead& head, const Wanted& wanted,
                           Vector<std::uint64_t>* passed)
    : GmshWalker(file, head, head.elements), wanted_(wanted), passed_(passed) {}

GmshElements::GmshElements(const FormatFile& file, const GmshHead& head, const Wanted& wanted,
                           const GmshElementPlace& place)
    : GmshWalker(file, head, head.elements, place), wanted_(wanted) {}

GmshElementPlace GmshElements::place() const {
  return has_ahead_ ? ahead_place_ : GmshWalker::place();
}

bool GmshElements::next(GmshElement* out) {
  if (has_ahead_) {
    *out = ahead_;
    has_ahead_ = false;
  } else {
    if (!find_element()) return false;
    read(out);
  }
  if (!wanted_.together) return true;
  groups_.clear();
  if (out->physical != 0) groups_.push_back(out->physical);
  while (find_element()) {
    ahead_place_ = GmshWalker::place();
    read(&ahead_);
    has_ahead_ = !is_repeated(*out, groups_, ahead_);
    if (has_ahead_) break;
    groups_.push_back(ahead_.physical);
    if (passed_ != nullptr) passed_->push_back(out->number);
    out->number = ahead_.number;
  }
  return true;
}

void GmshElements::find_corners(const GmshElement& element, const NumberMap& nodes,
                                VertexId* out) const {
  const bool wedge = linear_type(element.type.vtk) == kVtkWedge;
  for (std::size_t k = 0; k < corners_of(element.type.vtk); ++k) {
    const std::size_t of = wedge ? kWedge[k] : k;
    const auto number = static_cast<std::int64_t>(element.corners[of]);
    const std::uint64_t place = nodes.find(element.corners[of]);
    if (place == NumberMap::kNone) {
      const std::size_t bytes = !in_.binary() ? 0 : head_.is_4 ? 8 : 4;
      in_.invalid_at(element.corners_at + of * bytes, "element " + std::to_string(element.number) +
                                                          " uses node " + std::to_string(number) +
                                                          ", which is not there");
    }
    out[k] = static_cast<VertexId>(place);
  }
}

// Goes over the heads of blocks.
bool GmshElements::find_element() {
  while (place_.left == 0) {
    const bool is_last = place_.done == head_.element_count;
    if (is_last && (!head_.is_4 || place_.blocks == 0)) {
      in_.rest_is_blank();
      return false;
    }
    if (head_.is_4) {
      if (place_.blocks == 0) {
        in_.fail("expected " + format_count(announced(), "element") + ", found " +
                 format_count(place_.done + head_.seam_elements));
      }
      begin_block();
    } else if (in_.binary()) {
      begin_headed_list();
    } else {
      place_.left = 1;
    }
    if (place_.left > head_.element_count - place_.done) fail_too_many();
  }
  return true;
}

// After find_element().
void GmshElements::read(GmshElement* out) {
  --place_.left;
  ++place_.done;
  if (head_.is_4) {
    out->number = in_.size();
    out->physical = small(place_.physical);
    out->geometrical = small(place_.geometrical);
  } else {
    read_number(out);
    read_tags(out);
  }
  out->type = place_.type;
  // A number takes 32 bits in a binary file of version 2, 64 in one of version 4.
  const std::size_t bytes = head_.is_4 ? 8 : 4;
  std::size_t left = static_cast<std::size_t>(place_.type.nodes);
  if (wanted_.corners || wanted_.together) {
    in_.skip_blanks_of_text();
    out->corners_at = in_.at();
    out->corners = {};
    const std::size_t corners = corners_of(place_.type.vtk);
    for (std::size_t k = 0; k < corners; ++k) {
      out->corners[k] = head_.is_4 ? in_.size() : static_cast<std::uint64_t>(in_.integer());
    }
    left -= corners;
  }
  in_.skip_numbers(left, bytes);
}

void GmshElements::read_number(GmshElement* out) {
  const char* const at = in_.at();
  const std::int64_t number = in_.integer();
  if (number < 0) in_.fail_at(at, "an element has the number " + std::to_string(number));
  out->number = static_cast<std::uint64_t>(number);
  if (in_.binary()) return;
  place_.type = element_type();
  place_.tags = head_.layout.counts_nodes ? 2 : in_.rows(in_.count(), 1, 1);
}

// Physical group, entity, and then how many partitions have the element, and which.
void GmshElements::read_tags(GmshElement* out) {
  std::int64_t physical = 0;
  std::int64_t geometrical = 0;
  for (std::uint64_t k = 0; k < place_.tags; ++k) {
    const std::int64_t tag = in_.integer();
    if (k == 0) physical = tag;
    if (k == 1) geometrical = tag;
    if (k == 2) has_partitions_ = has_partitions_ || tag != 0;
  }
  out->physical = small(physical);
  out->geometrical = small(geometrical);
  if (head_.layout.counts_nodes) check_node_count();
}

void GmshElements::check_node_count() {
  in_.skip_blanks_of_text();
  const char* const at = in_.at();
  const std::uint64_t nodes = in_.count();
  if (nodes == static_cast<std::uint64_t>(place_.type.nodes)) return;
  in_.fail_at(at, "expected " +
                      format_count(static_cast<std::uint64_t>(place_.type.nodes), "node") +
                      ", found " + format_count(nodes));
}

void GmshElements::begin_block() {
  const auto [dimension, tag] = head_.read_entity(&in_);
  const GmshEntity entity = head_.entity(dimension, tag);
  place_.type = element_type();
  place_.physical = entity.physical;
  place_.geometrical = entity.geometrical;
  const auto nodes = static_cast<std::uint64_t>(place_.type.nodes);
  place_.left = in_.rows(in_.size(), 8 + 8 * nodes, 1 + nodes);
  --place_.blocks;
  if (entity.is_seam) pass_over_block(nodes);
}

void GmshElements::pass_over_block(std::uint64_t nodes) {
  for (; place_.left > 0; --place_.left) {
    const std::uint64_t number = in_.size();
    if (passed_ != nullptr) passed_->push_back(number);
    in_.skip_numbers(nodes, 8);
  }
}

void GmshElements::begin_headed_list() {
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

GmshElementType GmshElements::element_type() {
  const char* const at = in_.at();
  const std::int64_t type = in_.integer();
  const GmshElementType known = gmsh_element_type(type);
  if (known.nodes == 0) {
    in_.fail_at(at, "elements of Gmsh's type " + std::to_string(type) +
                        " cannot be read: only tetrahedra, and points, lines and triangles "
                        "beside them");
  }
  return known;
}

std::int32_t GmshElements::small(std::int64_t tag) const {
  if (tag < std::numeric_limits<std::int32_t>::min() ||
      tag > std::numeric_limits<std::int32_t>::max()) {
    in_.fail("the tag " + std::to_string(tag) + " needs more than 32 bits");
  }
  return static_cast<std::int32_t>(tag);
}

void GmshElements::fail_too_many() const {
  in_.fail("there are more elements than the " + format_count(announced()) + " announced");
}

}  // namespace tetfusion
