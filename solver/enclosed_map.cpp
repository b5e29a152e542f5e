#include "solver/enclosed_map.h"

#include <algorithm>

#include "solver/enclosed_share.h"

namespace caustic::solver {

using geometry::constant_jet;
using geometry::GraphChart;
using geometry::IntervalJet;
using geometry::IntervalVecJet;

namespace {

Slopes first_order(const IntervalJet& a) { return {a.v, a.s, a.t}; }
Slopes scaled(const Slopes& a, double k) { return {k * a.v, k * a.s, k * a.t}; }
Slopes combined(const Slopes& a, const Slopes& b, double k) {
  return {a.v + k * b.v, a.s + k * b.s, a.t + k * b.t};
}
Slopes product(const IntervalJet& a, const IntervalJet& b) {
  return {a.v * b.v, a.v * b.s + a.s * b.v, a.v * b.t + a.t * b.v};
}
Slopes difference(const Slopes& a, const Slopes& b) { return combined(a, b, -1.0); }
Slopes unknown() { return {Interval::whole(), Interval::whole(), Interval::whole()}; }

Interval mean_value(const Slopes& over, const Interval& middle, const Interval& ds,
                    const Interval& dt) {
  return meet(over.v, middle + over.s * ds + over.t * dt);
}

}  // namespace

// Light from the source, d not of unit length.
struct EnclosedMap::Incident {
  IntervalVecJet d;
  IntervalJet dN, NN, dd;
};

// Its direction after the hop, D = along_d d + along_N N.
struct EnclosedMap::Outgoing {
  IntervalJet along_d, along_N;
  bool total_reflection = false;  // in some of the cell
  bool none = false;              // in all of it
};

struct EnclosedMap::Result {
  bool dark = false, regular = false;
  int upward = 0;
  Slopes a, flux;
  std::array<Slopes, 2> q;
  std::array<Interval, 3> leaving;
  std::vector<Slopes> bounds;
};

bool EnclosedMap::encloses(const ForwardMap& map) { return map.hop_count() == 1; }

EnclosedMap::EnclosedMap(const ForwardMap& map)
    : map_(map), shape_(map.shape()), optics_(map.mirror().optics) {
  const auto* point = std::get_if<PointLight>(&map.system().light());
  point_source_ = point != nullptr;
  source_ = point ? point->position : std::get<CollimatedLight>(map.system().light()).direction;
}

// Bounds are functions of the place; an expression's slopes are not enclosed.
Slopes EnclosedMap::bound(const geometry::Bound& b, const IntervalVecJet& x) const {
  using Kind = geometry::Bound::Kind;
  if (b.kind == Kind::expression) {
    const geometry::Box box = geometry::box_of(geometry::IntervalVec3{x[0].v, x[1].v, x[2].v});
    return {{b.least_in(box), b.largest_in(box)}, Interval::whole(), Interval::whole()};
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

EnclosedMap::Incident EnclosedMap::incident(const GraphJets& on, MeanValues& mean) const {
  Incident in;
  if (point_source_) {
    in.d = on.x - source_;
  } else {
    for (std::size_t a = 0; a < 3; ++a) in.d[a] = constant_jet(source_[static_cast<int>(a)]);
  }
  in.NN = mean(geometry::squared_norm(on.N));
  in.dN = mean(point_source_ ? geometry::dot(in.d, on.N) : geometry::dot(source_, on.N));
  in.dd = mean(geometry::squared_norm(in.d));
  return in;
}

// Σ of (S71): what falls on the surface and goes on.
Slopes EnclosedMap::flux(const GraphJets& on, std::size_t axis, const Incident& in,
                         MeanValues& mean) const {
  IntervalJet across = double(on.upward) * on.N[axis];
  if (point_source_) across = across * in.dd * sqrt(in.dd);
  IntervalJet arriving = in.dN / across;
  const double side = map_.side();
  if (!optics_.constant_share()) {
    const IntervalJet cosine = mean(-side * (in.dN / sqrt(in.dd * in.NN)));
    const bool reflects = optics_.kind == Optics::Kind::mirror;
    const auto index = reflects ? *optics_.metal : 1.0 / optics_.eta(map_.side());
    const IntervalJet reflected = mean(enclosed_reflectance(index, cosine));
    arriving = arriving * (reflects ? reflected : constant_jet(1.0) - reflected);
  }
  return scaled(first_order(mean(arriving)), -side * map_.strength());
}

// (S3), (S24).
EnclosedMap::Outgoing EnclosedMap::bounce(const Incident& in, MeanValues& mean) const {
  if (optics_.kind == Optics::Kind::mirror)
    return {constant_jet(1.0), mean(-2.0 * (in.dN / in.NN))};
  const double side = map_.side(), eta = optics_.eta(map_.side());
  const Interval loss = Interval(1.0) - sqr(Interval(eta));
  const IntervalJet headroom = mean(constant_jet(loss) * (in.dd * in.NN) +
                                    constant_jet(sqr(Interval(eta))) * geometry::square(in.dN));
  Outgoing out{constant_jet(eta), {}, !(headroom.v.lo > 0.0), headroom.v.hi < 0.0};
  if (!out.none) out.along_N = mean(-1.0 * ((eta * in.dN + side * sqrt(headroom)) / in.NN));
  return out;
}

// The arrival (S4) in the receiver's axes, with the bounds (S74) that it has. P = (m·D) q is smooth
// also where q has a pole.
void EnclosedMap::arrive(const GraphJets& on, const Incident& in, const Outgoing& leaving,
                         MeanValues& mean, Result& out) const {
  const auto& receiver = map_.receiver();
  const IntervalVecJet y = on.x - receiver.origin;
  const auto direction_along = [&](const Vec3& axis) {
    const IntervalJet own =
        point_source_
            ? leaving.along_d * geometry::dot(axis, in.d)
            : leaving.along_d * constant_jet(geometry::dot(axis, geometry::intervals(source_)));
    return mean(own + leaving.along_N * geometry::dot(axis, on.N));
  };
  const IntervalJet D_m = direction_along(receiver.m), y_m = geometry::dot(receiver.m, y);
  const IntervalJet D[2] = {direction_along(receiver.u), direction_along(receiver.v)};
  const IntervalJet at[2] = {geometry::dot(receiver.u, y), geometry::dot(receiver.v, y)};
  out.leaving = {D[0].v, D[1].v, D_m.v};
  const int facing = sign_of(D_m.v);
  out.dark = false;
  out.bounds.push_back(facing == 0 ? unknown() : scaled(first_order(y_m), facing));
  for (int c = 0; c < 2; ++c) {
    const Slopes P = difference(product(at[c], D_m), product(y_m, D[c]));
    const auto beyond = [&](double edge) {
      const Slopes h = combined(P, first_order(D_m), -edge);
      return first_order(
          mean({h.v, h.s, h.t, Interval::whole(), Interval::whole(), Interval::whole()}));
    };
    const Slopes above = beyond(receiver.half[c]), below = beyond(-receiver.half[c]);
    out.dark |= sign_of(above.v) * sign_of(below.v) > 0;
    out.bounds.push_back(facing == 0 ? unknown() : scaled(below, -facing));
    out.bounds.push_back(facing == 0 ? unknown() : scaled(above, facing));
  }
  out.regular = facing != 0 && on.upward != 0 && !leaving.total_reflection;
  if (!out.regular) {
    out.a = out.q[0] = out.q[1] = unknown();
    return;
  }
  const IntervalJet lambda = mean(-1.0 * (y_m / D_m));
  const IntervalJet q[2] = {mean(at[0] + lambda * D[0]), mean(at[1] + lambda * D[1])};
  const auto det = [](const Interval& a0, const Interval& a1, const Interval& b0,
                      const Interval& b1) { return a0 * b1 - a1 * b0; };
  const Slopes a{det(q[0].s, q[1].s, q[0].t, q[1].t),
                 det(q[0].ss, q[1].ss, q[0].t, q[1].t) + det(q[0].s, q[1].s, q[0].st, q[1].st),
                 det(q[0].st, q[1].st, q[0].t, q[1].t) + det(q[0].s, q[1].s, q[0].tt, q[1].tt)};
  out.a = scaled(a, map_.side() * on.upward);
  out.q = {first_order(q[0]), first_order(q[1])};
}

void EnclosedMap::follow(const GraphChart& chart, const GraphCell& cell, MeanValues& mean,
                         Result& out) const {
  const GraphJets on = graph_jets(shape_, chart, cell, mean);
  out.upward = on.upward;
  const Incident in = incident(on, mean);
  out.flux = flux(on, chart.along(), in, mean);
  const Outgoing leaving = bounce(in, mean);
  out.dark = leaving.none;
  out.regular = false;
  if (out.dark) return;
  out.bounds.clear();
  for (const auto& b : map_.mirror().bounds) out.bounds.push_back(bound(b, on.x));
  out.bounds.push_back(scaled(first_order(in.dN), map_.side()));
  arrive(on, in, leaving, mean, out);
  const IntervalJet& height = on.x[chart.along()];
  const Interval& ends = chart.own[chart.along()];
  out.bounds.push_back({height.v - ends.hi, height.s, height.t});
  out.bounds.push_back({ends.lo - height.v, -height.s, -height.t});
}

void EnclosedMap::enclose(const GraphChart& chart, const GraphCell& cell, EnclosedField& f) const {
  thread_local MeanValues mean;
  thread_local Result over, middle;
  f.ds = f.dt = Interval(0.0);
  // Mean values are taken along the graph, so there has to be one all over the cell.
  const bool thin = cell.s.width() == 0.0 && cell.t.width() == 0.0;
  bool centred_form = cell.whole && !thin;
  if (centred_form) {
    GraphCell point{cell.s.middle(), cell.t.middle(), cell.z, true};
    narrow(chart, point);
    mean.begin_middle();
    follow(chart, point, mean, middle);
    centred_form = middle.regular;
    f.ds = cell.s - point.s;
    f.dt = cell.t - point.t;
  }
  centred_form ? mean.begin_cell(f.ds, f.dt) : mean.begin_alone();
  follow(chart, cell, mean, over);
  f.dark = over.dark;
  f.regular = over.regular;
  f.upward = over.upward;
  f.a = over.a;
  f.flux = over.flux;
  f.bounds = over.bounds;
  f.q = over.q;
  f.leaving = over.leaving;
  f.a_middle = f.a.v;
  f.flux_middle = f.flux.v;
  f.q_middle = {f.q[0].v, f.q[1].v};
  f.centred = thin || (centred_form && f.regular && !f.dark);
  if (!centred_form || f.dark || !f.regular) {
    f.ds = f.dt = Interval(0.0);
    return;
  }
  f.a_middle = middle.a.v;
  f.flux_middle = middle.flux.v;
  f.q_middle = {middle.q[0].v, middle.q[1].v};
  f.a.v = mean_value(f.a, middle.a.v, f.ds, f.dt);
  for (std::size_t c = 0; c < 2; ++c) f.q[c].v = mean_value(f.q[c], f.q_middle[c], f.ds, f.dt);
  for (std::size_t b = 0; b < f.bounds.size(); ++b) {
    f.bounds[b].v = mean_value(f.bounds[b], middle.bounds[b].v, f.ds, f.dt);
  }
}

Slopes EnclosedField::level(double k) const {
  Slopes F = combined(a, flux, -k);
  F.v = mean_value(F, a_middle - k * flux_middle, ds, dt);
  return F;
}

}  // namespace caustic::solver
