#include "exact.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

namespace corpus {

namespace {

// A number as a sum of doubles that do not overlap, the smallest first (Shewchuk 1997).
class Expansion {
 public:
  explicit Expansion(double value = 0) {
    if (value != 0) parts_.push_back(value);
  }
  static Expansion difference(double a, double b) { return Expansion(a) + Expansion(-b); }

  Expansion operator+(const Expansion& other) const {
    Expansion sum = *this;
    for (const double part : other.parts_) sum.grow(part);
    return sum;
  }
  Expansion operator-(const Expansion& other) const {
    Expansion sum = *this;
    for (const double part : other.parts_) sum.grow(-part);
    return sum;
  }
  Expansion operator*(const Expansion& other) const {
    Expansion product;
    for (const double a : parts_) {
      for (const double b : other.parts_) {
        const double high = a * b;
        product.grow(std::fma(a, b, -high));
        product.grow(high);
      }
    }
    return product;
  }
  int sign() const { return parts_.empty() ? 0 : (parts_.back() > 0 ? 1 : -1); }

 private:
  void grow(double value) {
    std::size_t kept = 0;
    for (const double part : parts_) {
      const double sum = value + part;
      const double b = sum - value;
      const double rest = (value - (sum - b)) + (part - b);
      if (rest != 0) parts_[kept++] = rest;
      value = sum;
    }
    parts_.resize(kept);
    if (value != 0) parts_.push_back(value);
  }

  std::vector<double> parts_;
};

using Row = std::array<Expansion, 3>;

Row difference(const Point& a, const Point& b) {
  return {Expansion::difference(a[0], b[0]), Expansion::difference(a[1], b[1]),
          Expansion::difference(a[2], b[2])};
}

Expansion determinant(const Row& u, const Row& v, const Row& w) {
  return (u[1] * v[2] - u[2] * v[1]) * w[0] + (u[2] * v[0] - u[0] * v[2]) * w[1] +
         (u[0] * v[1] - u[1] * v[0]) * w[2];
}

// The same in long double, with a generous bound on its error.
struct Rough {
  long double value, error;
  int sign() const { return value > error ? 1 : value < -error ? -1 : 0; }
};

using LongRow = std::array<long double, 3>;

LongRow long_difference(const Point& a, const Point& b) {
  return {static_cast<long double>(a[0]) - b[0], static_cast<long double>(a[1]) - b[1],
          static_cast<long double>(a[2]) - b[2]};
}

constexpr long double kRounding = 64 * 0x1p-64L;

Rough rough(const LongRow& u, const LongRow& v, const LongRow& w) {
  long double value = 0, size = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
    value += (u[j] * v[k] - u[k] * v[j]) * w[i];
    size += (std::abs(u[j] * v[k]) + std::abs(u[k] * v[j])) * std::abs(w[i]);
  }
  return {value, kRounding * size};
}

Expansion square(const Row& u) { return u[0] * u[0] + u[1] * u[1] + u[2] * u[2]; }

}  // namespace

int orientation(const Point& a, const Point& b, const Point& c, const Point& d) {
  const Rough estimate = rough(long_difference(b, a), long_difference(c, a), long_difference(d, a));
  if (estimate.sign() != 0) return estimate.sign();
  return determinant(difference(b, a), difference(c, a), difference(d, a)).sign();
}

int in_sphere(const Point& a, const Point& b, const Point& c, const Point& d, const Point& e) {
  const std::array<LongRow, 4> rows{long_difference(a, e), long_difference(b, e),
                                    long_difference(c, e), long_difference(d, e)};
  // Expanded along the squares; the signs make it positive inside a positive tetrahedron.
  constexpr std::array<std::array<std::size_t, 3>, 4> kOthers{
      {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}}};
  long double value = 0, error = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& o = kOthers[i];
    const Rough minor = rough(rows[o[0]], rows[o[1]], rows[o[2]]);
    const LongRow& r = rows[i];
    const long double lifted = r[0] * r[0] + r[1] * r[1] + r[2] * r[2];
    value += (i % 2 == 0 ? -1 : 1) * lifted * minor.value;
    error += lifted * (minor.error + kRounding * std::abs(minor.value));
  }
  error *= 4;
  if (value > error) return -1;
  if (value < -error) return 1;
  const std::array<Row, 4> exact{difference(a, e), difference(b, e), difference(c, e),
                                 difference(d, e)};
  Expansion sum;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto& o = kOthers[i];
    const Expansion term = square(exact[i]) * determinant(exact[o[0]], exact[o[1]], exact[o[2]]);
    sum = i % 2 == 0 ? sum - term : sum + term;
  }
  return -sum.sign();
}

double unit_of(const Point* points, std::size_t count) {
  double most = 0;
  for (std::size_t i = 0; i < count; ++i) {
    for (const double c : points[i]) most = std::max(most, std::abs(c));
  }
  return most > 0 && std::isfinite(most) ? std::ldexp(1.0, std::ilogb(most)) : 1;
}

}  // namespace corpus
