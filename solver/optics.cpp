#include "solver/optics.h"

namespace caustic::solver {

namespace {

// |r|² and its derivative.
Share squared(std::complex<double> r, std::complex<double> slope) {
  return {std::norm(r), 2.0 * (std::conj(r) * slope).real()};
}

}  // namespace

Share fresnel_reflectance(std::complex<double> index, double c) {
  // m cos t = q; r_s and r_p as in Born & Wolf §1.5.2, one formula for dielectrics and metals.
  const std::complex<double> mm = index * index, q = std::sqrt(mm - 1.0 + c * c), dq = c / q;
  const std::complex<double> s = c + q, p = mm * c + q;
  // (c − q)/(c + q) has the derivative 2 (q − c q′)/(c + q)², the other likewise.
  const Share across = squared((c - q) / s, 2.0 * (q - c * dq) / (s * s));
  const Share along = squared((mm * c - q) / p, 2.0 * mm * (q - c * dq) / (p * p));
  return {0.5 * (across.value + along.value), 0.5 * (across.slope + along.slope)};
}

Share Optics::share(int side, double cosine) const {
  if (kind == Kind::mirror) {
    return metal ? fresnel_reflectance(*metal, cosine) : Share{reflectance, 0.0};
  }
  if (!fresnel || index_outside == index_inside) return {1.0, 0.0};
  const Share reflected = fresnel_reflectance(1.0 / eta(side), cosine);
  return {1.0 - reflected.value, -reflected.slope};
}

}  // namespace caustic::solver
