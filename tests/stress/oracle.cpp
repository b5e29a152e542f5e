#include "tests/stress/oracle.h"

#include <algorithm>
#include <cmath>
#include <functional>

namespace caustic::stress {
namespace {

using test::Real;
using RealPoint = PathMap<Real>::Vec;

// A surface's own crossing at the end of a segment, in sizes of the scene: x is rounded to a
// double.
constexpr Long kOwn = 1e-9L;
constexpr Long kOfOthers = 1e-13L;
// A path that ends at an aperture's edge is still a path.
constexpr Long kEdge = 1e-6L;
// Sizes of the scene between paths whose E is compared. Where images are stretched a millionfold
// so is this, and E's own rounding is 1e-32 of it.
const Real kSlopeStep(1e-15);

template <class Bundle, class T>
Reading reading_of(const Bundle& b, const T& strength) {
  using std::sqrt;
  const T det = b.det();
  const T rows =
      sqrt(T((b.du[0] * b.du[0] + b.du[1] * b.du[1]) * (b.dv[0] * b.dv[0] + b.dv[1] * b.dv[1])));
  const T area = det < 0 ? T(-det) : det;
  return {{static_cast<double>(b.u), static_cast<double>(b.v)},
          static_cast<double>(T(strength * b.share / area)),
          det > 0 ? 1 : -1,
          static_cast<double>(T(area / rows))};
}

}  // namespace

Oracle::Oracle(const json& scene)
    : scene_(read_oracle_scene(scene)), quick_(scene_), exact_(scene_) {}

std::vector<Long> Oracle::roots(int surface, const LongVec& o, const LongVec& w, Long t0, Long t1,
                                Long slack) const {
  return surface_roots(scene_.surfaces[surface], {o, w, t0, t1}, scene_.size, slack);
}

bool Oracle::blocked(const LongVec& a, const LongVec& b, int on_a, int on_b) const {
  const LongVec way = b - a;
  const Long length = way.norm(), size = scene_.size;
  for (int k = 0; k < std::ssize(scene_.surfaces); ++k) {
    const Long lo = (k == on_a ? kOwn : kOfOthers) * size;
    const Long hi = length - (k == on_b ? kOwn : kOfOthers) * size;
    if (lo >= hi) continue;
    for (const Long t : roots(k, a, way / length, lo, hi))
      if (t > lo && t < hi) return true;
  }
  return false;
}

std::vector<double> Oracle::distances(const Family& family, const Point& x, const Vec2& q) const {
  if (family.empty()) return {};
  std::vector<double> best;
  double least = geometry::kInfinity;
  const LongVec start = quick_.project(family[0], x.cast<Long>());
  const auto [ray, gone] = quick_.ray_through(start);
  // Depth first over all places where the next surface is met.
  std::vector<double> way{static_cast<double>(gone)};
  const std::function<void(LongVec, LongVec, std::size_t)> go = [&](LongVec at, LongVec w,
                                                                    std::size_t hop) {
    LongVec g;
    Long share = 1.0L;
    quick_.value(family[hop], at, g);
    if (!PathMap<Long>::bend(scene_.surfaces[family[hop]].optics, g.normalized(), w, share)) return;
    if (hop + 1 == family.size()) {
      PathMap<Long>::Arrival arrival;
      const std::vector<Long> near(way.begin(), way.end());
      if (quick_.follow(family, ray, near, arrival) != PathMap<Long>::Fate::arrives) return;
      const double off = (Vec2(double(arrival.u), double(arrival.v)) - q).norm();
      if (off < least) least = off, best = way;
      return;
    }
    const int next = family[hop + 1];
    const Long margin = (next == family[hop] ? kOwn : kOfOthers) * scene_.size;
    for (const Long t : roots(next, at, w, margin, 2e3L * scene_.size, kEdge * scene_.size)) {
      way.push_back(static_cast<double>(t));
      go(at + t * w, w, hop + 1);
      way.pop_back();
    }
  };
  go(start, ray.w, 0);
  return best;
}

std::optional<Reading> Oracle::exact(const Family& family, const Point& x,
                                     const std::vector<double>& near) const {
  RealPoint start = exact_.wide(x);
  if (!family.empty()) start = exact_.project(family[0], start);
  const auto bundle = exact_.bundle(family, start, std::vector<Real>(near.begin(), near.end()));
  if (!bundle) return std::nullopt;
  return reading_of(*bundle, exact_.strength());
}

std::optional<Reading> Oracle::quick(const Family& family, const Point& x,
                                     const std::vector<double>& near) const {
  LongVec start = x.cast<Long>();
  if (!family.empty()) start = quick_.project(family[0], start);
  return reading_at(family, start, std::vector<Long>(near.begin(), near.end()));
}

std::optional<Reading> Oracle::reading_at(const Family& family, const LongVec& x,
                                          const std::vector<Long>& near) const {
  const auto bundle = quick_.bundle(family, x, near);
  if (!bundle) return std::nullopt;
  return reading_of(*bundle, quick_.strength());
}

Spread Oracle::spread(const Family& family, const Point& x, const std::vector<double>& near,
                      const Reading& base) const {
  Spread out{0.0, 0.0, 0.0};
  const double by = 16.0 * geometry::kEpsilon * (x.norm() + scene_.size);
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
    for (const double sign : {1.0, -1.0}) {
      const auto moved = exact(family, x + sign * by * axis, near);
      if (!moved) return {geometry::kInfinity, geometry::kInfinity, geometry::kInfinity};
      out.q = std::max(out.q, (moved->q - base.q).norm());
      out.E = std::max(out.E, std::abs(moved->E / base.E - 1.0));
      out.flatness = std::max(out.flatness, std::abs(moved->flatness - base.flatness));
      if (moved->parity != base.parity) out.flatness += moved->flatness + base.flatness;
    }
  }
  return out;
}

