#include "solver/certify_paths.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "geometry/isolated_point.h"

namespace caustic::solver {

using geometry::Interval;
using geometry::IntervalVec3;
using geometry::SurfaceEnclosure;

namespace {

constexpr int kMaxUnknowns = 3 * kMaxHops;
// A box is widened by this share before it is asked whether it holds one root, so that a root on
// the face between two boxes is inside of one of them.
constexpr double kInflate = 0.2;
// Widths of directions, and of normals as a share of them, up to which that is tried.
constexpr double kLinear = 0.5;
// A contraction that leaves more than this share of the widest side is not worth another round.
constexpr double kWorthwhile = 0.7;
// Rounds of Krawczyk's operator on a proven box: it converges quadratically.
constexpr int kSharpen = 50;
// Proven boxes sharpened to this share of the scene hold the same root if they meet.
constexpr double kSameRoot = 1e-9;

using Midpoint = std::array<Point, kMaxHops>;

struct PathBox {
  std::array<IntervalVec3, kMaxHops> x;
};

Interval dot(const IntervalVec3& a, const IntervalVec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
IntervalVec3 cross(const IntervalVec3& a, const Vec3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
IntervalVec3 subtract(const IntervalVec3& a, const IntervalVec3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
IntervalVec3 scaled(const Interval& k, const IntervalVec3& a) {
  return {k * a[0], k * a[1], k * a[2]};
}

// One segment: unit direction w along the light, and the upper half of (I − wwᵀ)/d.
struct EnclosedSegment {
  IntervalVec3 w;
  Interval bend[3][3];
};

// One choice of sides for the surfaces that refract, and with it all indices.
class Search {
 public:
  Search(const std::vector<PathSurface>& surfaces, const std::vector<geometry::Box>& regions,
         const Light& light, const Point& to, double scale, const CertifyOptions& options,
         const std::vector<int>& sides, CertifiedRoots& result)
      : surfaces_(surfaces),
        to_(geometry::intervals(to)),
        scale_(scale),
        options_(options),
        sides_(sides),
        result_(result),
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
    PathBox whole;
    for (int i = 0; i < n_; ++i) whole.x[i] = geometry::intervals(regions[i]);
    stack_.push_back(whole);
  }

  void run() {
    while (!stack_.empty()) {
      const bool late =
          options_.budget && result_.boxes % kBetweenChecks == 0 && options_.budget->out_of_time();
      if (late || result_.boxes >= options_.max_boxes) {
        result_.undecided += stack_.size();
        return;
      }
      PathBox box = stack_.back();
      stack_.pop_back();
      ++result_.boxes;
      treat(box);
    }
  }

 private:
  enum class Verdict { empty, one, contracted, none };

  void treat(PathBox& box);
  bool impossible(PathBox& box);
  bool follow(PathBox& box, int from, int to);
  bool chord_too_short(const PathBox& box, int i) const;
  bool promising(const PathBox& box) const;
  Verdict krawczyk(const PathBox& widened, PathBox& box);
  void accept(PathBox box);
  void divide(const PathBox& box);
  bool holds_only_a_point(const PathBox& box);
  void enclose(const PathBox& box);
  void enclose_spans(const PathBox& box);
  Interval residual(int i, int row, const IntervalVec3& tangent) const;
  double widest(const PathBox& box, int& hop, int& axis) const;
  IntervalVec3 miss(int i) const {
    return subtract(scaled(Interval(index_[i]), spans_[i].w),
                    scaled(Interval(index_[i + 1]), spans_[i + 1].w));
  }

  const std::vector<PathSurface>& surfaces_;
  IntervalVec3 from_, to_;
  std::optional<EnclosedSegment> beam_;  // the first segment, if it does not begin at a point
  double scale_;
  const CertifyOptions& options_;
  const std::vector<int>& sides_;
  CertifiedRoots& result_;
  int n_;
  std::vector<double> index_;
  std::vector<PathBox> stack_;
  std::vector<PathBox> proven_;
  // Of the box looked at.
  std::array<SurfaceEnclosure, kMaxHops> surface_;
  std::array<EnclosedSegment, kMaxHops + 1> spans_;
};

Interval clipped(const Interval& a) { return geometry::intersection(a, Interval(-1.0, 1.0)); }

EnclosedSegment span_between(const IntervalVec3& a, const IntervalVec3& b) {
  EnclosedSegment s;
  const IntervalVec3 v = subtract(b, a);
  const Interval d = sqrt(geometry::squared_norm(v));
  for (int i = 0; i < 3; ++i) s.w[i] = clipped(v[i] / d);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j <= i; ++j) {
      const Interval ww = i == j ? Interval(1.0) - sqr(s.w[i]) : -(s.w[i] * s.w[j]);
      s.bend[i][j] = s.bend[j][i] = ww / d;
    }
  }
  return s;
}

void Search::enclose(const PathBox& box) {
  for (int i = 0; i < n_; ++i) surface_[i] = surfaces_[i].shape->enclose(box.x[i]);
  enclose_spans(box);
}

void Search::enclose_spans(const PathBox& box) {
  spans_[0] = beam_ ? *beam_ : span_between(from_, box.x[0]);
  for (int k = 1; k <= n_; ++k) {
    spans_[k] = span_between(box.x[k - 1], k == n_ ? to_ : box.x[k]);
  }
}

// (S42): what leaves hop `at` towards its neighbour `to`, before or after it, has the direction
// that the law gives to what comes from the other side, and the neighbour lies along it. Both are
// cut down to that; true if nothing is left.
bool Search::follow(PathBox& box, int at, int to) {
  const bool forward = to > at;
  const EnclosedSegment& given = spans_[forward ? at : at + 1];
  EnclosedSegment& leaving = spans_[forward ? at + 1 : at];
  const IntervalVec3& N = surface_[at].gradient;
  const Interval NN = geometry::squared_norm(N);
  if (!(NN.lo > 0.0)) return false;
  const Interval along = dot(N, given.w);
  IntervalVec3 w;
  if (surfaces_[at].reflects) {
    const Interval twice = 2.0 * along / NN;
    for (int a = 0; a < 3; ++a) w[a] = given.w[a] - twice * N[a];
  } else {
    const double eta = forward ? index_[at] / index_[at + 1] : index_[at + 1] / index_[at];
    // Light passes: both directions have the sign that `sides_` gives to N·w, here N pointing on.
    const Interval root = sqrt((1.0 - sqr(Interval(eta))) * NN + sqr(Interval(eta)) * sqr(along));
    if (root.empty()) return true;
    const Interval share = ((sides_[at] > 0 ? -root : root) - eta * along) / NN;
    for (int a = 0; a < 3; ++a) w[a] = Interval(eta) * given.w[a] + share * N[a];
  }
  for (int a = 0; a < 3; ++a) {
    leaving.w[a] = geometry::intersection(leaving.w[a], w[a]);
    if (leaving.w[a].empty()) return true;
  }
  // Along the axis that light follows best: its length, and with it the other coordinates.
  const IntervalVec3 v = subtract(box.x[to], box.x[at]);
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

// (S40): the chord from hop i to the next on the same surface is at least twice |∇g·w| over the
// Hessian, at each of its ends; where light comes from or goes to on the other side says how much
// that is.
bool Search::chord_too_short(const PathBox& box, int i) const {
  const auto steepness = [&](int hop, const IntervalVec3& other, double eta) {
    const IntervalVec3& N = surface_[hop].gradient;
    return ((1.0 - sqr(Interval(eta))) * geometry::squared_norm(N) +
            sqr(Interval(eta)) * sqr(dot(N, other)))
        .lo;
  };
  // Index at the segment before hop k is index_[k].
  const double most = std::max(steepness(i, spans_[i].w, index_[i] / index_[i + 1]),
                               steepness(i + 1, spans_[i + 2].w, index_[i + 2] / index_[i + 1]));
  if (!(most > 0.0)) return false;
  IntervalVec3 around;
  for (int a = 0; a < 3; ++a) around[a] = hull(box.x[i][a], box.x[i + 1][a]);
  const geometry::IntervalSym3 H = surfaces_[i].shape->enclose(around).hessian;
  const Interval HH = sqr(H[0]) + sqr(H[3]) + sqr(H[5]) + 2.0 * (sqr(H[1]) + sqr(H[2]) + sqr(H[4]));
  const Interval dd = geometry::squared_norm(subtract(box.x[i + 1], box.x[i]));
  return (Interval(4.0) * Interval(most)).lo > (HH * dd).hi;
}

// No point of the box is on the surfaces, sends light the right way, or satisfies Fermat's
// condition ∇g × (n_{i−1} w_{i−1} − n_i w_i) = 0.
bool Search::impossible(PathBox& box) {
  for (int i = 0; i < n_; ++i) {
    surface_[i] = surfaces_[i].shape->enclose(box.x[i]);
    if (!surface_[i].g.contains_zero()) return true;
    Point middle, half;
    for (int a = 0; a < 3; ++a) {
      middle[a] = box.x[i][a].middle();
      half[a] = 0.5 * box.x[i][a].width();
    }
    const double radius = half.norm() * (1.0 + 1e-12);
    for (const auto& bound : *surfaces_[i].bounds) {
      if (bound.lower_bound_within(middle, radius) > 1e-12 * scale_) return true;
    }
  }
  enclose_spans(box);
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
    const IntervalVec3& N = surface_[i].gradient;
    const Interval in = dot(N, spans_[i].w), out = dot(N, spans_[i + 1].w);
    if (surfaces_[i].reflects) {
      if ((in.lo > 0.0 && out.lo > 0.0) || (in.hi < 0.0 && out.hi < 0.0)) return true;
    } else if (sides_[i] > 0 ? in.lo > 0.0 || out.lo > 0.0 : in.hi < 0.0 || out.hi < 0.0) {
      return true;
    }
    const IntervalVec3 V = miss(i);
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      if (!(N[b] * V[c] - N[c] * V[b]).contains_zero()) return true;
    }
  }
  return false;
}

// Krawczyk's operator can contract only where directions and normals vary little; asking costs less
// than trying. `impossible` has just enclosed this box.
bool Search::promising(const PathBox& box) const {
  for (int k = 0; k <= n_; ++k) {
    for (const Interval& w : spans_[k].w) {
      if (w.width() > kLinear) return false;
    }
  }
  for (int i = 0; i < n_; ++i) {
    Point m;
    for (int a = 0; a < 3; ++a) m[a] = box.x[i][a].middle();
    Vec3 N;
    surfaces_[i].shape->value_gradient(m, N);
    const double length = N.norm();
    for (int a = 0; a < 3; ++a) {
      if (!(surface_[i].gradient[a].width() <= kLinear * length)) return false;
    }
  }
  return true;
}

double Search::widest(const PathBox& box, int& hop, int& axis) const {
  double width = -1.0;
  for (int i = 0; i < n_; ++i) {
    for (int a = 0; a < 3; ++a) {
      if (box.x[i][a].width() <= width) continue;
      width = box.x[i][a].width();
      hop = i;
      axis = a;
    }
  }
  return width;
}

// (S39): K = m − Y F(m) + (I − Y F′(X)) (X − m) for the 3N equations V·(∇g × c₁) = 0, V·(∇g × c₂) =
// 0, g = 0 per hop, c₁ and c₂ tangents in the middle.
Search::Verdict Search::krawczyk(const PathBox& X, PathBox& box) {
  Midpoint m;
  std::array<geometry::Frame, kMaxHops> frames{
      geometry::Frame(Vec3::UnitZ()), geometry::Frame(Vec3::UnitZ()),
      geometry::Frame(Vec3::UnitZ()), geometry::Frame(Vec3::UnitZ()),
      geometry::Frame(Vec3::UnitZ()), geometry::Frame(Vec3::UnitZ()),
      geometry::Frame(Vec3::UnitZ()), geometry::Frame(Vec3::UnitZ())};
  PathBox point;
  for (int i = 0; i < n_; ++i) {
    for (int a = 0; a < 3; ++a) m[i][a] = X.x[i][a].middle();
    Vec3 N;
    surfaces_[i].shape->value_gradient(m[i], N);
    const double length = N.norm();
    if (!(length > 0.0) || !std::isfinite(length)) return Verdict::none;
    frames[i] = geometry::Frame(N / length);
    point.x[i] = geometry::intervals(m[i]);
  }
  const int size = 3 * n_;
  enclose(point);
  std::array<Interval, kMaxUnknowns> F;
  for (int i = 0; i < n_; ++i) {
    const IntervalVec3 V = miss(i);
    F[3 * i] = dot(V, cross(surface_[i].gradient, frames[i].e1));
    F[3 * i + 1] = dot(V, cross(surface_[i].gradient, frames[i].e2));
    F[3 * i + 2] = surface_[i].g;
  }

  enclose(X);
  std::array<std::array<Interval, kMaxUnknowns>, kMaxUnknowns> J;
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) J[r][c] = Interval(0.0);
  }
  for (int i = 0; i < n_; ++i) {
    const auto& [g, N, H] = surface_[i];
    const Interval along = dot(N, geometry::intervals(frames[i].e1.cross(frames[i].e2)));
    // Only then do the two tangential equations say that V is along ∇g.
    if (along.contains_zero()) return Verdict::none;
    const IntervalVec3 V = miss(i);
    const Interval Hm[3][3] = {{H[0], H[1], H[2]}, {H[1], H[3], H[4]}, {H[2], H[4], H[5]}};
    for (int row = 0; row < 2; ++row) {
      const Vec3& c = row == 0 ? frames[i].e1 : frames[i].e2;
      const IntervalVec3 t = cross(N, c), u = scaled(Interval(-1.0), cross(V, c));  // u = c × V
      for (int a = 0; a < 3; ++a) {
        Interval own = u[0] * Hm[0][a] + u[1] * Hm[1][a] + u[2] * Hm[2][a];
        Interval before(0.0), after(0.0);
        for (int b = 0; b < 3; ++b) {
          before += t[b] * spans_[i].bend[b][a];
          after += t[b] * spans_[i + 1].bend[b][a];
        }
        before *= Interval(index_[i]);
        after *= Interval(index_[i + 1]);
        own += before + after;
        J[3 * i + row][3 * i + a] = own;
        if (i > 0) J[3 * i + row][3 * (i - 1) + a] = -before;
        if (i + 1 < n_) J[3 * i + row][3 * (i + 1) + a] = -after;
      }
    }
    for (int a = 0; a < 3; ++a) J[3 * i + 2][3 * i + a] = N[a];
  }

  using Matrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMaxUnknowns, kMaxUnknowns>;
  Matrix middle(size, size);
  for (int r = 0; r < size; ++r) {
    for (int c = 0; c < size; ++c) middle(r, c) = J[r][c].middle();
  }
  if (!middle.allFinite()) return Verdict::none;
  Matrix Y = middle.inverse();
  if (!Y.allFinite()) return Verdict::none;

  bool inside = true;
  Verdict verdict = Verdict::none;
  for (int r = 0; r < size; ++r) {
    const int hop = r / 3, axis = r % 3;
    Interval K(m[hop][axis]);
    for (int c = 0; c < size; ++c) K -= Y(r, c) * F[c];
    for (int c = 0; c < size; ++c) {
      Interval slope(r == c ? 1.0 : 0.0);
      for (int k = 0; k < size; ++k) slope -= Y(r, k) * J[k][c];
      K += slope * (X.x[c / 3][c % 3] - m[c / 3][c % 3]);
    }
    const Interval& wide = X.x[hop][axis];
    inside &= K.lo > wide.lo && K.hi < wide.hi;
    const Interval cut = geometry::intersection(box.x[hop][axis], K);
    if (cut.empty()) {
      verdict = Verdict::empty;
      box.x[hop][axis] = geometry::intersection(wide, K);
      continue;
    }
    box.x[hop][axis] = cut;
  }
  // Inside: there is exactly one root in X, be it in the box or beside it.
  if (inside) return Verdict::one;
  return verdict == Verdict::empty ? Verdict::empty : Verdict::contracted;
}

