#include "solver/domain.h"

#include <cmath>

namespace caustic::solver {

// After the aperture's bounds: silhouette, receiver's plane, then the edges −u, +u, −v, +v.

double Domain::value(int i, const FieldPoint& f) const {
  if (i < bound_count()) return bounds_[i].value(f.x);
  const auto& receiver = map_.receiver();
  switch (i - bound_count()) {
    case 0: return -f.cos_alpha * receiver.width();
    case 1: return std::copysign(1.0, f.facing) * receiver.m.dot(f.x - receiver.origin);
    case 2: return -f.q.x() - receiver.half.x();
    case 3: return f.q.x() - receiver.half.x();
    case 4: return -f.q.y() - receiver.half.y();
    default: return f.q.y() - receiver.half.y();
  }
}

Vec3 Domain::gradient(int i, const FieldPoint& f) const {
  if (i < bound_count()) return bounds_[i].gradient(f.x);
  const auto& receiver = map_.receiver();
  switch (i - bound_count()) {
    case 0: return -f.grad_cos * receiver.width();
    case 1: return std::copysign(1.0, f.facing) * receiver.m;
    case 2: return -(f.q_s.x() * f.e1 + f.q_t.x() * f.e2);
    case 3: return f.q_s.x() * f.e1 + f.q_t.x() * f.e2;
    case 4: return -(f.q_s.y() * f.e1 + f.q_t.y() * f.e2);
    default: return f.q_s.y() * f.e1 + f.q_t.y() * f.e2;
  }
}

double Domain::slope(int i, const FieldPoint& f, const Vec3& t, const Vec2& dq) const {
  if (i < bound_count()) return bounds_[i].gradient(f.x).dot(t);
  const auto& receiver = map_.receiver();
  switch (i - bound_count()) {
    case 0: return -f.grad_cos.dot(t) * receiver.width();
    case 1: return std::copysign(1.0, f.facing) * receiver.m.dot(t);
    case 2: return -dq.x();
    case 3: return dq.x();
    case 4: return -dq.y();
    default: return dq.y();
  }
}

Ending Domain::ending(int i) const {
  if (i < bound_count()) return Ending::aperture;
  switch (i - bound_count()) {
    case 0: return Ending::silhouette;
    case 1: return Ending::occlusion;
    default: return Ending::receiver_edge;
  }
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