std::optional<Vec2> Oracle::slope(const Family& family, const Point& x,
                                  const std::vector<double>& near) const {
  const std::vector<Real> way(near.begin(), near.end());
  const RealPoint middle =
      family.empty() ? exact_.wide(x) : exact_.project(family[0], exact_.wide(x));
  const RealPoint w = exact_.ray_through(middle).first.w;
  const int k = abs(w[0]) < Real(0.6) ? 0 : 1;
  const RealPoint b1 = RealPoint(RealPoint::Unit(k) - w[k] * w).normalized();
  const Real h = kSlopeStep * scene_.size;
  Real du[2], dv[2], dE[2];
  for (int i = 0; i < 2; ++i) {
    const RealPoint step = i == 0 ? RealPoint(h * b1) : RealPoint(h * b1.cross(w));
    const auto hi = exact_.bundle(family, middle + step, way),
               lo = exact_.bundle(family, middle - step, way);
    if (!hi || !lo) return std::nullopt;
    du[i] = hi->u - lo->u, dv[i] = hi->v - lo->v;
    dE[i] = exact_.strength() * (hi->share / abs(hi->det()) - lo->share / abs(lo->det()));
  }
  const Real det = du[0] * dv[1] - du[1] * dv[0];
  if (det == 0) return std::nullopt;
  return Vec2(static_cast<double>(Real((dE[0] * dv[1] - dE[1] * dv[0]) / det)),
              static_cast<double>(Real((dE[1] * du[0] - dE[0] * du[1]) / det)));
}

double Oracle::surface_distance(int surface, const Point& x) const {
  const LongVec at = x.cast<Long>();
  return static_cast<double>((quick_.project(surface, at) - at).norm());
}

std::vector<LongVec> Oracle::hits_of(const Family& family, const Point& x,
                                     const std::vector<double>& near, std::vector<int>& sides,
                                     PathMap<Long>::Fate& fate, Vec2& q) const {
  fate = PathMap<Long>::Fate::misses;
  if (near.size() != family.size()) return {};
  const LongVec start = quick_.project(family[0], x.cast<Long>());
  const auto [ray, gone] = quick_.ray_through(start);
  std::vector<Long> way(near.begin(), near.end());
  way[0] = gone;
  std::vector<LongVec> hits;
  PathMap<Long>::Arrival arrival;
  fate = quick_.follow(family, ray, way, arrival, &hits);
  if (fate == PathMap<Long>::Fate::arrives)
    q = Vec2(static_cast<double>(arrival.u), static_cast<double>(arrival.v));
  LongVec before = ray.o;
  for (std::size_t i = 0; i < hits.size(); ++i) {
    LongVec g;
    quick_.value(family[i], hits[i], g);
    sides.push_back(g.dot(hits[i] - before) > 0.0L ? 1 : -1);
    before = hits[i];
  }
  return hits;
}

