#include "solver/enclosed_map.h"

#include <algorithm>

#include "geometry/narrowed.h"
#include "solver/enclosed_share.h"

namespace caustic::solver {

using geometry::constant_jet;
using geometry::GraphChart;
using geometry::IntervalJet;
using geometry::IntervalVec3;
using geometry::IntervalVecJet;

namespace {

// Rounds of interval Newton on the heights of a cell, and the share that is worth another.
constexpr int kHeightRounds = 6;
constexpr double kHeightShare = 0.7;

Slopes first_order(const IntervalJet& a) { return {a.v, a.s, a.t}; }
Slopes scaled(const Slopes& a, double k) { return {k * a.v, k * a.s, k * a.t}; }
Slopes combined(const Slopes& a, const Slopes& b, double k) {
  return {a.v + k * b.v, a.s + k * b.s, a.t + k * b.t};
}
Slopes product(const IntervalJet& a, const IntervalJet& b) {
  return {a.v * b.v, a.v * b.s + a.s * b.v, a.v * b.t + a.t * b.v};
}
Slopes difference(const Slopes& a, const Slopes& b) { return combined(a, b, -1.0); }

// Two enclosures of one thing; rounding alone parts them.
Interval meet(const Interval& a, const Interval& b) {
  const Interval both = intersection(a, b);
  return both.empty() ? b : both;
}

Interval centred(const Slopes& over, const Interval& middle, const Interval& ds,
                 const Interval& dt) {
  return meet(over.v, middle + over.s * ds + over.t * dt);
}

}  // namespace

// Intermediate results in the order in which they come. What the middle of a cell gave narrows what
// the whole of it gives, by mean values of the function and of its slopes (S72).
class EnclosedMap::Trail {
 public:
  void begin_middle() {
    middle_.clear();
    recording_ = true;
  }
  void begin_cell(const Interval& ds, const Interval& dt) {
    next_ = 0;
    recording_ = false;
    ds_ = ds;
    dt_ = dt;
  }
  void begin_alone() {
    middle_.clear();
    next_ = 0;
    recording_ = false;
  }
  IntervalJet operator()(const IntervalJet& a) {
    if (recording_) middle_.push_back(a);
    if (recording_ || next_ == middle_.size()) return a;
    const IntervalJet& m = middle_[next_++];
    const Interval s = meet(a.s, m.s + a.ss * ds_ + a.st * dt_);
    const Interval t = meet(a.t, m.t + a.st * ds_ + a.tt * dt_);
    return {meet(a.v, m.v + s * ds_ + t * dt_), s, t, a.ss, a.st, a.tt};
  }

