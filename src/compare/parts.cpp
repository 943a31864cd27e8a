#include "compare/parts.h"

#include <cmath>

#include "base/blocks.h"
#include "compare/hilbert_curve.h"
#include "compare/sorted_by_key.h"
#include "mesh/box_tree.h"
#include "mesh/predicates.h"

namespace tetfusion {

namespace {

constexpr std::size_t kTetsToJoin = 8192;

// Lengths, in a unit in which all of them are small.
struct Signature {
  Point low, high, centre;
  double size;
};

class Units {
 public:
  explicit Units(const PointBox& box) : origin_(box.centre()) {
    const double extent = largest_part(box.extent());
    unit_ = extent > 0 && std::isfinite(1 / extent) ? 1 / extent : 1;
  }

  Signature signature_of(const PartFigures& part) const {
    const Point middle = part.box.centre();
    const Point centre = (1 / part.volume) * part.moment;
    const bool is_known = std::isfinite(centre.x) && std::isfinite(centre.y) &&
                          std::isfinite(centre.z) && part.volume > 0;
    return {at(part.box.low), at(part.box.high), at(is_known ? centre : middle),
            is_known ? unit_ * std::cbrt(part.volume) : 0};
  }

 private:
  Point at(const Point& p) const { return unit_ * (p - origin_); }

  Point origin_;
  double unit_ = 1;
};

double squared_difference(const Signature& a, const Signature& b) {
  const auto squared = [](const Point& d) { return dot(d, d); };
  return squared(a.low - b.low) + squared(a.high - b.high) + squared(a.centre - b.centre) +
         (a.size - b.size) * (a.size - b.size);
}

// Along a curve, so that a tree over them has small boxes.
Vector<std::uint32_t> order_of(const Vector<Signature>& all) {
  PointBox box;
  for (const Signature& s : all) box.add(s.centre);
  const HilbertCurve curve(box);
  Vector<std::uint32_t> keys(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) keys[i] = curve.key(all[i].centre);
  return sorted_by_key(keys, curve.key_bits());
}

}  // namespace

void PartFigures::add(const Corners& corners) {
  for (const Point& p : corners) box.add(p);
  const double size = std::abs(determinant(corners[0], corners[1], corners[2], corners[3]).value);
  volume += size / 6;
  moment = moment + (size / 24) * ((corners[0] + corners[1]) + (corners[2] + corners[3]));
}

Vector<std::uint32_t> find_counterparts(std::span<const PartFigures> from,
                                        std::span<const PartFigures> to) {
  if (from.size() != to.size() || to.size() < 2) return {};
  PointBox box;
  for (const PartFigures& part : to) box.add(part.box);
  const Units units(box);
  Vector<Signature> signatures(to.size());
  for (std::size_t i = 0; i < to.size(); ++i) signatures[i] = units.signature_of(to[i]);
  const Vector<std::uint32_t> order = order_of(signatures);
  BoxTree tree;
  tree.build(to.size(), {}, [&](std::size_t i) {
    PointBox at;
    at.add(signatures[order[i]].centre);
    return at;
  });
  Vector<std::uint32_t> match(from.size()), times;
  times.assign(to.size(), 0);
  for (std::size_t i = 0; i < from.size(); ++i) {
    const Signature wanted = units.signature_of(from[i]);
    double squared = std::numeric_limits<double>::infinity();
    match[i] = 0;
    tree.find_nearest(wanted.centre, &squared, [&](std::uint32_t item) {
      const double found = squared_difference(wanted, signatures[order[item]]);
      if (found < squared) match[i] = order[item];
      return found;
    });
    ++times[match[i]];
  }
  for (std::uint32_t& part : match) {
    if (times[part] > 1) part = kAnyPart;
  }
  return match;
}

void PartFinder::add(std::span<const Tet> tets) {
  for_each_block(tets.size(), kTetsToJoin, [&](std::size_t, std::size_t begin, std::size_t end) {
    for (std::size_t t = begin; t < end; ++t) {
      for (std::size_t k = 1; k < 4; ++k) sets_.unite(tets[t][0], tets[t][k]);
    }
  });
}

}  // namespace tetfusion
