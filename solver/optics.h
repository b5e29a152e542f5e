// What a surface does to light that meets it.
#pragma once

#include <complex>
#include <optional>

namespace caustic::solver {

/// Longest path (api.md); it bounds what is kept on the stack.
constexpr int kMaxHops = 8;

/// Fresnel's reflectance of unpolarised light and its derivative by the cosine of incidence, (S26).
/// `index` is that of the other side over that of the incident one, n + ik for a metal. Only below
/// total reflection if real.
struct Share {
  double value, slope;
};
Share fresnel_reflectance(std::complex<double> index, double cosine);

struct Optics {
  enum class Kind { mirror, refract, absorb };

  Kind kind = Kind::mirror;
  double reflectance = 1.0;  ///< mirrors, in (0, 1]
  std::optional<std::complex<double>> metal =
      std::nullopt;                                ///< n + ik takes the place of `reflectance`
  double index_outside = 1.0, index_inside = 1.0;  ///< refraction, > 0
  bool fresnel = false;                            ///< refraction loses what Fresnel reflects

  bool passes_light_on() const { return kind != Kind::absorb; }
  /// Index on the incident side over that on the other, for light that comes from side s = ±1.
  double eta(int side) const {
    return side > 0 ? index_outside / index_inside : index_inside / index_outside;
  }
  /// True if the share of light that goes on does not depend on the angle.
  bool constant_share() const { return kind == Kind::mirror ? !metal : !fresnel; }
  /// Share of the light from side s that goes on, at this cosine of incidence in (0, 1].
  Share share(int side, double cosine) const;
};

}  // namespace caustic::solver
