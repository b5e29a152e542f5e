#include "tests/support/reference_path.h"

#include <boost/multiprecision/eigen.hpp>

#include "tests/support/reference_real.h"

namespace caustic::test {

namespace {

using RealVec = Eigen::Matrix<Real, 3, 1>;

// Differences: a step h leaves an error of h² in first and second derivatives, and one of 1e-48/h²
// of rounding in the latter.
const Real kPathStep("1e-12");
// Newton's derivatives come from differences this small: each iteration gains 20 digits.
const Real kNewtonStep("1e-20");

RealVec from(const geometry::Vec3& a) { return {Real(a.x()), Real(a.y()), Real(a.z())}; }
geometry::Vec3 rounded(const RealVec& a) {
  return {static_cast<double>(a[0]), static_cast<double>(a[1]), static_cast<double>(a[2])};
}

struct RealRay {
  RealVec o, w;
};

class Shooter {
 public:
  Shooter(const std::vector<ReferenceVertex>& hops, const RealVec& source,
          const std::vector<geometry::Point>& x)
      : hops_(hops), source_(source) {
    RealVec last = source;
    for (const auto& point : x) {
      distance_.push_back((from(point) - last).norm());
      last = from(point);
    }
    aim_ = (from(x.front()) - source).normalized();
    const RealVec other = abs(aim_[0]) < 0.6 ? RealVec::UnitX() : RealVec::UnitY();
    e1_ = aim_.cross(other).normalized();
    e2_ = aim_.cross(e1_);
  }

  /// The ray after the last hop; all hits if asked for. Directions by their tangents (α, β).
  RealRay shoot(const Real& alpha, const Real& beta, std::vector<RealVec>* hits = nullptr) const {
    RealRay ray{source_, (aim_ + alpha * e1_ + beta * e2_).normalized()};
    for (std::size_t i = 0; i < hops_.size(); ++i) {
      Real t = distance_[i];
      RealVec n;
      for (int k = 0; k < 9; ++k) {
        const RealVec y = ray.o + t * ray.w;
        const auto g = reference_implicit(hops_[i].shape, {y[0], y[1], y[2]});
        n = RealVec(g.gradient[0], g.gradient[1], g.gradient[2]);
        const Real step = g.value / n.dot(ray.w);
        t -= step;
        if (abs(step) < Real("1e-44")) break;  // n is that of the place before this step
      }
      ray.o += t * ray.w;
      n.normalize();
      const Real c = ray.w.dot(n);
      if (hops_[i].reflects) {
        ray.w -= Real(2 * c) * n;
      } else {
        // Snell: the part of n ω along the surface stays.
        const Real eta = Real(hops_[i].index_before) / Real(hops_[i].index_after);
        const RealVec along = eta * (ray.w - c * n);
        const Real across = sqrt(1 - along.squaredNorm());
        ray.w = along + (c > 0 ? across : Real(-across)) * n;
      }
      if (hits) hits->push_back(ray.o);
    }
    return ray;
  }

  /// Hits of the path that ends at p.
  std::vector<RealVec> path_to(const RealVec& p, Real& alpha, Real& beta) const {
    const RealVec w = shoot(alpha, beta).w;
    const RealVec other = abs(w[0]) < 0.6 ? RealVec::UnitX() : RealVec::UnitY();
    const RealVec u = w.cross(other).normalized(), v = w.cross(u);
    const auto miss = [&](const Real& a, const Real& b) -> std::array<Real, 2> {
      const RealRay ray = shoot(a, b);
      const RealVec y = p - ray.o, off = y - ray.w * ray.w.dot(y);
      return {u.dot(off), v.dot(off)};
    };
    for (int k = 0; k < 8; ++k) {
      const auto m = miss(alpha, beta);
      const auto ma = miss(alpha + kNewtonStep, beta), mb = miss(alpha, beta + kNewtonStep);
      const Real a = (ma[0] - m[0]) / kNewtonStep, b = (mb[0] - m[0]) / kNewtonStep;
      const Real c = (ma[1] - m[1]) / kNewtonStep, d = (mb[1] - m[1]) / kNewtonStep;
      const Real det = a * d - b * c;
      const Real da = (d * m[0] - b * m[1]) / det, db = (a * m[1] - c * m[0]) / det;
      alpha -= da;
      beta -= db;
      if (abs(da) + abs(db) < Real("1e-32")) break;
    }
    std::vector<RealVec> hits;
    shoot(alpha, beta, &hits);
    return hits;
  }

