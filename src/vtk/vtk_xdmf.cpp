// XDMF: a text that says which arrays of other files are grids, and at which times.

#include <vtkNew.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "base/numbers.h"
#include "vtk/vtk_collect.h"
#include "vtk/vtk_reader.h"
#include "vtk/xdmf_document.h"
#include "vtk/xdmf_grid.h"
#include "vtk/xdmf_items.h"

namespace tetfusion {
namespace {

constexpr int kDeepestGrid = 32;
constexpr int kMostGrids = 1 << 20;  // where grids hold others twice at each level

enum class GridKind { kUniform, kTemporal, kOther };

// Grids of which each is there at a time of its own.
struct TimeLine {
  std::string name;
  std::vector<double> times;
  std::vector<pugi::xml_node> grids;

  // The last one whose time has come; nothing before the first.
  std::optional<std::size_t> step_at(double time) const {
    std::optional<std::size_t> step;
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (times[i] <= time && (!step || times[i] >= times[*step])) step = i;
    }
    return step;
  }
};

// What grids beside one another are: time lines, and grids that are always there.
struct GridsBeside {
  std::vector<TimeLine> lines;
  std::vector<pugi::xml_node> always;
};

class XdmfReader : public FileReader {
 public:
  explicit XdmfReader(const std::string& path) : document_(path), items_(document_) {
    find_lines(document_.domain(), 0);
    merge_times();
  }

  std::vector<double> time_steps() override { return times_; }

  void load(std::size_t step, LoadedFile* out) override {
    step_ = step;
    XdmfGrids grids(document_, &items_);
    add_grids(document_.domain(), &grids, 0);
    out->format = "XDMF file";
    const std::vector<XdmfBlock> blocks = grids.blocks();
    if (blocks.empty()) document_.fail(document_.domain(), "has no grids");
    for (const XdmfBlock& block : blocks) {
      add_block(block.grid, block.name, document_.path(), out);
    }
    mark_blocks(out);
    out->field_data.emplace_back(grids.field_data());
    out->files = document_.included_files();
    out->files.insert(out->files.end(), items_.files().begin(), items_.files().end());
    out->left_out = grids.left_out();
    for (const std::string& name : document_.other_domains()) {
      out->left_out.push_back("domain '" + name + "'");
    }
  }

 private:
  GridKind kind_of(pugi::xml_node grid) const {
    const std::string type = xdmf_attribute(grid, {"GridType", "Type"});
    if (type.empty() || is_xdmf_word(type, "Uniform")) return GridKind::kUniform;
    if (is_xdmf_word(type, "Tree")) return GridKind::kOther;
    if (!is_xdmf_word(type, "Collection")) {
      document_.fail(grid, "is of GridType " + type +
                               ", which is not read: let ParaView save the file as .vtu");
    }
    const bool is_temporal = is_xdmf_word(xdmf_attribute(grid, {"CollectionType"}), "Temporal");
    return is_temporal ? GridKind::kTemporal : GridKind::kOther;
  }

  // SeisSol writes a collection for each step, all of one name. Where times begin again the grids
  // are another part of the mesh. Grids that are no collections and have different times are steps,
  // too.
  GridsBeside sorted(pugi::xml_node parent) {
    GridsBeside out;
    TimeLine by_time;
    for (const pugi::xml_node grid : document_.children(parent, "Grid")) {
      count_visit(grid);
      const GridKind kind = kind_of(grid);
      if (kind != GridKind::kTemporal) {
        out.always.push_back(grid);
        if (const auto time = time_of(grid)) by_time.times.push_back(*time);
        continue;
      }
      const std::string name = xdmf_attribute(grid, {"Name"});
      const std::optional<double> first = first_time(grid);
      auto line = std::find_if(out.lines.begin(), out.lines.end(), [&](const TimeLine& known) {
        return known.name == name && (!first || known.times.empty() || known.times.back() < *first);
      });
      if (line == out.lines.end()) line = out.lines.insert(line, TimeLine{name, {}, {}});
      add_steps(grid, &*line);
    }
    const std::vector<double>& times = by_time.times;
    const bool differ =
        std::adjacent_find(times.begin(), times.end(), std::not_equal_to<>()) != times.end();
    if (out.lines.empty() && times.size() == out.always.size() && differ) {
      by_time.grids = std::move(out.always);
      out.always.clear();
      out.lines.push_back(std::move(by_time));
    }
    return out;
  }

  // If it says any.
  std::optional<double> first_time(pugi::xml_node collection) {
    const std::vector<pugi::xml_node> grids = document_.children(collection, "Grid");
    if (grids.empty()) return {};
    if (const auto own = time_of(grids[0])) return own;
    const std::vector<double> listed = times_of(collection, grids.size());
    return listed.empty() ? std::nullopt : std::optional(listed[0]);
  }

  // Their times are those of the grids, or of the collection, or their numbers.
  void add_steps(pugi::xml_node collection, TimeLine* line) {
    const std::vector<pugi::xml_node> grids = document_.children(collection, "Grid");
    std::vector<double> listed = times_of(collection, grids.size());
    for (std::size_t i = 0; i < grids.size(); ++i) {
      const auto own = time_of(grids[i]);
      const double number = static_cast<double>(line->times.size());
      line->times.push_back(own ? *own : i < listed.size() ? listed[i] : number);
      line->grids.push_back(grids[i]);
    }
  }

