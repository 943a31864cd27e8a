#include "kernel/quadrics/quadric.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "support/meshes.h"

namespace tetfusion {
namespace {

using Vector3 = std::array<double, 3>;
using Quadric = std::vector<float>;

// Numbers in [-1, 1), one after another.
class Random {
 public:
  explicit Random(std::uint64_t seed) : seed_(seed) {}
  double next() { return 2 * testing::uniform(seed_, n_++) - 1; }
  Vector3 vector() { return {next(), next(), next()}; }

 private:
  std::uint64_t seed_, n_ = 0;
};

double product(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Vector3 minus(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Offset to_offset(const Vector3& a) {
  return {static_cast<float>(a[0]), static_cast<float>(a[1]), static_cast<float>(a[2])};
}

// A tetrahedron's linear functions, by their values at one place.
struct Linear {
  double volume;
  Vector3 at;
  std::vector<double> values;
  std::vector<Vector3> gradients;
};

struct Vertex {
  Vector3 position;
  std::vector<double> values;
};

Vertex random_vertex(std::size_t width, Random* random) {
  Vertex v{random->vector(), {}};
  for (std::size_t k = 0; k < width; ++k) v.values.push_back(random->next());
  return v;
}

// What the definition says, in double precision.
double direct(const std::vector<Linear>& tets, const Vertex& at) {
  double sum = 0;
  for (const Linear& t : tets) {
    for (std::size_t k = 0; k < at.values.size(); ++k) {
      const double deviation =
          product(t.gradients[k], minus(at.position, t.at)) + t.values[k] - at.values[k];
      sum += t.volume * deviation * deviation;
    }
  }
  return sum;
}

// What quadric.h says a quadric's numbers mean.
double value_of(const Quadric& q, const Vector3& u, const std::vector<double>& t) {
  double value = q[0] * u[0] * u[0] + q[3] * u[1] * u[1] + q[5] * u[2] * u[2];
  value += 2 * (q[1] * u[0] * u[1] + q[2] * u[0] * u[2] + q[4] * u[1] * u[2]);
  value += 2 * (q[6] * u[0] + q[7] * u[1] + q[8] * u[2]) + q[kQuadricC];
  for (std::size_t k = 0; k < t.size(); ++k) {
    const float* b = q.data() + kQuadricFields + 4 * k;
    value += q[kQuadricW] * t[k] * t[k];
    value -= 2 * t[k] * (b[0] * u[0] + b[1] * u[1] + b[2] * u[2] + b[3]);
  }
  return value;
}

// Gives a vertex some tetrahedra, and appends them to the list.
Quadric make_quadric(const Vertex& vertex, int tets, Random* random, std::vector<Linear>* all) {
  const std::size_t width = vertex.values.size();
  Quadric q(quadric_size(width));
  for (int i = 0; i < tets; ++i) {
    Linear linear{0.1 + std::abs(random->next()), vertex.position, vertex.values, {}};
    std::vector<float> gradients;
    for (std::size_t k = 0; k < width; ++k) {
      linear.gradients.push_back(random->vector());
      const Offset g = to_offset(linear.gradients.back());
      gradients.insert(gradients.end(), g.begin(), g.end());
    }
    add_tetrahedron(static_cast<float>(linear.volume), gradients.data(), width, q.data());
    all->push_back(linear);
  }
  return q;
}

void shift(const Quadric& from, const Vertex& old_place, const Vertex& place, Quadric* to) {
  std::vector<float> t;
  for (std::size_t k = 0; k < place.values.size(); ++k) {
    t.push_back(static_cast<float>(place.values[k] - old_place.values[k]));
  }
  add_shifted(from.data(), to_offset(minus(place.position, old_place.position)), t.data(),
              place.values.size(), to->data());
}

// The quadrics of a few vertices, added up about a place of their own.
Quadric make_sum(const Vertex& place, Random* random, std::vector<Linear>* all) {
  Quadric sum(quadric_size(place.values.size()));
  for (int v = 0; v < 4; ++v) {
    const Vertex vertex = random_vertex(place.values.size(), random);
    shift(make_quadric(vertex, 5, random, all), vertex, place, &sum);
  }
  return sum;
}

TEST(Quadric, OfOneTetrahedronIsZeroAtItsVertexAndAlongItsFunction) {
  for (std::size_t width = 1; width <= 3; ++width) {
    Random random(width);
    const Vertex vertex = random_vertex(width, &random);
    std::vector<Linear> tets;
    const Quadric q = make_quadric(vertex, 1, &random, &tets);
    EXPECT_EQ(q[kQuadricC], 0);
    EXPECT_EQ(value_of(q, {0, 0, 0}, std::vector<double>(width, 0)), 0);
    EXPECT_EQ(q[kQuadricW], static_cast<float>(tets[0].volume));
    for (int i = 0; i < 10; ++i) {
      const Vector3 u = random.vector();
      std::vector<double> t;
      for (const Vector3& g : tets[0].gradients) t.push_back(product(g, u));
      EXPECT_NEAR(value_of(q, u, t), 0, 1e-5);
      EXPECT_NEAR(value_at(reduce(q.data(), width), to_offset(u)), 0, 1e-5);
      t[width - 1] += 0.5;
      EXPECT_NEAR(value_of(q, u, t), 0.25 * tets[0].volume, 1e-5);
      EXPECT_NEAR(best_value(q.data(), width - 1, to_offset(u)), t[width - 1] - 0.5, 1e-5);
    }
  }
}

TEST(Quadric, WithoutFieldsItOnlyWeighs) {
  Quadric q(quadric_size(0)), sum(quadric_size(0));
  add_tetrahedron(2, nullptr, 0, q.data());
  add_shifted(q.data(), {1, 2, 3}, nullptr, 0, sum.data());
  add_shifted(q.data(), {0, 0, 0}, nullptr, 0, sum.data());
  EXPECT_EQ(sum[kQuadricW], 4);
  EXPECT_EQ(value_at(reduce(sum.data(), 0), {5, 6, 7}), 0);
}

TEST(Quadric, ShiftedOnesAddUpToTheDefinition) {
  for (std::size_t width = 1; width <= 3; ++width) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      Random random(100 * width + seed);
      const Vertex place = random_vertex(width, &random);
      std::vector<Linear> tets;
      const Quadric q = make_sum(place, &random, &tets);
      for (int i = 0; i < 5; ++i) {
        const Vertex at = random_vertex(width, &random);
        std::vector<double> t;
        for (std::size_t k = 0; k < width; ++k) t.push_back(at.values[k] - place.values[k]);
        const double expected = direct(tets, at);
        EXPECT_NEAR(value_of(q, minus(at.position, place.position), t), expected, 2e-4);
      }
    }
  }
}

// To and fro comes to the same.
TEST(Quadric, ShiftsCanBeTakenBack) {
  Random random(7);
  const Vertex a = random_vertex(2, &random), b = random_vertex(2, &random);
  std::vector<Linear> tets;
  const Quadric q = make_sum(a, &random, &tets);
  Quadric there(q.size()), back(q.size());
  shift(q, a, b, &there);
  shift(there, b, a, &back);
  for (std::size_t i = 0; i < q.size(); ++i) EXPECT_NEAR(back[i], q[i], 1e-4) << i;
}

TEST(Quadric, ReducedIsTheLeastOverAllValues) {
  for (std::size_t width = 1; width <= 3; ++width) {
    Random random(30 + width);
    const Vertex place = random_vertex(width, &random);
    std::vector<Linear> tets;
    const Quadric q = make_sum(place, &random, &tets);
    const Reduced r = reduce(q.data(), width);
    for (int i = 0; i < 20; ++i) {
      const Vector3 u = random.vector();
      const Offset offset = to_offset(u);
      std::vector<double> best;
      for (std::size_t k = 0; k < width; ++k) best.push_back(best_value(q.data(), k, offset));
      EXPECT_NEAR(value_at(r, offset), value_of(q, u, best), 1e-4);
      for (int j = 0; j < 50; ++j) {
        std::vector<double> other = best;
        for (double& t : other) t += random.next();
        EXPECT_LT(value_at(r, offset), value_of(q, u, other) + 1e-5);
      }
    }
  }
}

TEST(Quadric, TheBestPositionIsTheLeast) {
  for (std::size_t width = 1; width <= 3; ++width) {
    Random random(60 + width);
    const Vertex place = random_vertex(width, &random);
    std::vector<Linear> tets;
    const Quadric q = make_sum(place, &random, &tets);
    const Reduced r = reduce(q.data(), width);
    const Offset home = to_offset(random.vector());
    const Offset best = best_position(r, home, 0, 1e12F);
    for (int i = 0; i < 200; ++i) {
      const Vector3 step = random.vector();
      Offset other = best;
      for (std::size_t k = 0; k < 3; ++k) other[k] += static_cast<float>(step[k]);
      EXPECT_LE(value_at(r, best), value_at(r, other) + 1e-4);
    }
    // What draws it home costs a little there and brings it nearer.
    const auto distance = [&](const Offset& p) {
      return std::hypot(p[0] - home[0], p[1] - home[1], p[2] - home[2]);
    };
    const Offset drawn = best_position(r, home, 0.5F, 1e12F);
    EXPECT_LT(distance(drawn), distance(best));
    EXPECT_GE(value_at(r, drawn), value_at(r, best) - 1e-4);
    EXPECT_LE(value_at(r, drawn), value_at(r, home) + 1e-4);
    for (const float reach : {0.0F, 1e-3F, 0.1F}) {
      EXPECT_LE(distance(best_position(r, home, 0.02F, reach * reach)),
                reach * (1 + 1e-5F) + 1e-7F);
    }
  }
}

TEST(Quadric, WhereNothingTellsItStaysAtHome) {
  const Offset home{1, 2, 3};
  const Reduced flat{{0, 0, 0, 0, 0, 0}, {0, 0, 0}, 0};
  EXPECT_EQ(best_position(flat, home, 0.02F, 1), home);
  // One field: nothing tells along its level sets, and the pull holds the vertex there.
  Quadric q(quadric_size(1));
  const std::array<float, 3> one{1, 0, 0}, other{3, 0, 0};
  add_tetrahedron(1, one.data(), 1, q.data());
  add_tetrahedron(1, other.data(), 1, q.data());
  const Offset best = best_position(reduce(q.data(), 1), home, 0.02F, 100);
  EXPECT_NEAR(best[0], 0, 0.05);
  EXPECT_FLOAT_EQ(best[1], 2);
  EXPECT_FLOAT_EQ(best[2], 3);
  const float infinity = std::numeric_limits<float>::infinity();
  const Reduced broken{{1, 0, 0, 1, 0, 1}, {infinity, 0, 0}, 0};
  EXPECT_EQ(best_position(broken, home, 0, 1), home);
  EXPECT_EQ(best_value(Quadric(quadric_size(1)).data(), 0, home), 0);
}

// It gets as far as it should, and no other step that does costs less.
TEST(Quadric, TheCheapestStepGoesAsideWhereThatCostsNothing) {
  Random random(7);
  for (int round = 0; round < 50; ++round) {
    Quadric q(quadric_size(1));
    for (int i = 0; i < 2 + round % 3; ++i) {  // two: nothing tells along two directions
      const Offset gradient = to_offset(random.vector());
      add_tetrahedron(1, gradient.data(), 1, q.data());
    }
    Reduced r = reduce(q.data(), 1);
    r.n = {0, 0, 0};
    r.k = 0;
    Offset direction = to_offset(random.vector());
    const float length = std::sqrt(dot(direction.data(), direction));
    for (float& x : direction) x /= length;
    const float distance = static_cast<float>(random.next());
    const Offset step = cheapest_step(r, direction, distance, 1e-3F);
    EXPECT_NEAR(dot(step.data(), direction), distance, 1e-5);
    const float trace = r.m[0] + r.m[3] + r.m[5];
    const auto cost = [&](const Offset& u) {
      return double{value_at(r, u)} + 1e-3 * double{trace} * double{dot(u.data(), u)};
    };
    for (int k = 0; k < 20; ++k) {
      Offset other = to_offset(random.vector());
      const float off = dot(other.data(), direction);
      for (std::size_t i = 0; i < 3; ++i) other[i] = step[i] + other[i] - off * direction[i];
      EXPECT_LE(cost(step), cost(other) * 1.001 + 1e-6);
    }
  }
  const Reduced flat{{0, 0, 0, 0, 0, 0}, {0, 0, 0}, 0};
  EXPECT_EQ(cheapest_step(flat, {0, 0, 1}, 0.5F, 0.01F), (Offset{0, 0, 0.5F}));
}

}  // namespace
}  // namespace tetfusion
