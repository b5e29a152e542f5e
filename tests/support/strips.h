// Light that spreads in one direction only, by one-dimensional roots and integrals: an oracle for
// areas, fluxes and totals.
#pragma once

#include <complex>
#include <functional>
#include <utility>
#include <vector>

#include "solver/optical_system.h"

namespace caustic::test {

/// By halving; f has one root between a and b.
template <class F>
double root_of(const F& f, double a, double b) {
  const bool positive = f(b) > 0.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (a + b);
    ((f(middle) > 0.0) == positive ? b : a) = middle;
  }
  return 0.5 * (a + b);
}

template <class F>
double simpson(const F& f, double a, double b, int panels) {
  double sum = f(a) + f(b);
  for (int i = 1; i < 2 * panels; ++i)
    sum += (i % 2 ? 4.0 : 2.0) * f(a + (b - a) * i / (2.0 * panels));
  return sum * (b - a) / (6.0 * panels);
}

/// Unpolarised reflectance at the angle of incidence, by the amplitudes across and along.
double fresnel(std::complex<double> index, double angle);

/// All is a function of a parameter p of the surface, and of u on the receiver.
class Strips {
 public:
  using Function = std::function<double(double)>;
  /// Where p sends its light, the derivative, and how much light there is per p.
  Strips(Function arrival, Function slope, Function density, double begin, double end);

  double irradiance(double u) const;
  /// Width of what is at least so bright between lo and hi, and the light onto that per length.
  std::pair<double, double> above(double level, double lo, double hi) const;

 private:
  std::vector<double> places(double u) const;
  std::vector<std::pair<double, double>> strips(double level, double lo, double hi) const;
  double flux(double u0, double u1) const;

  Function arrival_, slope_, density_;
  std::vector<double> folds_;  // and the ends
};

/// Water z = 0.1 sin 2πx over a floor, lit from above; the receiver is u, v ∈ [−½, ½] about
/// x = y = ½.
Strips strips_of_water(double depth);
solver::OpticalSystem water_waves(double depth);

}  // namespace caustic::test
