// Height fields through samples on a grid (S22).
#include <algorithm>
#include <cmath>
#include <memory>

#include "geometry/grid_spline.h"
#include "geometry/sag.h"

namespace caustic::geometry {

namespace {

static_assert(kMinSamples == GridSpline::kMinSamples);

// Charts go on beyond the samples by this share of a cell, so that the edges are cut like an
// aperture.
constexpr double kBeyondGrid = 0.5;
// Rounding of a sum of coefficients, as a share of the largest: enclosures are widened by so much,
// and what is no larger is zero.
constexpr double kRoundings = 64.0 * kEpsilon;
// Up to so many cells a box is enclosed by the polynomials in them.
constexpr int kFewCells = 9;

HeightRanges hull(const HeightRanges& a, const HeightRanges& b) {
  HeightRanges both;
  for (int k = 0; k < 6; ++k) both[k] = hull(a[k], b[k]);
  return both;
}

// Hulls of blocks of 2^level × 2^level cells: a ray descends where its own heights overlap them.
class HullTree {
 public:
  explicit HullTree(const GridSpline& spline) {
    Level cells{spline.cells_u(), spline.cells_v(), {}};
    cells.hulls.reserve(static_cast<std::size_t>(cells.nu) * cells.nv);
    for (int j = 0; j < cells.nv; ++j) {
      for (int i = 0; i < cells.nu; ++i) cells.hulls.push_back(spline.hull(i, j));
    }
    levels_.push_back(std::move(cells));
    while (levels_.back().nu > 1 || levels_.back().nv > 1) levels_.push_back(above(levels_.back()));
  }

  /// Calls leaf(cell_u, cell_v, a, b) in order along (u, v) + t (du, dv), t in [t0, t1], for the
  /// cells where may_hold(hull, a, b) is true of them and of all blocks they lie in.
  template <class MayHold, class Leaf>
  void walk(const Vec2& at, const Vec2& direction, double t0, double t1, const MayHold& may_hold,
            const Leaf& leaf) const {
    descend(static_cast<int>(levels_.size()) - 1, 0, 0, at, direction, t0, t1, may_hold, leaf);
  }
  const HeightRanges& cell(int i, int j) const { return levels_[0].at(i, j); }
  /// Over the cells [i0, i1] × [j0, j1].
  HeightRanges over(int i0, int i1, int j0, int j1) const {
    HeightRanges all;
    all.fill(Interval::empty_set());
    gather(static_cast<int>(levels_.size()) - 1, 0, 0, {i0, i1, j0, j1}, all);
    return all;
  }

 private:
  struct Level {
    int nu, nv;
    std::vector<HeightRanges> hulls;
    const HeightRanges& at(int i, int j) const {
      return hulls[static_cast<std::size_t>(j) * nu + i];
    }
  };

  static Level above(const Level& below) {
    Level level{(below.nu + 1) / 2, (below.nv + 1) / 2, {}};
    for (int j = 0; j < level.nv; ++j) {
      for (int i = 0; i < level.nu; ++i) {
        HeightRanges sum = below.at(2 * i, 2 * j);
        for (int l = 2 * j; l < std::min(2 * j + 2, below.nv); ++l) {
          for (int k = 2 * i; k < std::min(2 * i + 2, below.nu); ++k) {
            sum = hull(sum, below.at(k, l));
          }
        }
        level.hulls.push_back(sum);
      }
    }
    return level;
  }

  void gather(int level, int i, int j, const std::array<int, 4>& want, HeightRanges& all) const {
    const int size = 1 << level, u = i * size, v = j * size;
    const Level& here = levels_[level];
    if (i >= here.nu || j >= here.nv) return;
    if (u > want[1] || u + size <= want[0] || v > want[3] || v + size <= want[2]) return;
    const auto within = [&](int begin, int count, int first, int last) {
      return begin >= first && std::min(begin + size, count) - 1 <= last;
    };
    if (within(u, levels_[0].nu, want[0], want[1]) && within(v, levels_[0].nv, want[2], want[3])) {
      all = hull(all, here.at(i, j));
      return;
    }
    for (int k = 0; k < 4; ++k) gather(level - 1, 2 * i + k % 2, 2 * j + k / 2, want, all);
  }

