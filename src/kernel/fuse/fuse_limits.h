// What a round of fuse may do, and what it did.
#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "kernel/costs.h"
#include "kernel/criteria.h"
#include "kernel/paper_bounds.h"
#include "kernel/sheets/facing_grid.h"
#include "kernel/sheets/feature_angle.h"

namespace tetfusion {

enum class Method : std::uint8_t {
  kTetFuse,  // the paper's: the four vertices of a tetrahedron become one
  kFuse,     // neighbours become one, cheapest first
};

// A column of weights, finite and >= 0: errors are multiplied by them, costs by their squares. Of
// cells a vertex has the largest one round it. kNoColumn: all count alike.
struct WeightColumn {
  std::uint32_t column = kNoColumn;
  bool of_cells = false;
  double scale = 1;                       // what rows are multiplied by
  static constexpr float kLeast = 1e-6F;  // and no less counts then
};

// Tetrahedra round an edge inside: so many go at least.
inline constexpr std::uint64_t kSmallestFusion = 3;

struct FuseLimits {
  // No fusion costs more: the mean of the squared deviations, as shares of the fields' ranges, of
  // the fused vertex's fields from those of the original mesh that it stands for. A fusion is put
  // off, too, if eight times the squared error of the new fields at a vertex that goes is beyond
  // it, and at least eight times what that is in the mean of this round's fusions (FuseValues).
  double threshold = std::numeric_limits<double>::infinity();
  // No affected tetrahedron has a lower mean ratio, or than the worst grade of its cavity allows
  // (shape_grades.h); in [0, 1).
  double min_quality = 0;
  // No steering field deviates by more at a point of the original mesh, as a share of its range,
  // unless it has a tolerance of its own.
  double max_error = std::numeric_limits<double>::infinity();
  // Nor does one that has a bound deviate by more than this, in this round.
  double error_now = std::numeric_limits<double>::infinity();
  PaperLimits paper;            // of single fusions; stretch is against the start of the round
  bool keep_integrals = false;  // of all floating-point fields but regions (field_integrals.h)
  // Added to the quadrics before the round begins, in squared shares of ranges a squared unit. For
  // a mesh in which nothing has fused yet.
  double gradient_variance = 0;
  double unit = 1;  // of lengths, as in begin_quadrics(): about 1 / the mesh's diagonal
  // All places are tried, however seldom anything comes of some. For a mesh that hardly shrinks.
  bool thorough = false;
  // At most so many tetrahedra may go.
  std::uint64_t quota = std::numeric_limits<std::uint64_t>::max();

  // So far, in the unit, may sheets (sheets.h) move in all; negative: they stay as they are. The
  // mesh has deviations if they may.
  double max_deviation = -1;
  // So far has one moved at most when the round begins.
  double deviation_before = 0;
  double sheet_weight = 0;               // as in EdgeCosts::begin()
  double feature_angle = kFeatureAngle;  // as in Sheets::begin()
  std::vector<std::uint32_t> regions;    // cell columns: sheets lie where their values differ
  WeightColumn weights;
  // Ways the boundary looks at the beginning of the round: no part of it rises where another part
  // that faces it may be in reach, unless all that are there are this mesh's own, and lie
  // elsewhere. Null: there is none.
  const FacingGrid* facing = nullptr;
  // To be filled in; and whether the boundary's marks are known of vertices on the interface.
  FacingGrid* facing_after = nullptr;
  bool marks_are_known = true;
  // Sheets that may move do not in this round, as nobody knows yet which ways the boundary looks.
  bool sheets_rest = false;
  bool sheets_move() const { return max_deviation >= 0; }
};

struct FuseStatistics {
  PassStatistics pass;    // `rejected` counts the vertices that are left, by why
  CostHistogram costs{};  // of those vertices that may fuse, as far as is known
  float deviation = 0;    // the largest of a vertex that is left, in the unit
};

}  // namespace tetfusion
