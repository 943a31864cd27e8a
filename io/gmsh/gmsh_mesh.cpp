#include "io/gmsh/gmsh_mesh.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "base/blocks.h"
#include "base/numbers.h"
#include "io/source/cell_kinds.h"

namespace tetfusion {

namespace {

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
  std::uint64_t count() const { return count_; }

 private:
  Vector<std::uint64_t>* all_;
  std::uint64_t first_ = 0;
  std::uint64_t count_ = 0;
  bool ascends_ = true;
};

class NodeWalker : public GmshWalker<GmshNodePlace> {
 public:
  NodeWalker(const FormatFile& file, const GmshHead& head) : GmshWalker(file, head, head.nodes) {}
  NodeWalker(const FormatFile& file, const GmshHead& head, const GmshNodePlace& place)
      : GmshWalker(file, head, head.nodes, place) {}

  // Goes to the next node of version 4, over the heads of blocks. `numbers` gets the numbers that
  // come before the nodes themselves.
  // `done`: nodes before.
  void find_node(std::uint64_t done, NumberRun* numbers) {
    if (!head_.is_4) return;
    while (place_.left == 0) {
      if (place_.blocks == 0) {
        in_.fail("expected " + format_count(head_.node_count, "node") + ", found " +
                 format_count(done));
      }
      begin_block(numbers);
      if (place_.left > head_.node_count - done) {
        in_.fail("there are more nodes than the " + format_count(head_.node_count) + " announced");
      }
    }
  }
  // Nodes may not follow the last one; empty blocks may.
  void end(NumberRun* numbers) {
    while (head_.is_4 && place_.blocks > 0) {
      begin_block(numbers);
      if (place_.left > 0) {
        in_.fail("there are more nodes than the " + format_count(head_.node_count) + " announced");
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
    const int dimension = head_.read_entity(&in_).first;
    const bool parametric = in_.integer() != 0;
    place_.more = parametric ? static_cast<std::uint64_t>(dimension) : 0;
    const std::uint64_t values = 3 + place_.more;
    place_.left = in_.rows(in_.size(), 8 + 8 * values, 1 + values);
    --place_.blocks;
    if (!head_.layout.numbers_first) return;
    if (numbers == nullptr) return in_.skip_numbers(place_.left, 8);
    for (std::uint64_t i = 0; i < place_.left; ++i) numbers->add(in_.size());
  }

  void take_number(NumberRun* numbers) {
    if (head_.is_4) --place_.left;
    if (head_.layout.numbers_first) return;
    const char* const at = in_.at();
    const std::int64_t number = in_.integer();
    if (number < 0) in_.fail_at(at, "a node has the number " + std::to_string(number));
    if (numbers != nullptr) numbers->add(static_cast<std::uint64_t>(number));
  }
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
NumberMap map_numbers(Index index) {
  const NumberRun run = index(nullptr);
  if (run.ascends()) return NumberMap::ascending(run.first(), run.count());
  Vector<std::uint64_t> numbers;
  numbers.reserve(run.count());
  index(&numbers);
  return NumberMap(numbers);
}

}  // namespace

GmshMesh::GmshMesh(const FormatFile& file, const GmshHead& head) : file_(file), head_(head) {
  nodes_ = map_numbers([&](Vector<std::uint64_t>* all) {
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
  // Of versions 1 and 2 all are taken together until it is known that none needs it.
  repeats_ = !head.is_4;
  index_elements();
  repeats_ = repeats_ && element_count_ < head.element_count;
  if (repeats_) count_groups();
}

void GmshMesh::index_elements() {
  const bool wanted = !head_.element_data.empty();
  elements_ = map_numbers([&](Vector<std::uint64_t>* all) {
    element_places_.clear();
    types_ = {};
    NumberRun numbers(all);
    Vector<std::uint64_t> passed;
    GmshElements elements(file_, head_, {repeats_, false}, wanted ? &passed : nullptr);
    Releaser releaser(file_, head_.elements.data());
    GmshElement element;
    GmshElementPlace place = elements.place();
    for (element_count_ = 0; elements.next(&element); ++element_count_) {
      if (element_count_ % kRowsPerPlace == 0) {
        element_places_.push_back(place);
        releaser.passed(place.at);
      }
      ++types_[element.type.vtk];
      numbers.add(wanted ? element.number : element_count_);
      place = elements.place();
    }
    has_partitions_ = elements.has_partitions();
    // These come last, so that values for them are known as such.
    for (const std::uint64_t number : passed) numbers.add(number);
    return numbers;
  });
  file_.release(head_.elements);
}

void GmshMesh::count_groups() {
  GmshElements elements(file_, head_, {true, false}, nullptr);
  Releaser releaser(file_, head_.elements.data());
  GmshElement element;
  for (std::uint64_t i = 0; elements.next(&element); ++i) {
    groups_.add(element.dimension(), elements.groups(), 1);
    if (i % kRowsPerPlace == 0) releaser.passed(elements.cursor().at());
  }
  file_.release(head_.elements);
}

void find_dimensions(const FormatFile& file, const GmshHead& head, GmshDimensions* of_tags) {
  GmshElements elements(file, head, {}, nullptr);
  Releaser releaser(file, head.elements.data());
  GmshElement element;
  while (elements.next(&element)) {
    const auto found = of_tags->find(element.physical);
    if (found != of_tags->end()) found->second.set(static_cast<std::size_t>(element.dimension()));
    releaser.passed(elements.cursor().at());
  }
  file.release(head.elements);
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

// Calls f(p, i, element, elements) for a range of elements: for those of one place p in order.
template <class F>
void GmshMesh::walk_elements(std::uint64_t first, std::uint64_t count, bool corners, F f) const {
  for_each_place(first, count, [&](std::uint64_t p, std::uint64_t begin, std::uint64_t end) {
    const GmshElementPlace& place = element_places_[p];
    GmshElements elements(file_, head_, {repeats_, corners}, place);
    GmshElement element;
    for (std::uint64_t i = p * kRowsPerPlace; i < end; ++i) {
      elements.next(&element);
      if (i >= begin) f(p, i, element, elements);
    }
    file_.release(place.at, elements.cursor().at());
  });
}

ListedCells GmshMesh::read_cells(std::uint64_t first, std::uint64_t count) const {
  ListedCells cells;
  cells.types.resize(count);
  const std::uint64_t first_place = first / kRowsPerPlace;
  std::vector<Vector<VertexId>> ids(block_count(first + count, kRowsPerPlace) - first_place);
  walk_elements(
      first, count, true,
      [&](std::uint64_t p, std::uint64_t i, const GmshElement& e, const GmshElements& elements) {
        cells.types[i - first] = e.type.vtk;
        std::array<VertexId, 8> found{};
        elements.find_corners(e, nodes_, found.data());
        Vector<VertexId>& to = ids[p - first_place];
        to.insert(to.end(), found.data(), found.data() + corners_of(e.type.vtk));
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
  walk_elements(
      first, count, false,
      [&](std::uint64_t, std::uint64_t i, const GmshElement& e, const GmshElements& elements) {
        const bool is_repeated = physical && elements.groups().size() > 1;
        const std::int32_t group =
            is_repeated
                ? static_cast<std::int32_t>(groups_.choose(e.dimension(), elements.groups()))
                : e.physical;
        out[i - first] = physical ? group : e.geometrical;
      });
}

}  // namespace tetfusion
