#include "solver/enclosed_path.h"

#include <algorithm>
#include <cmath>

#include "geometry/interval_vectors.h"
#include "geometry/isolated_point.h"

namespace caustic::solver {

using geometry::Interval;
using geometry::IntervalVec3;

namespace {

// Widths of directions, and of normals as a share of them, up to which Krawczyk's operator is
// tried.
constexpr double kLinear = 0.5;
// Points so far outside a bound, in scales of the scene, are on it.
constexpr double kOnBound = 1e-12;

Point middle_of(const IntervalVec3& x) { return {x[0].middle(), x[1].middle(), x[2].middle()}; }

}  // namespace

EnclosedPath::EnclosedPath(const std::vector<PathSurface>& surfaces, const Light& light,
                           const Point& to, double scale, const std::vector<int>& sides)
    : surfaces_(surfaces),
      sides_(sides),
      to_(geometry::intervals(to)),
      scale_(scale),
      n_(static_cast<int>(surfaces.size())) {
  if (const auto* beam = std::get_if<CollimatedLight>(&light)) {
    beam_.emplace();
    beam_->w = geometry::intervals(beam->direction);
    for (auto& row : beam_->bend) std::fill(std::begin(row), std::end(row), Interval(0.0));
  } else {
    from_ = geometry::intervals(std::get<PointLight>(light).position);
  }
  double index = 1.0;
  index_.push_back(index);
  for (int i = 0; i < n_; ++i) {
    const PathSurface& s = surfaces[i];
    if (!s.reflects) {
      index *= sides[i] > 0 ? s.index_inside / s.index_outside : s.index_outside / s.index_inside;
    }
    index_.push_back(index);
  }
}

EnclosedPath::Segment EnclosedPath::between(const IntervalVec3& a, const IntervalVec3& b) {
  Segment s;
  const IntervalVec3 v = b - a;
  const Interval d = sqrt(geometry::squared_norm(v));
  for (int i = 0; i < 3; ++i) s.w[i] = geometry::intersection(v[i] / d, Interval(-1.0, 1.0));
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) {
      const Interval ww = i == j ? Interval(1.0) - sqr(s.w[i]) : -(s.w[i] * s.w[j]);
      s.bend[i][j] = s.bend[j][i] = ww / d;
    }
  }
  return s;
}

void EnclosedPath::enclose(const PathBox& box) {
  for (int i = 0; i < n_; ++i) surface_[i] = surfaces_[i].shape->enclose(box.x[i]);
  enclose_segments(box);
}

void EnclosedPath::enclose_segments(const PathBox& box) {
  segments_[0] = beam_ ? *beam_ : between(from_, box.x[0]);
  for (int k = 1; k <= n_; ++k) segments_[k] = between(box.x[k - 1], k == n_ ? to_ : box.x[k]);
}

// V of (S39).
IntervalVec3 EnclosedPath::miss(int i) const {
  return Interval(index_[i]) * segments_[i].w - Interval(index_[i + 1]) * segments_[i + 1].w;
}

// ---- What discards a box
// -------------------------------------------------------------------------

bool EnclosedPath::impossible(PathBox& box) {
  for (int i = 0; i < n_; ++i) {
    if (off_surface(box, i)) return true;
  }
  enclose_segments(box);
  for (int i = 0; i + 1 < n_; ++i) {
    if (follow(box, i, i + 1)) return true;
  }
  for (int i = n_ - 1; i > 0; --i) {
    if (follow(box, i, i - 1)) return true;
  }
  for (int i = 0; i + 1 < n_; ++i) {
    if (surfaces_[i].shape == surfaces_[i + 1].shape && chord_too_short(box, i)) return true;
  }
  for (int i = 0; i < n_; ++i) {
    if (on_wrong_side(i) || breaks_law(i)) return true;
  }
  return false;
}

// g does not vanish, or the surface does not exist there.
bool EnclosedPath::off_surface(const PathBox& box, int i) {
  surface_[i] = surfaces_[i].shape->enclose(box.x[i]);
  if (!surface_[i].g.contains_zero()) return true;
  const geometry::Box inside = geometry::box_of(box.x[i]);
  for (const auto& bound : *surfaces_[i].bounds) {
    if (bound.least_in(inside) > kOnBound * scale_) return true;
  }
  return false;
}

