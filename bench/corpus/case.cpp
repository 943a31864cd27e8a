#include "case.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "numbers.h"
#include "shapes.h"

namespace corpus {

namespace {

struct Place {
  const char* name;
  double scale, offset;
  bool floats;
  Point stretch;
};

const std::vector<Place>& places() {
  constexpr Point kRound{1, 1, 1};
  static const std::vector<Place> kPlaces{{"double", 1, 0, false, kRound},
                                          {"float", 1, 0, true, kRound},
                                          {"far", 1, 1e5, false, kRound},
                                          {"far, float", 1, 1e5, true, kRound},
                                          {"very far, float", 1, 1e7, true, kRound},
                                          {"huge, float", 1e30, 0, true, kRound},
                                          {"tiny, float", 1e-30, 0, true, kRound},
                                          {"huge", 1e90, 0, false, kRound},
                                          {"tiny", 1e-90, 0, false, kRound},
                                          {"flat", 1, 0, false, {1, 1, 1e-6}},
                                          {"flat, float", 1, 0, true, {1, 1e-5, 1}},
                                          {"needle", 1, 0, false, {1, 1, 1000}},
                                          {"needle, float", 1, 0, true, {1e4, 1, 1}},
                                          {"scaled by 2^20", 0x1p20, 0, false, kRound},
                                          {"scaled by 2^-20, float", 0x1p-20, 0, true, kRound}};
  return kPlaces;
}

// A rotation by some angles, so that nothing is in line with the axes.
void rotate(Numbers* n, std::vector<Point>* points) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double angle = n->between(0, 6.28), c = std::cos(angle), s = std::sin(angle);
    const std::size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (Point& p : *points) {
      const double x = p[u], y = p[v];
      p[u] = c * x - s * y;
      p[v] = s * x + c * y;
    }
  }
}

void put(Numbers* n, const Place& place, Mesh* mesh) {
  if (n->chance(0.3)) rotate(n, &mesh->points);
  mesh->floats = place.floats;
  for (Point& p : mesh->points) {
    for (std::size_t i = 0; i < 3; ++i) {
      p[i] = p[i] * place.stretch[i] * place.scale + place.offset;
      if (place.floats) p[i] = static_cast<float>(p[i]);
    }
  }
}

void wind_wrongly(Numbers* n, Mesh* mesh) {
  const double share = n->pick(std::vector<double>{0, 0, 1, 0.5});
  for (Tet& t : mesh->tets) {
    if (n->chance(share)) std::swap(t[0], t[1]);
  }
}

void reorder(Numbers* n, Mesh* mesh) {
  std::vector<std::int64_t> order(mesh->points.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::int64_t>(i);
  n->shuffle(&order);
  std::vector<Point> points(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    points[static_cast<std::size_t>(order[i])] = mesh->points[i];
  }
  mesh->points = points;
  for (Tet& t : mesh->tets) {
    for (std::int64_t& v : t) v = order[static_cast<std::size_t>(v)];
  }
  n->shuffle(&mesh->tets);
}

void add_unused(Numbers* n, Mesh* mesh) {
  for (std::size_t i = 1 + n->below(3); i > 0; --i) mesh->points.push_back(n->pick(mesh->points));
}

void add_lower(Numbers* n, Mesh* mesh) {
  for (std::size_t i = 1 + n->below(8); i > 0; --i) {
    const Tet& t = n->pick(mesh->tets);
    const std::size_t corners = 1 + n->below(3);
    constexpr std::array<int, 4> kTypes{0, 1, 3, 5};
    mesh->lower.push_back(
        {kTypes[corners], {t.begin(), t.begin() + static_cast<std::ptrdiff_t>(corners)}});
  }
}

template <class T, class F>
std::vector<T> filled(std::size_t count, F value) {
  std::vector<T> values(count);
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<T>(value(i));
  return values;
}

// A field over the mesh with values of about 1.
std::vector<double> wave(Numbers* n, const Mesh& mesh) {
  Point low = mesh.points[0], high = mesh.points[0];
  for (const Point& p : mesh.points) {
    for (std::size_t i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], p[i]);
      high[i] = std::max(high[i], p[i]);
    }
  }
  const double steep = n->between(1, 9);
  return filled<double>(mesh.points.size(), [&](std::size_t v) {
    double sum = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const double width = high[i] - low[i];
      if (width > 0) sum += kSlope[i] * (mesh.points[v][i] - low[i]) / width;
    }
    return std::sin(steep * sum);
  });
}