void Search::treat(PathBox& box) {
  for (;;) {
    if (impossible(box)) return;
    for (const PathBox& known : proven_) {
      bool within = true;
      for (int i = 0; i < n_ && within; ++i) {
        for (int a = 0; a < 3; ++a) within &= known.x[i][a].contains(box.x[i][a]);
      }
      if (within) return;
    }
    if (!promising(box)) return divide(box);
    int hop = 0, axis = 0;
    const double before = widest(box, hop, axis);
    PathBox wide = box;
    for (int i = 0; i < n_; ++i) {
      for (int a = 0; a < 3; ++a) {
        const double margin = kInflate * before;
        wide.x[i][a] = {box.x[i][a].lo - margin, box.x[i][a].hi + margin};
      }
    }
    PathBox contracted = box;
    const Verdict verdict = krawczyk(wide, contracted);
    if (verdict == Verdict::empty) return;
    if (verdict == Verdict::one) {
      proven_.push_back(wide);
      return accept(wide);
    }
    if (verdict == Verdict::contracted) box = contracted;
    const double after = widest(box, hop, axis);
    if (after > kWorthwhile * before) return divide(box);
  }
}

// Sharpens a proven box to a point, and keeps it if the optics obeys and it is new.
void Search::accept(PathBox box) {
  for (int k = 0; k < kSharpen; ++k) {
    PathBox next = box;
    const Verdict verdict = krawczyk(box, next);
    int hop = 0, axis = 0;
    const double before = widest(box, hop, axis), after = widest(next, hop, axis);
    if (verdict == Verdict::empty || verdict == Verdict::none) break;
    box = next;
    if (!(after < before)) break;
  }
  if (impossible(box)) return;
  int hop = 0, axis = 0;
  // Not sharp enough to tell it from another.
  result_.undecided += widest(box, hop, axis) > kSameRoot * scale_;
  std::vector<Point> root(n_);
  for (int i = 0; i < n_; ++i) {
    for (int a = 0; a < 3; ++a) root[i][a] = box.x[i][a].middle();
  }
  for (const auto& other : result_.roots) {
    double distance = 0.0;
    for (int i = 0; i < n_; ++i) distance = std::max(distance, (other[i] - root[i]).norm());
    if (distance <= kSameRoot * scale_) return;
  }
  result_.roots.push_back(std::move(root));
}