  // The blocks of a level are split at the same t by all who ask, so that no t is left out between
  // them.
  template <class MayHold, class Leaf>
  void descend(int level, int i, int j, const Vec2& at, const Vec2& direction, double a, double b,
               const MayHold& may_hold, const Leaf& leaf) const {
    if (!may_hold(levels_[level].at(i, j), a, b)) return;
    if (level == 0) return leaf(i, j, a, b);
    const Level& below = levels_[level - 1];
    const int child[2] = {2 * i, 2 * j}, count[2] = {below.nu, below.nv};
    double cuts[4] = {a, b, b, b}, middle[2];
    int n = 1;
    for (int k = 0; k < 2; ++k) {
      middle[k] = std::ldexp(child[k] + 1.0, level - 1) - GridSpline::kMargin;
      if (child[k] + 1 >= count[k]) middle[k] = kInfinity;
      const double cut = (middle[k] - at[k]) / direction[k];
      if (cut > a && cut < b) cuts[n++] = cut;
    }
    if (n == 3 && cuts[1] > cuts[2]) std::swap(cuts[1], cuts[2]);
    for (int k = 0; k < n; ++k) {
      if (k > 0 && cuts[k] == cuts[k + 1]) continue;
      const Vec2 where = at + 0.5 * (cuts[k] + cuts[k + 1]) * direction;
      descend(level - 1, child[0] + (where.x() > middle[0]), child[1] + (where.y() > middle[1]), at,
              direction, cuts[k], cuts[k + 1], may_hold, leaf);
    }
  }

  std::vector<Level> levels_;
};

class SagHeights final : public SagSurface, public std::enable_shared_from_this<SagHeights> {
 public:
  SagHeights(const Point& origin, const Mat3& axes, const HeightGrid& grid)
      : SagSurface(origin, axes),
        min_(grid.min),
        max_(grid.max),
        spacing_((grid.max - grid.min).cwiseQuotient(Vec2(grid.nx - 1, grid.ny - 1))),
        spline_(grid.nx, grid.ny, grid.values),
        tree_(spline_) {}

  bool at_most_quadratic() const override { return false; }

  void crossings(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    const LocalRay r = about_middle(ray);
    const auto may_hold = [&](const HeightRanges& f, double a, double b) {
      const double slack = kRoundings * (f[0].magnitude() + std::abs(r.z(a)) + std::abs(r.z(b)));
      return std::max(r.z(a), r.z(b)) >= f[0].lo - slack &&
             std::min(r.z(a), r.z(b)) <= f[0].hi + slack;
    };
    const auto leaf = [&](int i, int j, double a, double b) {
      const double size = tree_.cell(i, j)[0].magnitude() + std::abs(r.z(a));
      const auto value = [&](double t) {
        double d[1][1];
        spline_.derivatives<0>(r.u(t), r.v(t), d);
        return r.z(t) - d[0][0];
      };
      append_in_cell(along(r, i, j, a, b), value, kRoundings * size, r.shift, a, b, out);
    };
    tree_.walk(r.at, r.direction, t0 - r.shift, t1 - r.shift, may_hold, leaf);
  }
  void stationary(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    const LocalRay r = about_middle(ray);
    const double speed = std::abs(r.direction.x()) + std::abs(r.direction.y());
    const auto rounding = [&](const HeightRanges& f) {
      return kRoundings * (f[0].magnitude() * speed + std::abs(r.dz));
    };
    const auto may_hold = [&](const HeightRanges& f, double, double) {
      const Interval slope = r.direction.x() * f[1] + r.direction.y() * f[2];
      return slope.lo - rounding(f) <= r.dz && r.dz <= slope.hi + rounding(f);
    };
    const auto leaf = [&](int i, int j, double a, double b) {
      const auto slope = [&](double t) {
        double d[2][2];
        spline_.derivatives<1>(r.u(t), r.v(t), d);
        return (b - a) * (r.dz - d[1][0] * r.direction.x() - d[0][1] * r.direction.y());
      };
      append_in_cell(along(r, i, j, a, b).derivative(), slope, (b - a) * rounding(tree_.cell(i, j)),
                     r.shift, a, b, out);
    };
    tree_.walk(r.at, r.direction, t0 - r.shift, t1 - r.shift, may_hold, leaf);
  }

