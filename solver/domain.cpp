#include "solver/domain.h"

#include <cmath>

namespace caustic::solver {

namespace {

// Planes this near, as an angle and in diameters of the scene, are one.
constexpr double kSamePlane = 1e-12;

}  // namespace

// After the aperture's bounds: silhouette, receiver's plane, then the edges −u, +u, −v, +v, then later_.

Domain::Domain(const ForwardMap& map) : map_(map), bounds_(map.mirror().bounds) {
  for (int hop = 0; hop < map.hop_count(); ++hop) {
    const SystemSurface& surface = map.surface(hop);
    if (hop > 0) {
      for (const auto& bound : surface.bounds) later_.push_back({Later::Kind::bound, hop, &bound});
      later_.push_back({Later::Kind::grazing, hop, nullptr});
    }
    if (surface.optics.kind == Optics::Kind::refract && surface.optics.eta(map.hops()[hop].side) > 1.0) {
      later_.push_back({Later::Kind::total_reflection, hop, nullptr});
    }
  }
}

double Domain::value(int i, const FieldPoint& f) const {
  if (i == left_out_) return -geometry::kInfinity;
  if (i < bound_count()) return bounds_[i].value(f.x);
  const auto& receiver = map_.receiver();
  switch (i - bound_count()) {
    case 0: return -f.cos_alpha * receiver.width();
    case 1:
      if (map_.hop_count() == 0) return -geometry::kInfinity;  // x is on it
      return std::copysign(1.0, f.facing) * receiver.m.dot(last(f) - receiver.origin);
    case 2: return -f.q.x() - receiver.half.x();
    case 3: return f.q.x() - receiver.half.x();
    case 4: return -f.q.y() - receiver.half.y();
    case 5: return f.q.y() - receiver.half.y();
    default: break;
  }
  const Hit& hit = f.hits[later(i)->hop];
  switch (later(i)->kind) {
    case Later::Kind::bound: return later(i)->bound->value(hit.y);
    case Later::Kind::grazing: return -hit.cosine * receiver.width();
    default: return -hit.headroom * receiver.width();
  }
}

Vec3 Domain::gradient(int i, const FieldPoint& f) const {
  if (i < bound_count()) return bounds_[i].gradient(f.x);
  const auto& receiver = map_.receiver();
  switch (i - bound_count()) {
    case 0: return -f.grad_cos * receiver.width();
    case 1: {
      if (map_.hop_count() == 0) return Vec3::Zero();
      if (map_.hop_count() == 1) return std::copysign(1.0, f.facing) * receiver.m;
      const Hit& hit = f.hits[map_.hop_count() - 1];
      return std::copysign(1.0, f.facing) *
             (receiver.m.dot(hit.y_s) * f.e1 + receiver.m.dot(hit.y_t) * f.e2);
    }
    case 2: return -(f.q_s.x() * f.e1 + f.q_t.x() * f.e2);
    case 3: return f.q_s.x() * f.e1 + f.q_t.x() * f.e2;
    case 4: return -(f.q_s.y() * f.e1 + f.q_t.y() * f.e2);
    case 5: return f.q_s.y() * f.e1 + f.q_t.y() * f.e2;
    default: break;
  }
  const Hit& hit = f.hits[later(i)->hop];
  switch (later(i)->kind) {
    case Later::Kind::bound: {
      const Vec3 slope = later(i)->bound->gradient(hit.y);
      return slope.dot(hit.y_s) * f.e1 + slope.dot(hit.y_t) * f.e2;
    }
    case Later::Kind::grazing: return -hit.grad_cosine * receiver.width();
    default: return -hit.grad_headroom * receiver.width();
  }
}

double Domain::slope(int i, const FieldPoint& f, const Vec3& t, const Vec2& dq) const {
  if (i < bound_count()) return bounds_[i].gradient(f.x).dot(t);
  const auto& receiver = map_.receiver();
  switch (i - bound_count()) {
    case 0: return -f.grad_cos.dot(t) * receiver.width();
    case 1: return gradient(i, f).dot(t);
    case 2: return -dq.x();
    case 3: return dq.x();
    case 4: return -dq.y();
    case 5: return dq.y();
    default: return gradient(i, f).dot(t);
  }
}

Ending Domain::ending(int i) const {
  if (bound_of(i)) return Ending::aperture;
  switch (i - bound_count()) {
    case 0: return Ending::silhouette;
    case 1: return Ending::occlusion;
    default: break;
  }
  if (!later(i)) return Ending::receiver_edge;
  return later(i)->kind == Later::Kind::grazing ? Ending::silhouette
                                                : Ending::total_internal_reflection;
}

// Boundaries that are planes in space.
std::optional<Domain::Plane> Domain::plane(int i) const {
  if (i == silhouette() + 1 && map_.hop_count() == 1)
    return Plane{map_.receiver().m, map_.receiver().origin};
  if (!bound(i) || bound(i)->kind != geometry::Bound::Kind::half_space) return std::nullopt;
  return Plane{bound(i)->axis, bound(i)->point};
}

int Domain::first_like(int i) const {
  const auto own = plane(i);
  for (int j = 0; own && j < i; ++j) {
    const auto other = plane(j);
    if (other && own->normal.cross(other->normal).norm() <= kSamePlane &&
        std::abs(own->normal.dot(own->point - other->point)) <=
            kSamePlane * map_.system().diameter())
      return j;
  }
  return i;
}

Domain::Worst Domain::worst(const FieldPoint& f) const {
  Worst worst{0, -geometry::kInfinity};
  for (int i = 0; i < size(); ++i) {
    const double h = value(i, f);
    if (h > worst.value) worst = {i, h};
  }
  return worst;
}

}  // namespace caustic::solver