// (S41): ∇g may vanish and the Hessian is definite, so g = 0 is an isolated point of no direction,
// or a sheet that closes within boxes of this size.
bool Search::holds_only_a_point(const PathBox& box) {
  for (int i = 0; i < n_; ++i) {
    if (geometry::holds_only_a_point(surfaces_[i].shape->enclose(box.x[i]))) return true;
  }
  return false;
}

void Search::divide(const PathBox& box) {
  int hop = 0, axis = 0;
  const double width = widest(box, hop, axis);
  if (!(width > options_.smallest * scale_)) {
    result_.undecided += !holds_only_a_point(box);
    return;
  }
  // Not in the middle: symmetric scenes have their roots there.
  const Interval& side = box.x[hop][axis];
  const double cut = side.lo + 0.4873 * side.width();
  PathBox lower = box, upper = box;
  lower.x[hop][axis].hi = cut;
  upper.x[hop][axis].lo = cut;
  stack_.push_back(lower);
  stack_.push_back(upper);
}

}  // namespace

CertifiedRoots certify_paths(const std::vector<PathSurface>& surfaces,
                             const std::vector<geometry::Box>& regions, const Light& light,
                             const Point& to, double scale, const CertifyOptions& options) {
  CertifiedRoots result;
  // Light may come to a refracting surface from either side; what it obeys then differs.
  std::vector<int> refracting;
  for (int i = 0; i < static_cast<int>(surfaces.size()); ++i) {
    if (!surfaces[i].reflects) refracting.push_back(i);
  }
  for (int choice = 0; choice < 1 << refracting.size(); ++choice) {
    std::vector<int> sides(surfaces.size(), 0);
    for (std::size_t k = 0; k < refracting.size(); ++k) {
      sides[refracting[k]] = choice >> k & 1 ? -1 : 1;
    }
    Search(surfaces, regions, light, to, scale, options, sides, result).run();
  }
  return result;
}

}  // namespace caustic::solver