  std::optional<double> time_of(pugi::xml_node grid) const {
    const pugi::xml_node time = XdmfDocument::own_child(grid, "Time");
    const std::string text = xdmf_attribute(time, {"Value"});
    if (text.empty()) return {};
    const auto value = number_in<double>(trimmed(text));
    if (!value || !std::isfinite(*value)) {
      document_.fail(time, "has the Value '" + text + "', which is no number");
    }
    return value;
  }

  std::vector<double> times_of(pugi::xml_node collection, std::size_t steps) {
    const pugi::xml_node time = XdmfDocument::own_child(collection, "Time");
    const pugi::xml_node item = document_.child(time, "DataItem");
    if (!item) return {};
    std::vector<double> times = items_.read_doubles(item);
    const std::string type = xdmf_attribute(time, {"TimeType", "Type"});
    if (is_xdmf_word(type, "HyperSlab")) {
      if (times.size() < 2) document_.fail(time, "has no start and step");
      const double start = times[0];
      const double step = times[1];
      times.clear();
      for (std::size_t i = 0; i < steps; ++i) {
        times.push_back(start + static_cast<double>(i) * step);
      }
    } else if (!type.empty() && !is_xdmf_word(type, "List")) {
      times.clear();  // a range says nothing of each grid
    }
    if (times.size() != steps && !times.empty()) {
      document_.fail(time, "has " + std::to_string(times.size()) + " times for " +
                               std::to_string(steps) + " grids");
    }
    return times;
  }

  void count_visit(pugi::xml_node grid) {
    if (++visits_ > kMostGrids) document_.fail(grid, "is one of grids without end");
  }

  void check_depth(pugi::xml_node grid, int depth) const {
    if (depth > kDeepestGrid) document_.fail(grid, "has grids in grids without end");
  }

  void find_lines(pugi::xml_node parent, int depth) {
    check_depth(parent, depth);
    GridsBeside grids = sorted(parent);
    for (TimeLine& line : grids.lines) lines_.push_back(std::move(line));
    for (const pugi::xml_node grid : grids.always) {
      if (kind_of(grid) == GridKind::kOther) find_lines(grid, depth + 1);
    }
  }

  // Where not all have the same times all that any one has.
  void merge_times() {
    const auto is_same = [&](const TimeLine& line) { return line.times == lines_[0].times; };
    are_alike_ = std::all_of(lines_.begin(), lines_.end(), is_same);
    if (lines_.empty()) {
      const std::vector<pugi::xml_node> grids = document_.children(document_.domain(), "Grid");
      const auto time = grids.empty() ? std::nullopt : time_of(grids[0]);
      if (time) times_ = {*time};
      return;
    }
    times_ = lines_[0].times;
    if (are_alike_) return;
    for (const TimeLine& line : lines_) {
      times_.insert(times_.end(), line.times.begin(), line.times.end());
    }
    std::sort(times_.begin(), times_.end());
    times_.erase(std::unique(times_.begin(), times_.end()), times_.end());
  }

  void add_grids(pugi::xml_node parent, XdmfGrids* out, int depth) {
    check_depth(parent, depth);
    const GridsBeside grids = sorted(parent);
    for (const pugi::xml_node grid : grids.always) {
      add_grid(grid, xdmf_attribute(grid, {"Name"}), out, depth);
    }
    for (const TimeLine& line : grids.lines) {
      const auto step = are_alike_ ? std::optional(step_) : line.step_at(times_.at(step_));
      if (step) add_grid_at_time(line.grids.at(*step), line.name, out, depth);
    }
  }

  void add_grid(pugi::xml_node grid, const std::string& name, XdmfGrids* out, int depth) {
    if (kind_of(grid) == GridKind::kUniform) return out->add(grid, name);
    out->add_own_arrays(grid);
    add_grids(grid, out, depth + 1);
  }

  // Those of a step are one, or several beside one another.
  void add_grid_at_time(pugi::xml_node grid, const std::string& name, XdmfGrids* out, int depth) {
    check_depth(grid, depth);
    if (kind_of(grid) == GridKind::kTemporal) {
      document_.fail(grid, "is a temporal collection inside of one, which is not read");
    }
    if (kind_of(grid) == GridKind::kUniform) return out->add(grid, name);
    out->add_own_arrays(grid);
    for (const pugi::xml_node part : document_.children(grid, "Grid")) {
      count_visit(part);
      add_grid_at_time(part, xdmf_attribute(part, {"Name"}), out, depth + 1);
    }
  }

  XdmfDocument document_;
  XdmfItems items_;
  std::vector<TimeLine> lines_;
  std::vector<double> times_;
  bool are_alike_ = true;
  int visits_ = 0;
  std::size_t step_ = 0;
};

}  // namespace

std::unique_ptr<FileReader> open_xdmf(const std::string& path) {
  return std::make_unique<XdmfReader>(path);
}

}  // namespace tetfusion