std::vector<int> Oracle::sides(const Family& family, const Point& x,
                               const std::vector<double>& near) const {
  std::vector<int> out;
  Vec2 q;
  PathMap<Long>::Fate fate;
  hits_of(family, x, near, out, fate, q);
  return out;
}

std::set<solver::Ending> Oracle::broken(const Family& family, const Point& x,
                                        const std::vector<double>& near,
                                        const std::vector<int>& sides) const {
  using solver::Ending;
  std::set<Ending> out;
  using Fate = PathMap<Long>::Fate;
  std::vector<int> sides_here;
  Vec2 q;
  Fate fate;
  const auto hits = hits_of(family, x, near, sides_here, fate, q);
  if (fate == Fate::misses) out = {Ending::silhouette, Ending::aperture};  // a shape's own end
  if (fate == Fate::reflected) out = {Ending::total_internal_reflection};
  if (fate == Fate::behind) out = {Ending::occlusion};
  for (std::size_t i = 0; i < hits.size(); ++i) {
    if (i < sides.size() && sides_here[i] != sides[i]) out.insert(Ending::silhouette);
    if (scene_.surfaces[family[i]].excess(hits[i]) > 0.0L) out.insert(Ending::aperture);
  }
  if (hits.empty()) return out;
  const bool arrives = fate == Fate::arrives;
  if (arrives && !scene_.receiver.contains(q)) out.insert(Ending::receiver_edge);

  LongVec origin = quick_.ray_through(hits[0]).first.o;
  if (!scene_.point_light()) origin += 2e3L * (origin - hits[0]);
  if (blocked(hits[0], origin, family[0], -1)) out.insert(Ending::shadow);
  for (std::size_t i = 1; i < hits.size(); ++i)
    if (blocked(hits[i - 1], hits[i], family[i - 1], family[i])) out.insert(Ending::occlusion);
  if (arrives && blocked(hits.back(), scene_.receiver.point(q).cast<Long>(), family.back(), -1))
    out.insert(Ending::occlusion);
  return out;
}

std::vector<Arrived> Oracle::shoot(const Point& towards, std::size_t max_hops, bool direct) const {
  std::vector<Arrived> out;
  const auto [ray, gone] = quick_.ray_through(towards.cast<Long>());
  LongVec o = ray.o, w = ray.w;
  const LongVec m = scene_.receiver.m.cast<Long>(), center = scene_.receiver.origin.cast<Long>();
  const Long far = 2e3L * scene_.size;
  if (!scene_.point_light()) o -= far * w;
  Family family;
  std::vector<Long> near;
  LongVec x = towards.cast<Long>();
  for (int last = -1;;) {
    // Nothing beyond what is met first.
    int next = -1;
    Long distance = family.empty() && !scene_.point_light() ? 2.0L * far : far;
    for (int k = 0; k < std::ssize(scene_.surfaces); ++k) {
      const Long lo = (k == last ? kOwn : kOfOthers) * scene_.size;
      for (const Long t : roots(k, o, w, lo, distance)) {
        if (t <= lo || t >= distance) continue;
        distance = t, next = k;
        break;
      }
    }
    const Long arrives = m.dot(center - o) / m.dot(w);
    if (arrives > 0.0L && arrives < distance && (direct || !family.empty())) {
      const LongVec p = o + arrives * w;
      if (family.empty()) x = p;
      const auto reading = reading_at(family, x, near);
      if (reading && scene_.receiver.contains(reading->q))
        out.push_back({family, x.cast<double>(), *reading});
    }
    if (next < 0 || family.size() == max_hops) return out;
    o += distance * w;
    if (family.empty()) x = o;
    LongVec g;
    Long share = 1.0L;
    quick_.value(next, o, g);
    if (!PathMap<Long>::bend(scene_.surfaces[next].optics, g.normalized(), w, share)) return out;
    family.push_back(next);
    near.push_back(distance);
    last = next;
  }
}

}  // namespace caustic::stress