void add_point_arrays(Numbers* n, Mesh* mesh) {
  const std::size_t points = mesh->points.size();
  std::vector<Array>& arrays = mesh->point_arrays;
  const std::vector<double> values = wave(n, *mesh);
  const double scale = n->pick(std::vector<double>{1, 1, 1e-20, 1e20, 1e-7});
  const auto scaled = filled<double>(points, [&](std::size_t i) { return scale * values[i]; });
  const auto single = filled<float>(points, [&](std::size_t i) { return values[i]; });
  arrays.push_back(n->chance(0.5) ? make_array("wave", "Float64", 1, scaled)
                                  : make_array("wave", "Float32", 1, single));
  if (n->chance(0.15)) {
    const double odd[] = {std::numeric_limits<double>::quiet_NaN(),
                          std::numeric_limits<double>::infinity(),
                          -std::numeric_limits<double>::infinity()};
    auto holes = single;
    const double share = n->pick(std::vector<double>{0.01, 0.2, 1});
    for (float& h : holes) {
      if (n->chance(share)) h = static_cast<float>(odd[n->below(3)]);
    }
    arrays.insert(arrays.begin(), make_array("holes", "Float32", 1, holes));
  }
  if (n->chance(0.2)) {
    arrays.insert(arrays.begin(),
                  make_array("vector", "Float64", 3, filled<double>(3 * points, [&](std::size_t i) {
                               return values[i / 3] * static_cast<double>(1 + i % 3);
                             })));
  }
  arrays.push_back(make_array(kPointNumber, "Int32", 1,
                              filled<std::int32_t>(points, [](std::size_t i) { return i; })));
  arrays.push_back(make_array(kLinear, "Float64", 1, filled<double>(points, [&](std::size_t v) {
                                const Point& p = mesh->points[v];
                                return kSlope[0] * p[0] + kSlope[1] * p[1] + kSlope[2] * p[2] +
                                       kOffset;
                              })));
  arrays.push_back(make_array("noise", "Float32", 2, filled<float>(2 * points, [&](std::size_t) {
                                return n->between(-1, 1);
                              })));
  arrays.push_back(
      make_array("bytes", "UInt8", 3,
                 filled<std::uint8_t>(3 * points, [&](std::size_t) { return n->below(256); })));
  arrays.push_back(make_array("constant", "Float32", 1, std::vector<float>(points, 3.25F)));
}

void add_cell_arrays(Numbers* n, Mesh* mesh) {
  const std::size_t cells = mesh->cells();
  mesh->cell_arrays = {
      make_array(kCellNumber, "Int64", 1,
                 filled<std::int64_t>(cells, [](std::size_t i) { return i; })),
      make_array("stress", "Float64", 2,
                 filled<double>(2 * cells, [&](std::size_t) { return n->between(-5, 9); })),
      make_array("<&> \"q\"\t", "Float32", 1,
                 filled<float>(cells, [&](std::size_t) { return n->uniform(); }))};
}

void add_regions(Numbers* n, Mesh* mesh) {
  const std::size_t axis = n->below(3);
  std::vector<double> along;
  for (const Tet& t : mesh->tets) {
    double sum = 0;
    for (const std::int64_t v : t) sum += mesh->points[static_cast<std::size_t>(v)][axis];
    along.push_back(sum);
  }
  std::vector<double> sorted = along;
  std::sort(sorted.begin(), sorted.end());
  const double first = sorted[sorted.size() / 3], second = sorted[2 * sorted.size() / 3];
  const bool scattered = n->chance(0.15);
  const auto regions = filled<std::int64_t>(mesh->cells(), [&](std::size_t c) -> std::size_t {
    if (c >= along.size()) return 0;
    if (scattered) return n->below(4);
    return (along[c] > first ? 1u : 0u) + (along[c] > second ? 1u : 0u);
  });
  if (n->chance(0.5)) {
    mesh->cell_arrays.push_back(make_array(kRegions, "Int64", 1, regions));
  } else {
    mesh->cell_arrays.push_back(make_array(
        kRegions, "UInt8", 1,
        filled<std::uint8_t>(regions.size(), [&](std::size_t c) { return regions[c]; })));
  }
}

