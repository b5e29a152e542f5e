#include "tests/support/strips.h"

#include <algorithm>
#include <cmath>

#include "geometry/expression/field.h"
#include "tests/support/scenes.h"

namespace caustic::test {

using geometry::kPi;
using geometry::Point;
using namespace solver;

double fresnel(std::complex<double> index, double angle) {
  const std::complex<double> sine = std::sin(angle) / index, cosine = std::sqrt(1.0 - sine * sine);
  const double c = std::cos(angle);
  return 0.5 * (std::norm((c - index * cosine) / (c + index * cosine)) +
                std::norm((index * c - cosine) / (index * c + cosine)));
}

Strips::Strips(Function arrival, Function slope, Function density, double begin, double end)
    : arrival_(std::move(arrival)), slope_(std::move(slope)), density_(std::move(density)) {
  folds_.push_back(begin);
  for (int i = 0; i < 3000; ++i) {
    const double a = begin + (end - begin) * i / 3000, b = begin + (end - begin) * (i + 1) / 3000;
    if ((slope_(a) > 0.0) != (slope_(b) > 0.0)) folds_.push_back(root_of(slope_, a, b));
  }
  folds_.push_back(end);
}

double Strips::irradiance(double u) const {
  double sum = 0.0;
  for (const double p : places(u)) sum += density_(p) / std::abs(slope_(p));
  return sum;
}

std::pair<double, double> Strips::above(double level, double lo, double hi) const {
  std::pair<double, double> sum{0.0, 0.0};
  for (const auto& [begin, end] : strips(level, lo, hi)) {
    sum.first += end - begin;
    sum.second += flux(begin, end);
  }
  return sum;
}

// Between folds the map is monotone: its inverses at u.
std::vector<double> Strips::places(double u) const {
  std::vector<double> found;
  for (std::size_t i = 0; i + 1 < folds_.size(); ++i) {
    const double a = folds_[i], b = folds_[i + 1];
    if ((arrival_(a) > u) != (arrival_(b) > u))
      found.push_back(root_of([&](double p) { return arrival_(p) - u; }, a, b));
  }
  return found;
}

// Intervals of [lo, hi] where the irradiance is at least `level`, cut at caustics and ends.
std::vector<std::pair<double, double>> Strips::strips(double level, double lo, double hi) const {
  std::vector<double> cuts{lo, hi};
  for (const double p : folds_) {
    if (arrival_(p) > lo && arrival_(p) < hi) cuts.push_back(arrival_(p));
  }
  std::sort(cuts.begin(), cuts.end());
  std::vector<std::pair<double, double>> found;
  for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
    constexpr int kSamples = 40;
    // Denser towards the caustics, which the ends may be.
    const auto at = [&](int i) {
      const double s = std::sin(0.5 * kPi * (i + 0.5) / kSamples);
      return cuts[k] + (cuts[k + 1] - cuts[k]) * s * s;
    };
    const auto excess = [&](double u) { return irradiance(u) - level; };
    double begin = excess(at(0)) >= 0.0 ? cuts[k] : NAN;
    for (int i = 0; i + 1 < kSamples; ++i) {
      if ((excess(at(i)) >= 0.0) == (excess(at(i + 1)) >= 0.0)) continue;
      const double edge = root_of(excess, at(i), at(i + 1));
      if (std::isnan(begin)) {
        begin = edge;
      } else {
        found.emplace_back(begin, edge);
        begin = NAN;
      }
    }
    if (!std::isnan(begin)) found.emplace_back(begin, cuts[k + 1]);
  }
  return found;
}

// Between two values of u within which no caustic lies.
double Strips::flux(double u0, double u1) const {
  double sum = 0.0;
  for (std::size_t i = 0; i + 1 < folds_.size(); ++i) {
    const double a = folds_[i], b = folds_[i + 1];
    const bool rises = arrival_(b) > arrival_(a);
    const auto inverse = [&](double u) {
      if ((rises ? arrival_(a) : arrival_(b)) >= u) return rises ? a : b;
      if ((rises ? arrival_(b) : arrival_(a)) <= u) return rises ? b : a;
      return root_of([&](double p) { return arrival_(p) - u; }, a, b);
    };
    sum += std::abs(simpson(density_, inverse(u0), inverse(u1), 100));
  }
  return sum;
}

Strips strips_of_water(double depth) {
  // Tangent of the refracted ray's angle to the vertical, and its derivative.
  const auto refracted = [](double x) {
    const double f = 0.2 * kPi * std::cos(2 * kPi * x),
                 f_x = -0.4 * kPi * kPi * std::sin(2 * kPi * x);
    const double in = std::atan(f), out = std::asin(std::sin(in) / 1.33);
    const double in_x = f_x / (1.0 + f * f);
    const double out_x = std::cos(in) * in_x / (1.33 * std::cos(out));
    const double tan = std::tan(in - out);
    return std::pair(tan, (1.0 + tan * tan) * (in_x - out_x));
  };
  const auto height = [=](double x) { return depth + 0.1 * std::sin(2 * kPi * x); };
  return Strips([=](double x) { return x + height(x) * refracted(x).first; },
                [=](double x) {
                  const auto [tan, tan_x] = refracted(x);
                  return 1.0 + 0.2 * kPi * std::cos(2 * kPi * x) * tan + height(x) * tan_x;
                },
                [](double) { return 1.0; }, -1.0, 2.0);
}

OpticalSystem water_waves(double depth) {
  const auto surface =
      geometry::make_expression(geometry::read_expression("z-0.1*sin(6.283185307179586*x)", 1.0),
                                {Point(-1, -1, -0.2), Point(2, 2, 0.2)}, {});
  auto water = mirror(surface.surface);
  water.optics = {.kind = Optics::Kind::refract, .index_outside = 1.0, .index_inside = 1.33};
  return OpticalSystem::build(CollimatedLight{{0, 0, -1}, 1.0}, {water},
                              floor_at({0.5, 0.5, -depth}, 1, 1));
}

}  // namespace caustic::test