 private:
  std::vector<IntervalJet> middle_;
  std::size_t next_ = 0;
  bool recording_ = false;
  Interval ds_{0.0}, dt_{0.0};
};

struct EnclosedMap::Result {
  bool dark = false, regular = false;
  Slopes a, flux;
  std::vector<Slopes> bounds;
};

bool EnclosedMap::encloses(const ForwardMap& map) { return map.hop_count() == 1; }

EnclosedMap::EnclosedMap(const ForwardMap& map)
    : map_(map), shape_(map.shape()), optics_(map.mirror().optics) {
  const auto* point = std::get_if<PointLight>(&map.system().light());
  point_source_ = point != nullptr;
  source_ = point ? point->position : std::get<CollimatedLight>(map.system().light()).direction;
}

bool EnclosedMap::narrow(const GraphChart& chart, GraphCell& cell) const {
  const std::size_t i = chart.first(), j = chart.second(), k = chart.along();
  IntervalVec3 box, middle;
  box[i] = cell.s;
  box[j] = cell.t;
  middle[i] = cell.s.middle();
  middle[j] = cell.t.middle();
  for (int round = 0; round < kHeightRounds; ++round) {
    box[k] = cell.z;
    middle[k] = cell.z.middle();
    const auto over = shape_.enclose(box);
    if (!over.g.contains_zero()) return false;
    IntervalVec3 N = over.gradient;
    if (N[k].contains_zero()) N = geometry::narrowed(shape_, box).gradient;
    if (N[k].contains_zero()) break;
    const Interval g =
        shape_.enclose(middle).g + N[i] * (cell.s - middle[i]) + N[j] * (cell.t - middle[j]);
    const Interval next = middle[k] - g / N[k];
    cell.whole |= next.lo > cell.z.lo && next.hi < cell.z.hi;
    const Interval cut = intersection(cell.z, next);
    if (cut.empty()) return false;
    const bool worthwhile = cut.width() < kHeightShare * cell.z.width();
    cell.z = cut;
    if (!worthwhile) break;
  }
  return !intersection(cell.z, chart.own[k]).empty();
}

// Bounds are functions of the place; an expression's slopes are not enclosed.
Slopes EnclosedMap::bound(const geometry::Bound& b, const IntervalVecJet& x) const {
  using Kind = geometry::Bound::Kind;
  if (b.kind == Kind::expression) {
    const geometry::Box box{{x[0].v.lo, x[1].v.lo, x[2].v.lo}, {x[0].v.hi, x[1].v.hi, x[2].v.hi}};
    const Interval range(-geometry::kInfinity, b.largest_in(box));
    const double radius = 0.5 * box.diagonal() * (1.0 + 1e-12);
    return {Interval(b.lower_bound_within(box.center(), radius), range.hi), Interval::whole(),
            Interval::whole()};
  }
  const IntervalVecJet y = x - b.point;
  if (b.kind == Kind::half_space) return first_order(geometry::dot(b.axis, y));
  IntervalJet square = geometry::squared_norm(y);
  if (b.kind == Kind::cylinder) {
    // |y|² − (a·y)² as the squares across the axis.
    const geometry::Frame frame(b.axis);
    square =
        geometry::square(geometry::dot(frame.e1, y)) + geometry::square(geometry::dot(frame.e2, y));
  }
  const Interval radius(b.radius);
  Slopes h = scaled(first_order(square), 0.5);
  h = {h.v / radius - 0.5 * radius, h.s / radius, h.t / radius};
  return h;
}

void EnclosedMap::follow(const GraphChart& chart, const GraphCell& cell, Trail& trail,
                         Result& out) const {
  const std::size_t i = chart.first(), j = chart.second(), k = chart.along();
  IntervalVec3 box;
  box[i] = cell.s;
  box[j] = cell.t;
  box[k] = cell.z;
  auto g = shape_.enclose(box);
  const auto third = shape_.enclose_third(box);
  const auto H = [&](std::size_t a, std::size_t b) -> const Interval& {
    constexpr std::size_t kPacked[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
    return g.hessian[kPacked[a][b]];
  };
  const auto T = [&](std::size_t a, std::size_t b, std::size_t c) -> const Interval& {
    return third[geometry::packed_index(static_cast<int>(a), static_cast<int>(b),
                                        static_cast<int>(c))];
  };

  // (S71): the graph and ∇g along it, first as the box has it, then narrowed by its slopes.
  Interval z_s, z_t;
  IntervalVec3 H_s, H_t;  // Hessian times x_s, x_t
  const auto find_slopes = [&] {
    z_s = -(g.gradient[i] / g.gradient[k]);
    z_t = -(g.gradient[j] / g.gradient[k]);
    for (std::size_t a = 0; a < 3; ++a) {
      H_s[a] = H(a, i) + H(a, k) * z_s;
      H_t[a] = H(a, j) + H(a, k) * z_t;
    }
  };
  find_slopes();
  for (std::size_t a = 0; a < 3; ++a) {
    const Interval unknown = Interval::whole();
    g.gradient[a] = trail({g.gradient[a], H_s[a], H_t[a], unknown, unknown, unknown}).v;
  }
  find_slopes();
  const Interval z_ss = -((H_s[i] + z_s * H_s[k]) / g.gradient[k]);
  const Interval z_st = -((H_t[i] + z_s * H_t[k]) / g.gradient[k]);
  const Interval z_tt = -((H_t[j] + z_t * H_t[k]) / g.gradient[k]);
  IntervalVecJet x, N;
  x[i] = {cell.s, 1.0, 0.0, 0.0, 0.0, 0.0};
  x[j] = {cell.t, 0.0, 1.0, 0.0, 0.0, 0.0};
  x[k] = {cell.z, z_s, z_t, z_ss, z_st, z_tt};
  for (std::size_t a = 0; a < 3; ++a) {
    const Interval T_ss = T(a, i, i) + 2.0 * z_s * T(a, i, k) + sqr(z_s) * T(a, k, k);
    const Interval T_st = T(a, i, j) + z_t * T(a, i, k) + z_s * T(a, j, k) + z_s * z_t * T(a, k, k);
    const Interval T_tt = T(a, j, j) + 2.0 * z_t * T(a, j, k) + sqr(z_t) * T(a, k, k);
    N[a] = {g.gradient[a],        H_s[a], H_t[a], T_ss + H(a, k) * z_ss, T_st + H(a, k) * z_st,
            T_tt + H(a, k) * z_tt};
  }

  // Incident light, and what falls on the surface (S71).
  IntervalVecJet d;
  if (point_source_) {
    d = x - source_;
  } else {
    for (std::size_t a = 0; a < 3; ++a) d[a] = constant_jet(source_[static_cast<int>(a)]);
  }
  const double side = map_.side();
  const IntervalJet NN = trail(geometry::squared_norm(N));
  const IntervalJet dN = trail(point_source_ ? geometry::dot(d, N) : geometry::dot(source_, N));
  const int upward = sign_of(g.gradient[k]);
  IntervalJet across = double(upward) * N[k];
  const IntervalJet dd = trail(geometry::squared_norm(d));
  if (point_source_) across = across * dd * sqrt(dd);
  IntervalJet arriving = dN / across;
  if (!optics_.constant_share()) {
    const IntervalJet cosine = trail(-side * (dN / sqrt(dd * NN)));
    const bool reflects = optics_.kind == Optics::Kind::mirror;
    const auto index = reflects ? *optics_.metal : 1.0 / optics_.eta(map_.side());
    const IntervalJet reflected = trail(enclosed_reflectance(index, cosine));
    arriving = arriving * (reflects ? reflected : constant_jet(1.0) - reflected);
  }
  out.flux = scaled(first_order(trail(arriving)), -side * map_.strength());

  // The bounce (S3), (S24), in the receiver's axes, and the arrival (S4).
  IntervalJet along_d = constant_jet(1.0), along_N;
  bool total_reflection = false;
  if (optics_.kind == Optics::Kind::mirror) {
    along_N = trail(-2.0 * (dN / NN));
  } else {
    const double eta = optics_.eta(map_.side());
    const Interval loss = Interval(1.0) - sqr(Interval(eta));
    const IntervalJet headroom = trail(constant_jet(loss) * (dd * NN) +
                                       constant_jet(sqr(Interval(eta))) * geometry::square(dN));
    out.dark = headroom.v.hi < 0.0;
    total_reflection = !(headroom.v.lo > 0.0);
    if (out.dark) return;
    along_d = constant_jet(eta);
    along_N = trail(-1.0 * ((eta * dN + side * sqrt(headroom)) / NN));
  }
  const auto& receiver = map_.receiver();
  const IntervalVecJet y = x - receiver.origin;
  const auto direction_along = [&](const Vec3& axis) {
    const IntervalJet own =
        point_source_ ? along_d * geometry::dot(axis, d)
                      : along_d * constant_jet(geometry::dot(axis, geometry::intervals(source_)));
    return trail(own + along_N * geometry::dot(axis, N));
  };
  const IntervalJet D_m = direction_along(receiver.m), y_m = geometry::dot(receiver.m, y);
  const IntervalJet D[2] = {direction_along(receiver.u), direction_along(receiver.v)};
  const IntervalJet at[2] = {geometry::dot(receiver.u, y), geometry::dot(receiver.v, y)};
  const int facing = sign_of(D_m.v);

  // (S74). P = (m·D) q is smooth also where q has a pole.
  out.bounds.clear();
  for (const auto& b : map_.mirror().bounds) out.bounds.push_back(bound(b, x));
  for (const double end : {1.0, -1.0}) {
    const Interval last = end > 0.0 ? chart.own[k].hi : -chart.own[k].lo;
    out.bounds.push_back({end * x[k].v - last, end * z_s, end * z_t});
  }
  out.bounds.push_back(scaled(first_order(dN), side));
  out.dark = false;
  if (facing != 0) out.bounds.push_back(scaled(first_order(y_m), facing));
  for (int c = 0; c < 2; ++c) {
    const Slopes P = difference(product(at[c], D_m), product(y_m, D[c]));
    const double half = receiver.half[c];
    const auto beyond = [&](double edge) {
      const Slopes h = combined(P, first_order(D_m), -edge);
      const Interval unknown = Interval::whole();
      return first_order(trail({h.v, h.s, h.t, unknown, unknown, unknown}));
    };
    const Slopes above = beyond(half), below = beyond(-half);
    out.dark |= sign_of(above.v) * sign_of(below.v) > 0;
    if (facing == 0) continue;
    out.bounds.push_back(scaled(above, facing));
    out.bounds.push_back(scaled(below, -facing));
  }

  out.regular = facing != 0 && upward != 0 && !total_reflection;
  if (!out.regular) {
    out.a = {Interval::whole(), Interval::whole(), Interval::whole()};
    return;
  }
  const IntervalJet lambda = trail(-1.0 * (y_m / D_m));
  const IntervalJet q[2] = {trail(at[0] + lambda * D[0]), trail(at[1] + lambda * D[1])};
  const auto det = [](const Interval& a0, const Interval& a1, const Interval& b0,
                      const Interval& b1) { return a0 * b1 - a1 * b0; };
  const Slopes a{det(q[0].s, q[1].s, q[0].t, q[1].t),
                 det(q[0].ss, q[1].ss, q[0].t, q[1].t) + det(q[0].s, q[1].s, q[0].st, q[1].st),
                 det(q[0].st, q[1].st, q[0].t, q[1].t) + det(q[0].s, q[1].s, q[0].tt, q[1].tt)};
  out.a = scaled(a, side * upward);
}

void EnclosedMap::enclose(const GraphChart& chart, const GraphCell& cell, EnclosedField& f) const {
  thread_local Trail trail;
  thread_local Result over, middle;
  f.ds = f.dt = Interval(0.0);
  // Mean values are taken along the graph, so there has to be one all over the cell.
  const bool thin = cell.s.width() == 0.0 && cell.t.width() == 0.0;
  bool centred_form = cell.whole && !thin;
  if (centred_form) {
    GraphCell point{cell.s.middle(), cell.t.middle(), cell.z, true};
    narrow(chart, point);
    trail.begin_middle();
    follow(chart, point, trail, middle);
    centred_form = middle.regular && !middle.dark;
    f.ds = cell.s - point.s;
    f.dt = cell.t - point.t;
  }
  centred_form ? trail.begin_cell(f.ds, f.dt) : trail.begin_alone();
  follow(chart, cell, trail, over);
  f.dark = over.dark;
  f.regular = over.regular;
  f.a = over.a;
  f.flux = over.flux;
  f.bounds = over.bounds;
  f.a_middle = f.a.v;
  f.flux_middle = f.flux.v;
  if (!centred_form || f.dark || !f.regular) {
    f.ds = f.dt = Interval(0.0);
    return;
  }
  f.a_middle = middle.a.v;
  f.flux_middle = middle.flux.v;
  f.a.v = centred(f.a, middle.a.v, f.ds, f.dt);
  for (std::size_t b = 0; b < f.bounds.size(); ++b) {
    f.bounds[b].v = centred(f.bounds[b], middle.bounds[b].v, f.ds, f.dt);
  }
}

Slopes EnclosedField::level(double k) const {
  Slopes F = combined(a, flux, -k);
  F.v = centred(F, a_middle - k * flux_middle, ds, dt);
  return F;
}

}  // namespace caustic::solver