void dress(Numbers* n, Mesh* mesh) {
  if (n->chance(0.95)) add_point_arrays(n, mesh);
  add_cell_arrays(n, mesh);
  if (n->chance(0.35)) add_regions(n, mesh);
  if (n->chance(0.3))
    mesh->field_arrays.push_back(make_array("TimeValue", "Float64", 1, std::vector<double>{2.5}));
  if (n->chance(0.1))
    mesh->field_arrays.push_back(make_array("nothing", "Float64", 1, std::vector<double>{}));
}

void choose_surface(Numbers* n, Options* o) {
  if (n->chance(0.35)) return;
  o->surface = n->chance(0.35) ? Surface::kPlanar : Surface::kWithin;
  if (o->surface == Surface::kWithin) o->distance = std::pow(10.0, n->between(-4, -0.3));
}

Options choose_options(Numbers* n, const Mesh& mesh) {
  Options o;
  o.threads = 1 + static_cast<int>(n->below(3));
  o.chunk_tets = n->pick(std::vector<std::uint64_t>{20, 60, 200, 600, 200'000, 200'000});
  o.on_disk = n->chance(0.2);
  o.verify = n->chance(0.5);
  o.twice = n->chance(0.4);
  o.regions = n->chance(0.8);
  o.fuse = n->chance(0.8);
  const bool steered = !mesh.point_arrays.empty();
  if (n->chance(0.75) || (o.fuse && !steered)) {
    o.tets = 1 + n->below(1 + mesh.tets.size() / (1 + n->below(8)));
  }
  if (o.fuse) {
    o.min_quality = n->pick(std::vector<double>{0, 0.01, 0.05, 0.22});
    choose_surface(n, &o);
    if (n->chance(0.35)) o.max_error = std::pow(10.0, n->between(-3, 0));
    if (n->chance(0.15)) o.max_rms = std::pow(10.0, n->between(-3, 0));
    o.conserve = o.surface != Surface::kWithin && n->chance(0.25);
  } else {
    o.boundary_tets = n->chance(0.3);
    if (n->chance(0.7)) o.scalar_tolerance = std::pow(10.0, n->between(-2, 1));
  }
  if (n->chance(0.1)) o.stretch_factor = n->between(1.2, 8);
  if (n->chance(0.1)) o.aspect_ratio = n->between(1.5, 10);
  if (o.surface != Surface::kExact && n->chance(0.3)) o.feature_angle = n->between(1, 180);
  return o;
}

}  // namespace

std::string Options::command() const {
  std::ostringstream text;
  text.precision(17);
  text << "--method " << (fuse ? "fuse" : "tetfuse") << " --chunk-tets " << chunk_tets
       << " --threads " << threads;
  const auto add = [&](const char* name, const auto& value) {
    if (value) text << " " << name << " " << *value;
  };
  add("--tets", tets);
  add("--max-error", max_error);
  add("--max-rms", max_rms);
  add("--scalar-tolerance", scalar_tolerance);
  add("--stretch-factor", stretch_factor);
  add("--aspect-ratio", aspect_ratio);
  if (fuse) text << " --min-quality " << min_quality;
  if (surface == Surface::kPlanar) text << " --boundary planar";
  if (surface == Surface::kWithin) text << " --boundary " << distance;
  add("--feature-angle", feature_angle);
  if (boundary_tets) text << " --boundary-rule tets";
  if (conserve) text << " --conserve";
  if (!regions) text << " --regions none";
  if (verify) text << " --verify";
  if (on_disk) text << " (on disk)";
  return text.str();
}

Case make_case(std::uint64_t number) {
  Numbers n(number);
  Case c;
  c.kind = number % kinds().size();
  const Shape shape = kinds()[c.kind].make(&n);
  const Place& place = n.chance(0.4) ? places()[n.below(2)] : n.pick(places());
  c.place = place.name;
  c.mesh.points = shape.points;
  c.mesh.tets = shape.tets;
  put(&n, place, &c.mesh);
  wind_wrongly(&n, &c.mesh);
  if (n.chance(0.5)) reorder(&n, &c.mesh);
  if (n.chance(0.2)) add_unused(&n, &c.mesh);
  if (n.chance(0.25)) add_lower(&n, &c.mesh);
  dress(&n, &c.mesh);
  c.options = choose_options(&n, c.mesh);
  return c;
}

}  // namespace corpus