  bool convex(int) const override { return false; }
  Box bounds() const override {
    const int first = GridSpline::kMargin;
    const Interval z =
        tree_.over(first, spline_.cells_u() - first - 1, first, spline_.cells_v() - first - 1)[0];
    const Vec3 half(0.5 * (max_.x() - min_.x()), 0.5 * (max_.y() - min_.y()), 0.5 * (z.hi - z.lo));
    const Vec3 middle(min_.x() + half.x(), min_.y() + half.y(), z.lo + half.z());
    const Point center = o_ + axes_ * middle;
    const Vec3 reach = axes_.cwiseAbs() * half;
    return {center - reach, center + reach};
  }
  std::vector<Bound> own_bounds() const override {
    std::vector<Bound> bounds;
    for (int k = 0; k < 2; ++k) {
      const Direction axis = axes_.col(k);
      bounds.push_back(
          {Bound::Kind::half_space, o_ + max_[k] * axis, axis, 0.0, Bound::Origin::shape});
      bounds.push_back(
          {Bound::Kind::half_space, o_ + min_[k] * axis, -axis, 0.0, Bound::Origin::shape});
    }
    return bounds;
  }
  std::vector<Chart> charts(const Extent&) const override {
    const Vec2 begin = min_ - kBeyondGrid * spacing_, end = max_ + kBeyondGrid * spacing_;
    return {{[=, self = shared_from_this()](double s, double t) {
      const double x = begin.x() + s * (end.x() - begin.x());
      const double y = begin.y() + t * (end.y() - begin.y());
      return Point(self->o_ + self->axes_ * Vec3(x, y, self->height(x, y)));
    }}};
  }

 private:
  double height(double x, double y) const override {
    double d[1][1];
    spline_.derivatives<0>(u(x), v(y), d);
    return d[0][0];
  }
  double height_slope(double x, double y, Vec2& slope) const override {
    double d[2][2];
    spline_.derivatives<1>(u(x), v(y), d);
    slope = Vec2(d[1][0], d[0][1]).cwiseQuotient(spacing_);
    return d[0][0];
  }
  HeightJet height_jet(double x, double y) const override {
    double d[4][4];
    spline_.derivatives<3>(u(x), v(y), d);
    const double p = 1.0 / spacing_.x(), q = 1.0 / spacing_.y();
    return {d[0][0],
            {p * d[1][0], q * d[0][1]},
            {p * p * d[2][0], p * q * d[1][1], q * q * d[0][2]},
            {p * p * p * d[3][0], p * p * q * d[2][1], p * q * q * d[1][2], q * q * q * d[0][3]}};
  }
  // The part of the grid under a box: cells, and the box in samples.
  struct Under {
    Interval u, v;
    int i0, i1, j0, j1;
    bool few() const { return (i1 - i0 + 1) * (j1 - j0 + 1) <= kFewCells; }
  };
  Under under(const Interval& x, const Interval& y) const {
    const Interval u = (x - min_.x()) / Interval(spacing_.x()),
                   v = (y - min_.y()) / Interval(spacing_.y());
    const auto cell = [](double w, int cells) {
      return static_cast<int>(std::clamp(w + GridSpline::kMargin, 0.0, cells - 1.0));
    };
    return {u,
            v,
            cell(u.lo, spline_.cells_u()),
            cell(u.hi, spline_.cells_u()),
            cell(v.lo, spline_.cells_v()),
            cell(v.hi, spline_.cells_v())};
  }
  template <std::size_t kCount>
  void per_metre(const int (&orders)[kCount][2], std::array<Interval, kCount>& r) const {
    for (std::size_t k = 0; k < kCount; ++k) {
      for (int i = 0; i < orders[k][0]; ++i) r[k] = r[k] / Interval(spacing_.x());
      for (int i = 0; i < orders[k][1]; ++i) r[k] = r[k] / Interval(spacing_.y());
    }
  }
  // Cell by cell where there are few of them, by hulls where there are many.
  HeightRanges height_ranges(const Interval& x, const Interval& y) const override {
    const Under box = under(x, y);
    HeightRanges r;
    if (!box.few()) {
      r = tree_.over(box.i0, box.i1, box.j0, box.j1);
      for (Interval& range : r) range += kRoundings * r[0].magnitude() * Interval(-1.0, 1.0);
    } else {
      r.fill(Interval::empty_set());
      for (int j = box.j0; j <= box.j1; ++j) {
        for (int i = box.i0; i <= box.i1; ++i) r = hull(r, spline_.ranges(i, j, box.u, box.v));
      }
    }
    per_metre(kOrdersOfRanges, r);
    return r;
  }
  // Where there are many cells, nothing is known.
  ThirdRanges height_third_ranges(const Interval& x, const Interval& y) const override {
    const Under box = under(x, y);
    ThirdRanges r;
    r.fill(box.few() ? Interval::empty_set() : Interval::whole());
    if (!box.few()) return r;
    for (int j = box.j0; j <= box.j1; ++j) {
      for (int i = box.i0; i <= box.i1; ++i) {
        const ThirdRanges own = spline_.third_ranges(i, j, box.u, box.v);
        for (std::size_t k = 0; k < r.size(); ++k) r[k] = hull(r[k], own[k]);
      }
    }
    per_metre(kOrdersOfThirds, r);
    return r;
  }
  double u(double x) const { return (x - min_.x()) / spacing_.x(); }
  double v(double y) const { return (y - min_.y()) / spacing_.y(); }

