// Fresnel's reflectance over a cell, (S26).
#pragma once

#include <complex>

#include "geometry/interval_jet.h"

namespace caustic::solver {

/// `index` as in fresnel_reflectance(); enclosed where nothing is reflected totally.
inline geometry::IntervalJet enclosed_reflectance(std::complex<double> index,
                                                  const geometry::IntervalJet& c) {
  using geometry::constant_jet;
  using geometry::IntervalJet;
  const std::complex<double> mm = index * index;
  // q = √(u + iv), that of its parts first that loses nothing.
  const IntervalJet u = square(c) + constant_jet(geometry::Interval(mm.real()) - 1.0);
  const double v = mm.imag();
  IntervalJet re, im = constant_jet(0.0);
  if (v == 0.0) {
    re = sqrt(u);
  } else {
    const IntervalJet modulus = sqrt(square(u) + constant_jet(sqr(geometry::Interval(v))));
    IntervalJet& first = u.v.middle() > 0.0 ? re : im;
    IntervalJet& second = u.v.middle() > 0.0 ? im : re;
    first = sqrt(0.5 * (u.v.middle() > 0.0 ? modulus + u : modulus - u));
    second = constant_jet(0.5 * v) / first;
  }
  const auto norm = [](const IntervalJet& x, const IntervalJet& y) {
    return square(x) + square(y);
  };
  const IntervalJet p = mm.real() * c, s = mm.imag() * c;
  const IntervalJet across = norm(c - re, im) / norm(c + re, im);
  const IntervalJet along = norm(p - re, s - im) / norm(p + re, s + im);
  return 0.5 * (across + along);
}

}  // namespace caustic::solver