// (S42): what leaves hop `at` towards its neighbour `to`, before or after it, has the direction
// that the law gives to what comes from the other side, and the neighbour lies along it. Both are
// cut down to that; true if nothing is left.
bool EnclosedPath::follow(PathBox& box, int at, int to) {
  const bool forward = to > at;
  if (!(geometry::squared_norm(surface_[at].gradient).lo > 0.0)) return false;
  Segment& leaving = segments_[forward ? at + 1 : at];
  IntervalVec3 w;
  if (!leave(at, forward, w)) return true;
  for (int a = 0; a < 3; ++a) {
    leaving.w[a] = geometry::intersection(leaving.w[a], w[a]);
    if (leaving.w[a].empty()) return true;
  }
  // Along the axis that light follows best: its length, and with it the other coordinates.
  const IntervalVec3 v = box.x[to] - box.x[at];
  int best = 0;
  for (int a = 1; a < 3; ++a) {
    if (leaving.w[a].mignitude() > leaving.w[best].mignitude()) best = a;
  }
  if (!(leaving.w[best].mignitude() > 0.0)) return false;
  Interval length = v[best] / leaving.w[best];
  if (forward ? length.hi < 0.0 : length.lo > 0.0) return true;
  length = forward ? Interval(std::max(0.0, length.lo), length.hi)
                   : Interval(length.lo, std::min(0.0, length.hi));
  for (int a = 0; a < 3; ++a) {
    box.x[to][a] = geometry::intersection(box.x[to][a], box.x[at][a] + length * leaving.w[a]);
    if (box.x[to][a].empty()) return true;
  }
  return false;
}

// The direction that the law gives to the light on the other side of a hop; false if there is none.
bool EnclosedPath::leave(int at, bool forward, IntervalVec3& w) const {
  const IntervalVec3& given = segments_[forward ? at : at + 1].w;
  const IntervalVec3& N = surface_[at].gradient;
  const Interval NN = geometry::squared_norm(N);
  const Interval along = dot(N, given);
  if (surfaces_[at].reflects) {
    const Interval twice = 2.0 * along / NN;
    for (int a = 0; a < 3; ++a) w[a] = given[a] - twice * N[a];
    return true;
  }
  const double eta = forward ? index_[at] / index_[at + 1] : index_[at + 1] / index_[at];
  // Light passes: both directions have the sign that `sides_` gives to N·w, here N pointing on.
  const Interval root = sqrt((1.0 - sqr(Interval(eta))) * NN + sqr(Interval(eta)) * sqr(along));
  if (root.empty()) return false;
  const Interval share = ((sides_[at] > 0 ? -root : root) - eta * along) / NN;
  for (int a = 0; a < 3; ++a) w[a] = Interval(eta) * given[a] + share * N[a];
  return true;
}

// (S40): the chord from hop i to the next on the same surface is at least twice |∇g·w| over the
// Hessian, at each of its ends; where light comes from or goes to on the other side says how much
// that is.
bool EnclosedPath::chord_too_short(const PathBox& box, int i) const {
  const auto steepness = [&](int hop, const IntervalVec3& other, double eta) {
    const IntervalVec3& N = surface_[hop].gradient;
    return ((1.0 - sqr(Interval(eta))) * geometry::squared_norm(N) +
            sqr(Interval(eta)) * sqr(dot(N, other)))
        .lo;
  };
  const double most = std::max(steepness(i, segments_[i].w, index_[i] / index_[i + 1]),
                               steepness(i + 1, segments_[i + 2].w, index_[i + 2] / index_[i + 1]));
  if (!(most > 0.0)) return false;
  IntervalVec3 around;
  for (int a = 0; a < 3; ++a) around[a] = hull(box.x[i][a], box.x[i + 1][a]);
  const geometry::IntervalSym3 H = surfaces_[i].shape->enclose(around).hessian;
  const Interval HH = sqr(H[0]) + sqr(H[3]) + sqr(H[5]) + 2.0 * (sqr(H[1]) + sqr(H[2]) + sqr(H[4]));
  const Interval dd = geometry::squared_norm(box.x[i + 1] - box.x[i]);
  return (Interval(4.0) * Interval(most)).lo > (HH * dd).hi;
}

// Light does not stay on its side where it is reflected, or does not come from its own where it is
// refracted and pass.
bool EnclosedPath::on_wrong_side(int i) const {
  const IntervalVec3& N = surface_[i].gradient;
  const Interval in = dot(N, segments_[i].w), out = dot(N, segments_[i + 1].w);
  if (surfaces_[i].reflects) return (in.lo > 0.0 && out.lo > 0.0) || (in.hi < 0.0 && out.hi < 0.0);
  return sides_[i] > 0 ? in.lo > 0.0 || out.lo > 0.0 : in.hi < 0.0 || out.hi < 0.0;
}