  /// Area across the ray at p per solid angle, for the ray (α, β). Frames are carried along the
  /// ray, so each reflection turns a right-handed pair of axes into a left-handed one.
  Real cross_section(const RealVec& p, const Real& alpha, const Real& beta) const {
    const RealRay ray = shoot(alpha, beta), ra = shoot(alpha + kNewtonStep, beta),
                  rb = shoot(alpha, beta + kNewtonStep);
    const auto place = [&](const RealRay& r) -> RealVec {
      return r.o + r.w * Real(ray.w.dot(p - r.o) / ray.w.dot(r.w));
    };
    const RealVec pa = (place(ra) - place(ray)) / kNewtonStep;
    const RealVec pb = (place(rb) - place(ray)) / kNewtonStep;
    // Solid angle of dα dβ is (1 + α² + β²)^(−3/2); (e1, e2, aim) is right-handed.
    const Real stretch = sqrt(1 + alpha * alpha + beta * beta);
    Real sign = e1_.cross(e2_).dot(aim_);
    for (const ReferenceVertex& hop : hops_) {
      if (hop.reflects) sign = -sign;
    }
    return sign * ray.w.dot(pa.cross(pb)) * stretch * stretch * stretch;
  }

 private:
  const std::vector<ReferenceVertex>& hops_;
  RealVec source_, aim_, e1_, e2_;
  std::vector<Real> distance_;
};

}  // namespace

ReferencePath reference_path(const std::vector<ReferenceVertex>& hops, const geometry::Point& source,
                             const geometry::Point& to, const std::vector<geometry::Point>& x) {
  const Shooter shooter(hops, from(source), x);
  const RealVec p = from(to);
  Real alpha = 0, beta = 0;
  const auto base = shooter.path_to(p, alpha, beta);
  const auto moved = [&](const RealVec& shift) {
    Real a = alpha, b = beta;
    return shooter.path_to(p + kPathStep * shift, a, b);
  };

  ReferencePath r;
  r.determinant = static_cast<double>(shooter.cross_section(p, alpha, beta));
  Real length = 0;
  RealVec last = from(source);
  for (std::size_t i = 0; i <= hops.size(); ++i) {
    const RealVec next = i < hops.size() ? base[i] : p;
    const Real step = (next - last).norm();
    length += Real(i == 0 ? hops[0].index_before : hops[i - 1].index_after) * step;
    last = next;
    if (i < hops.size()) r.x.push_back(rounded(next));
  }
  r.optical_length = static_cast<double>(length);

  r.jacobians.resize(hops.size());
  r.hessians.resize(hops.size());
  const RealVec axes[3] = {RealVec::UnitX(), RealVec::UnitY(), RealVec::UnitZ()};
  std::vector<RealVec> forth[3], back[3];
  for (int b = 0; b < 3; ++b) {
    forth[b] = moved(axes[b]);
    back[b] = moved(-axes[b]);
  }
  const Real hh = kPathStep * kPathStep;
  for (std::size_t i = 0; i < hops.size(); ++i) {
    for (int b = 0; b < 3; ++b) {
      r.jacobians[i].col(b) = rounded((forth[b][i] - back[b][i]) / Real(2 * kPathStep));
      const auto second = rounded((forth[b][i] + back[b][i] - Real(2) * base[i]) / hh);
      for (int a = 0; a < 3; ++a) r.hessians[i][a](b, b) = second[a];
    }
  }
  for (int b = 1; b < 3; ++b) {
    for (int c = 0; c < b; ++c) {
      const auto up = moved(axes[b] + axes[c]), down = moved(-axes[b] - axes[c]);
      for (std::size_t i = 0; i < hops.size(); ++i) {
        const auto mixed = rounded((up[i] + down[i] + Real(2) * base[i] - forth[b][i] - back[b][i] -
                                    forth[c][i] - back[c][i]) /
                                   Real(2 * hh));
        for (int a = 0; a < 3; ++a) {
          r.hessians[i][a](b, c) = r.hessians[i][a](c, b) = mixed[a];
        }
      }
    }
  }
  return r;
}

}  // namespace caustic::test
