#include "kernel/sheets/sheet_patch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace tetfusion {

namespace {

double length(const Point3& d) { return std::sqrt(dot(d, d)); }

// The triangles round a centre to a part of its ring.
void add_round(const Point3& centre, std::span<const Point3> ring, PatchChange* out) {
  for (std::size_t i = 0; i + 1 < ring.size(); ++i) {
    out->triangles.push_back({centre, ring[i], ring[i + 1]});
  }
  for (const Point3& p : ring) {
    const bool is_shared = !out->chain.empty() && out->chain.back() == p;
    if (!is_shared) out->chain.push_back(p);
    out->edges.push_back({centre, p});
  }
}

// The triangle at the edge of the two, with its third corner.
void add_cut(const SheetPair& pair, const MovedLine& line, LineSide side, const Point3& corner,
             PatchChange* out) {
  const bool left = side == LineSide::kLeft;
  if (pair.partner_stays()) {  // the new vertex is the partner
    out->triangles.push_back(left ? Triangle3{line.near_v, line.position, corner}
                                  : Triangle3{line.near_v, corner, line.position});
    return;
  }
  const auto add = [&](const Point3& from, const Point3& to) {
    const Point3 d = minus(to, from);
    if (dot(d, d) == 0) return;  // the new vertex is one of the two
    out->triangles.push_back({from, to, corner});
  };
  add(left ? line.near_v : line.near_partner, line.position);
  add(line.position, left ? line.near_partner : line.near_v);
  out->edges.push_back({line.position, corner});
}

}  // namespace

MovedLine move_line(const SheetPair& pair, const Point3& position) {
  MovedLine line;
  line.position = position;
  line.near_v = nearest_on_segment({}, pair.ring[pair.end], position);
  if (!pair.partner_stays()) {
    line.near_partner =
        nearest_on_segment(pair.partner(), position, pair.partner_ring[pair.partner_end]);
  }
  return line;
}

double distance_of(const SheetPair& pair, const MovedLine& line) {
  const double of_v = length(line.near_v);
  if (pair.partner_stays()) return of_v;
  const Point3& partner = pair.partner();
  return std::max({of_v, length(minus(line.near_partner, partner)),
                   length(minus(line.position, nearest_on_segment(line.position, {}, partner)))});
}

void collect_disc(const SheetPair& pair, const Point3& position, PatchChange* out) {
  out->clear();
  out->apex = position;
  out->closed = !pair.partner_stays();
  const auto& [ring, partner_ring, end, partner_end] = pair;
  const std::size_t n = ring.size(), m = partner_ring.size();
  for (std::size_t i = 0; i < n; ++i) {
    out->triangles.push_back({Point3{}, ring[i], ring[(i + 1) % n]});
    out->edges.push_back({Point3{}, ring[i]});
  }
  out->points.push_back({});
  out->chain.insert(out->chain.end(), ring.begin() + 1, ring.end());
  if (pair.partner_stays()) return;
  const Point3& partner = pair.partner();
  // Its ring begins with v, then comes what v's ring ends with.
  for (std::size_t i = 1; i + 1 < m; ++i) {
    out->triangles.push_back({partner, partner_ring[i], partner_ring[i + 1]});
  }
  for (std::size_t i = 1; i < m; ++i) {
    out->edges.push_back({partner, partner_ring[i]});
    if (i > 1 && i + 1 < m) out->chain.push_back(partner_ring[i]);
  }
  out->points.push_back(partner);
}

void collect_side(const SheetPair& pair, const MovedLine& line, LineSide side, PatchChange* out) {
  out->clear();
  out->apex = line.position;
  out->closed = false;
  const auto& [ring, partner_ring, end, partner_end] = pair;
  const bool both = !pair.partner_stays();
  if (side == LineSide::kLeft) {
    if (both) add_round(line.near_partner, std::span(partner_ring).subspan(partner_end), out);
    add_cut(pair, line, side, ring[1], out);
    add_round(line.near_v, std::span(ring).subspan(1, end), out);
  } else {
    add_cut(pair, line, side, ring.back(), out);
    add_round(line.near_v, std::span(ring).subspan(end), out);
    if (both) add_round(line.near_partner, std::span(partner_ring).subspan(1, partner_end), out);
  }
}

void collect_old_side(const SheetPair& pair, LineSide side, std::vector<Triangle3>* out) {
  out->clear();
  const auto add = [&](const Point3& centre, const std::vector<Point3>& ring, std::size_t first,
                       std::size_t last) {
    for (std::size_t i = first; i < last; ++i) {
      out->push_back({centre, ring[i], ring[(i + 1) % ring.size()]});
    }
  };
  const auto& [ring, partner_ring, end, partner_end] = pair;
  const bool left = side == LineSide::kLeft;
  add({}, ring, left ? 0 : end, left ? end : ring.size());
  if (pair.partner_stays()) return;
  // Those at the edge of the two are there already.
  add(pair.partner(), partner_ring, left ? partner_end : 1,
      left ? partner_ring.size() - 1 : partner_end);
}

}  // namespace tetfusion