// ∇g × V = 0 nowhere.
bool EnclosedPath::breaks_law(int i) const {
  const IntervalVec3& N = surface_[i].gradient;
  const IntervalVec3 V = miss(i);
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    if (!(N[b] * V[c] - N[c] * V[b]).contains_zero()) return true;
  }
  return false;
}

bool EnclosedPath::holds_only_a_point(const PathBox& box) const {
  for (int i = 0; i < n_; ++i) {
    if (geometry::holds_only_a_point(surfaces_[i].shape->enclose(box.x[i]))) return true;
  }
  return false;
}

// ---- The equations
// -------------------------------------------------------------------------------

// The operator can contract only where directions and normals vary little; asking costs less than
// trying.
bool EnclosedPath::promising(const PathBox& box) const {
  for (int k = 0; k <= n_; ++k) {
    for (const Interval& w : segments_[k].w) {
      if (w.width() > kLinear) return false;
    }
  }
  for (int i = 0; i < n_; ++i) {
    Vec3 N;
    surfaces_[i].shape->value_gradient(middle_of(box.x[i]), N);
    const double length = N.norm();
    for (int a = 0; a < 3; ++a) {
      if (!(surface_[i].gradient[a].width() <= kLinear * length)) return false;
    }
  }
  return true;
}

bool EnclosedPath::middle(const PathBox& box, PathMiddle& m) const {
  for (int i = 0; i < n_; ++i) {
    m.x[i] = middle_of(box.x[i]);
    Vec3 N;
    surfaces_[i].shape->value_gradient(m.x[i], N);
    const double length = N.norm();
    if (!(length > 0.0) || !std::isfinite(length)) return false;
    const geometry::Frame frame(N / length);
    m.c[i] = {frame.e1, frame.e2};
  }
  return true;
}

void EnclosedPath::values(const PathMiddle& m, Values& F) {
  PathBox point;
  for (int i = 0; i < n_; ++i) point.x[i] = geometry::intervals(m.x[i]);
  enclose(point);
  for (int i = 0; i < n_; ++i) {
    const IntervalVec3 V = miss(i);
    for (int k = 0; k < 2; ++k) F[3 * i + k] = dot(V, cross(surface_[i].gradient, m.c[i][k]));
    F[3 * i + 2] = surface_[i].g;
  }
}

bool EnclosedPath::derivatives(const PathBox& box, const PathMiddle& m, Rows& J) {
  enclose(box);
  for (int r = 0; r < 3 * n_; ++r) std::fill_n(J[r].begin(), 3 * n_, Interval(0.0));
  for (int i = 0; i < n_; ++i) {
    const IntervalVec3& N = surface_[i].gradient;
    const auto& c = m.c[i];
    if (dot(N, geometry::intervals(c[0].cross(c[1]))).contains_zero()) return false;
    for (int k = 0; k < 2; ++k) tangential(i, c[k], J[3 * i + k]);
    for (int a = 0; a < 3; ++a) J[3 * i + 2][3 * i + a] = N[a];
  }
  return true;
}

// t·∂V + (c × V)·H for t = ∇g × c.
void EnclosedPath::tangential(int i, const Vec3& c, Values& row) const {
  const geometry::IntervalSym3& H = surface_[i].hessian;
  const Interval columns[3][3] = {{H[0], H[1], H[2]}, {H[1], H[3], H[4]}, {H[2], H[4], H[5]}};
  const IntervalVec3 t = cross(surface_[i].gradient, c), u = Interval(-1.0) * cross(miss(i), c);
  for (int a = 0; a < 3; ++a) {
    Interval before(0.0), after(0.0);
    for (int b = 0; b < 3; ++b) {
      before += t[b] * segments_[i].bend[b][a];
      after += t[b] * segments_[i + 1].bend[b][a];
    }
    before *= Interval(index_[i]);
    after *= Interval(index_[i + 1]);
    row[3 * i + a] =
        u[0] * columns[a][0] + u[1] * columns[a][1] + u[2] * columns[a][2] + (before + after);
    if (i > 0) row[3 * (i - 1) + a] = -before;
    if (i + 1 < n_) row[3 * (i + 1) + a] = -after;
  }
}

}  // namespace caustic::solver