  // In samples across and metres up; τ counts from the point nearest to the middle of the grid.
  struct LocalRay {
    double shift;
    Vec2 at, direction;
    double z0, dz;
    double u(double t) const { return at.x() + t * direction.x(); }
    double v(double t) const { return at.y() + t * direction.y(); }
    double z(double t) const { return z0 + t * dz; }
  };
  LocalRay about_middle(const Ray& ray) const {
    const Vec2 middle = 0.5 * (min_ + max_);
    const double shift = ray.nearest(o_ + axes_.leftCols<2>() * middle);
    const Vec3 y = local(ray.at(shift)), d = axes_.transpose() * ray.direction;
    return {shift, {u(y.x()), v(y.y())}, d.head<2>().cwiseQuotient(spacing_), y.z(), d.z()};
  }
  // g in one cell as a polynomial of (τ − a)/(b − a).
  LongPolynomial along(const LocalRay& r, int i, int j, double a, double b) const {
    LongPolynomial g = spline_.along(i, j, {r.u(a), r.v(a)}, (b - a) * r.direction);
    for (int k = 0; k <= g.degree; ++k) g.c[k] = -g.c[k];
    g.c[0] += r.z(a);
    g.c[1] += (b - a) * r.dz;
    return g;
  }
  // Roots in one cell. Where the next cell begins the values are the same to the last bit, so a
  // root is in one of both. Where all is rounding (a ray that runs in the surface) there are none.
  template <class Value>
  static void append_in_cell(const LongPolynomial& p, const Value& value, double rounding,
                             double shift, double a, double b, RayParameters& out) {
    if (std::all_of(p.c.begin(), p.c.end(), [&](double c) { return std::abs(c) <= rounding; }))
      return;
    const auto at = [&](double w) { return w == 1.0 ? b : a + w * (b - a); };
    const auto value_at = [&](double w) { return value(at(w)); };
    const std::size_t first = out.size();
    isolated_roots(PolynomialWithValues(p, value_at, rounding), 0.0, 1.0, out);
    for (std::size_t i = first; i < out.size(); ++i) out[i] = at(out[i]) + shift;
    if (first > 0 && first < out.size() && out[first] == out[first - 1]) {
      out.erase(out.begin() + static_cast<std::ptrdiff_t>(first));
    }
  }

  Vec2 min_, max_, spacing_;
  GridSpline spline_;
  HullTree tree_;
};

}  // namespace

SurfacePtr make_sag(const Point& origin, const Mat3& axes, const HeightGrid& grid) {
  return std::make_shared<SagHeights>(origin, axes, grid);
}

}  // namespace caustic::geometry
