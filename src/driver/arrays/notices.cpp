#include "driver/arrays/notices.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <functional>
#include <set>
#include <string_view>
#include <utility>

#include "base/name_list.h"
#include "base/numbers.h"
#include "base/vector.h"
#include "io/gmsh/gmsh_head.h"
#include "io/source/stream_windows.h"
#include "mesh/array_names.h"
#include "mesh/regions/region_names.h"

namespace tetfusion {

namespace {

constexpr std::size_t kMostNames = 5;

// As a shell takes it for one word.
std::string in_a_shell(const std::string& name) {
  const auto is_plain = [](unsigned char c) {
    return std::isalnum(c) != 0 || std::string_view("_-.:/+,@%").find(c) != std::string_view::npos;
  };
  if (!name.empty() && std::all_of(name.begin(), name.end(), is_plain)) return name;
  std::string quoted = "'";
  for (const char c : name) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

// Of floating-point numbers, as --array takes their names, but for those that steer or say regions.
std::vector<std::string> fields_beside(const std::vector<std::string>& others,
                                       const MeshDescription& mesh) {
  std::vector<std::string> fields;
  const auto add = [&](const AttributeSet& set, std::string_view prefix) {
    for (const ArrayInfo& array : set.arrays) {
      if (!is_float(array.type) || array.steers_only || is_region_of_floats(array)) continue;
      std::string name = fmt::format("{}{}", prefix, array.name);
      const bool is_other = std::find(others.begin(), others.end(), name) != others.end();
      if (!is_other) fields.push_back(std::move(name));
    }
  };
  add(mesh.point_data, "");
  add(mesh.cell_data, "cell:");
  return fields;
}

// The labels that tetrahedra have, not what lies beside them.
class TetLabels {
 public:
  // So many tetrahedra are in the stream, which outlives this.
  TetLabels(const MeshStream& stream, std::uint64_t tets)
      : stream_(&stream), are_all_cells_(tets == stream.cells()) {}

  // What differs is mostly found soon.
  bool have_several(std::size_t index, const ArrayInfo& info) const {
    std::string first;
    bool differ = false;
    visit(index, info, [&](std::string_view value) {
      if (first.empty()) first = value;
      differ = value != first;
      return !differ;
    });
    return differ;
  }

  // As numbers of cells do: no two of the first ones have the same value.
  bool tell_cells_apart(std::size_t index, const ArrayInfo& info) const {
    constexpr std::size_t kLook = 1000, kTooFew = 10;
    std::set<std::string, std::less<>> different;
    std::size_t seen = 0;
    visit(index, info, [&](std::string_view value) {
      different.emplace(value);
      return ++seen == different.size() && seen < kLook;
    });
    return seen >= kTooFew && different.size() == seen;
  }

 private:
  // The bytes of each one's value, until visit(value) is false.
  template <class Visit>
  void visit(std::size_t index, const ArrayInfo& info, const Visit& visit) const {
    const std::size_t bytes = info.row_bytes();
    CellWindow cells;
    const auto visit_window = [&](std::uint64_t first, std::span<const std::byte> rows) {
      const auto is_enough = [&](std::uint64_t row) {
        return !visit({reinterpret_cast<const char*>(rows.data()) + (row - first) * bytes, bytes});
      };
      std::uint64_t tets = rows.size() / bytes;
      if (!are_all_cells_) {
        stream_->read_cells(first, tets, &cells);
        tets = cells.tets.size();
      }
      for (std::uint64_t i = 0; i < tets; ++i) {
        const bool has_rows = !are_all_cells_ && !cells.tet_rows.empty();
        if (is_enough(has_rows ? cells.tet_rows[i] : first + i)) return false;
      }
      return true;
    };
    for_each_window_of(*stream_, Association::kCell, index, info, RunContext(), visit_window);
  }

  const MeshStream* stream_;
  const bool are_all_cells_;
};

// Integers: two or more that points have, and no more than sets have. What differs is mostly found
// soon, and nothing is read behind the window in which it is.
bool has_few_values(const MeshStream& stream, std::size_t point_array, const ArrayInfo& info) {
  constexpr std::size_t kMost = 32;
  std::set<std::uint64_t> values;
  for_each_window_of(
      stream, Association::kPoint, point_array, info, RunContext(),
      [&](std::uint64_t, std::span<const std::byte> rows) {
        return visit_type(info.type, [&](auto zero) {
          const auto* integers = reinterpret_cast<const decltype(zero)*>(rows.data());
          for (std::size_t i = 0; i < rows.size() / sizeof zero && values.size() <= kMost; ++i) {
            values.insert(static_cast<std::uint64_t>(integers[i]));
          }
          return values.size() < 2;
        });
      });
  return values.size() > 1 && values.size() <= kMost && values.size() < stream.points();
}

// Vectors of length 1, or 0 where there is none, as far as the first window goes.
bool are_directions(const MeshStream& stream, Association association, std::size_t index,
                    const ArrayInfo& info) {
  if (info.components != 3 || !is_float(info.type)) return false;
  constexpr double kRounding = 1e-3;
  bool all = true;
  std::set<std::array<double, 3>> some;
  for_each_window_of(stream, association, index, info, RunContext(),
                     [&](std::uint64_t, std::span<const std::byte> rows) {
                       visit_type(info.type, [&](auto zero) {
                         const auto* values = reinterpret_cast<const decltype(zero)*>(rows.data());
                         for (std::size_t i = 0; i + 3 <= rows.size() / sizeof zero && all;
                              i += 3) {
                           const std::array<double, 3> v{static_cast<double>(values[i]),
                                                         static_cast<double>(values[i + 1]),
                                                         static_cast<double>(values[i + 2])};
                           const double length = std::hypot(v[0], v[1], v[2]);
                           all = length == 0 || std::abs(length - 1) < kRounding;
                           if (length != 0 && some.size() < 2) some.insert(v);
                         }
                       });
                       return false;
                     });
  return all && some.size() > 1;
}

// Entities of Gmsh are what its groups are made of: where there are groups these are what is meant.
bool has_coarser(const MeshDescription& mesh, const TetLabels& labels,
                 const std::vector<std::size_t>& regions, const ArrayInfo& array) {
  if (array.name != kGmshGeometrical) return false;
  return std::any_of(regions.begin(), regions.end(), [&](std::size_t i) {
    const ArrayInfo& region = mesh.cell_data.arrays[i];
    return region.name == kGmshPhysical && labels.have_several(i, region);
  });
}

}  // namespace

void say_does_not_steer(const std::string& name, const RunContext& context) {
  context.say(
      fmt::format("array {} has no two finite values that differ (as doubles): it does not "
                  "steer",
                  name));
}

void say_what_steers(std::vector<std::string> arrays, const MeshDescription& mesh,
                     const std::vector<std::size_t>& regions, const RunContext& context) {
  for (const std::string& name : arrays) {
    context.say(fmt::format("array {} steers (choose others with --array)", name));
  }
  for (const std::size_t i : regions) arrays.push_back("cell:" + mesh.cell_data.arrays[i].name);
  const std::vector<std::string> others = fields_beside(arrays, mesh);
  if (others.empty()) return;
  context.say(
      fmt::format("arrays that follow it, whose errors nothing limits: {} (--array NAME, several "
                  "times, makes them steer, too; 'tetfusion compare' measures them)",
                  list_names(others, kMostNames)));
}

void say_means_steer(const std::string& name, const RunContext& context) {
  context.say(
      fmt::format("array {} steers by its means at the points: bounds are for these", name));
}

std::string what_could_steer(const std::vector<SteeringChoice>& tried,
                             const MeshDescription& mesh) {
  std::vector<std::string> names;
  for (const SteeringChoice& choice : tried) names.push_back(choice.name);
  const std::vector<std::string> fields = fields_beside(names, mesh);
  return fields.empty()
             ? ""
             : fmt::format(" (--array NAME makes one: {})", list_names(fields, kMostNames));
}

Error no_end_in_sight(const std::string& input, const std::vector<SteeringChoice>& tried,
                      const MeshDescription& mesh) {
  const std::string named =
      tried.empty()
          ? ""
          : fmt::format(
                ", or --array {}, which is the same everywhere, to go as far as shapes allow",
                in_a_shell(tried.front().name));
  return {ErrorCode::kUsage,
          fmt::format("{}: no array steers, so nothing but a goal can say when to stop: give "
                      "--reduction or --tets{}{}",
                      input, named, what_could_steer(tried, mesh))};
}

std::string describe_difference(const LargestDifference& largest, const AttributeSet& point_data) {
  if (largest.share == 0) return "";
  const std::string name = largest.array < point_data.arrays.size()
                               ? "array " + point_data.arrays[largest.array].name
                               : "an array";
  return fmt::format("by up to {:.3g} % of the range of {}", 100 * largest.share, name);
}

void say_what_was_joined(const InputFacts& facts, const MeshDescription& mesh,
                         const RunContext& context) {
  if (facts.merged_points > 0) {
    context.say(format_count(facts.merged_points,
                             "point in the place of another one was merged with it",
                             "points in the places of others were merged with them"));
  }
  if (facts.differing_points == 0) return;
  const std::string most = describe_difference(facts.largest_difference, mesh.point_data);
  context.say(fmt::format(
      "{} of these had other values in some array{}: those of the first one that has it were taken",
      format_count(facts.differing_points), most.empty() ? "" : ", " + most));
}

void say_whose_bounds(const RunContext& context) {
  context.say(
      "bounds are for the values that were taken: where points had others, the result is off by as "
      "much as these differ, too");
}

void say_what_is_odd(const InputFacts& facts, const MeshDescription& mesh, bool linearized,
                     const RunContext& context) {
  const auto say = [&](std::uint64_t count, std::string_view one, std::string_view many) {
    if (count > 0) context.say(format_count(count, one, many));
  };
  say(facts.rewound, "tetrahedron was wound the other way: rewound",
      "tetrahedra were wound the other way: rewound");
  say(facts.degenerate, "tetrahedron has no volume: it and its vertices stay as they are",
      "tetrahedra have no volume: they and their vertices stay as they are");
  say(facts.inverted,
      "tetrahedron is inverted: it and its vertices stay where they are, wound like all others",
      "tetrahedra are inverted: they and their vertices stay where they are, wound like all "
      "others");
  say(facts.duplicate_tets,
      "tetrahedron is a duplicate of another one: it and its vertices stay as they are",
      "tetrahedra are duplicates of others: they and their vertices stay as they are");
  say(facts.nonconforming_faces, "face does not conform: its tetrahedra stay as they are",
      "faces do not conform: their tetrahedra stay as they are");
  say(facts.nonmanifold_edges, "boundary edge is not manifold: it stays as it is",
      "boundary edges are not manifold: they stay as they are");
  if (linearized) {
    say(facts.unused_points,
        "point is used by no cell, now that cells have no mid-edge nodes: dropped with its values "
        "(bounds hold at the corners)",
        "points are used by no cell, now that cells have no mid-edge nodes: dropped with their "
        "values (bounds hold at the corners)");
  } else {
    say(facts.unused_points, "point is used by no cell: dropped",
        "points are used by no cell: dropped");
  }
  say_what_was_joined(facts, mesh, context);
  say(facts.ghost_cells, "ghost or hidden cell (vtkGhostType) was dropped",
      "ghost or hidden cells (vtkGhostType) were dropped");
  if (facts.tets > 1 && facts.boundary_faces == 4 * facts.tets) {
    context.say(
        "no two tetrahedra share a face, as each has points of its own: there is nothing to fuse "
        "(--merge-points)");
  }
  say(facts.coincident_points,
      "point lies where another does (a crack, a contact, or points that were not merged): the "
      "boundary stays as it is there",
      "points lie where others do (cracks, contacts, or points that were not merged): the boundary "
      "stays as it is there");
  say(facts.carried_triangles,
      "triangle is a cell of the file: it stays, and the boundary with it (where its patch does "
      "not matter: --drop-patches, or --drop-patch NAME)",
      "triangles are cells of the file: they stay, and the boundary with them (where their patches "
      "do not matter: --drop-patches, or --drop-patch NAME for one)");
}

// As --regions wants it.
static std::string as_option(const std::string& name) {
  return name == "none" ? "cell:none" : in_a_shell(name);
}

void say_which_are_regions(const MeshDescription& mesh, const MeshStream& stream,
                           std::uint64_t tets, const std::vector<std::size_t>& regions,
                           bool by_name, const RunContext& context) {
  const auto& arrays = mesh.cell_data.arrays;
  const TetLabels labels(stream, tets);
  std::string taken;  // as options: names take the place of the default
  for (const std::size_t i : regions) {
    if (!labels.have_several(i, arrays[i])) continue;
    context.say(fmt::format("interfaces of cell array {} are kept ({})", arrays[i].name,
                            may_be_partition(arrays[i])
                                ? "if it is a partition of a parallel run: --regions none"
                                : "--regions none switches that off"));
    taken += fmt::format("--regions {} ", as_option(arrays[i].name));
  }
  if (by_name) return;
  std::vector<std::string> others;
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const ArrayInfo& array = arrays[i];
    if (is_region_of_floats(array) && labels.have_several(i, array)) {
      context.say(fmt::format(
          "cell array {} has floating-point numbers, and may be a field: its interfaces are not "
          "kept (if its values say regions, {}--regions {} keeps them)",
          array.name, taken, as_option(array.name)));
    }
    if (may_be_region(array) && !has_coarser(mesh, labels, regions, array) &&
        labels.have_several(i, array) && !labels.tell_cells_apart(i, array)) {
      others.push_back(array.name);
    }
  }
  if (others.size() == 1) {
    context.say(
        fmt::format("cell array {} may be regions, too: its interfaces are not kept ({}--regions "
                    "{} keeps them)",
                    others[0], taken, as_option(others[0])));
  } else if (!others.empty()) {
    context.say(fmt::format(
        "cell arrays {} may be regions, too: their interfaces are not kept ({}--regions NAME keeps "
        "those of one)",
        fmt::join(others, ", "), taken));
  }
}

void say_which_may_be_node_sets(const MeshDescription& mesh, const MeshStream& stream,
                                const std::vector<SteeringChoice>& steering,
                                const RunContext& context) {
  std::vector<std::string> sets;
  for (std::size_t i = 0; i < mesh.point_data.arrays.size(); ++i) {
    const ArrayInfo& array = mesh.point_data.arrays[i];
    const bool steers =
        std::any_of(steering.begin(), steering.end(), [&](const SteeringChoice& choice) {
          return choice.association == Association::kPoint && choice.index == i;
        });
    if (steers || array.steers_only || !is_integer_label(array) || is_ghost_mark(array.name)) {
      continue;
    }
    if (has_few_values(stream, i, array)) sets.push_back(array.name);
  }
  if (sets.empty()) return;
  const bool is_one = sets.size() == 1;
  context.say(fmt::format(
      "point array{} {} may be {}: {} not kept where the surface gets other triangles (on the "
      "surface --boundary exact keeps {})",
      is_one ? "" : "s", list_names(sets, kMostNames), is_one ? "a set of nodes" : "sets of nodes",
      is_one ? "its border is" : "their borders are", is_one ? "it" : "them"));
}

void say_which_are_directions(const MeshDescription& mesh, const MeshStream& stream,
                              const RunContext& context) {
  std::vector<std::string> names;
  const auto look = [&](const AttributeSet& set, Association association) {
    for (std::size_t i = 0; i < set.arrays.size(); ++i) {
      const ArrayInfo& array = set.arrays[i];
      if (!array.steers_only && are_directions(stream, association, i, array)) {
        names.push_back((association == Association::kCell ? "cell:" : "") + array.name);
      }
    }
  };
  look(mesh.point_data, Association::kPoint);
  look(mesh.cell_data, Association::kCell);
  if (names.empty()) return;
  context.say(
      fmt::format("{}: vectors of length 1 alone, it seems. New values are means, which are "
                  "shorter: scale them again; axes, whose sign means nothing, have no mean",
                  list_names(names, kMostNames)));
}

}  // namespace tetfusion
