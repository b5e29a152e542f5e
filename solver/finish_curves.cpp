// From traces to the curves of an answer: orientation, lengths, order.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "solver/contour_task.h"

namespace caustic::solver {

namespace {

// Brighter side on the left, seen with u right and v up; caustics from their smaller end.
void orient(Curve& curve, const geometry::ReceiverFrame& receiver) {
  auto& vertices = curve.vertices;
  bool reverse = false;
  if (curve.kind == CurveKind::isolux) {
    double left = 0.0;
    for (std::size_t i = 0; i + 1 < vertices.size(); ++i) {
      const Vec2 d = vertices[i + 1].uv - vertices[i].uv;
      const Vec3& g = vertices[i].gradient;
      const double scale = g.norm();
      if (scale > 0.0) left += (d.x() * receiver.v.dot(g) - d.y() * receiver.u.dot(g)) / scale;
    }
    reverse = left < 0.0;
  } else {
    const Vec2 &a = vertices.front().uv, &b = curve.closed ? vertices[1].uv : vertices.back().uv;
    reverse = std::tie(b.x(), b.y()) < std::tie(a.x(), a.y());
  }
  if (!reverse) return;
  std::reverse(vertices.begin(), vertices.end());
  std::reverse(curve.ends.begin(), curve.ends.end());
}

}  // namespace

Curve finish(Trace trace, const ContourTask& task, const geometry::ReceiverFrame& receiver) {
  Curve curve;
  curve.kind = task.level.is_caustic() ? CurveKind::caustic : CurveKind::isolux;
  curve.level = task.irradiance;
  curve.family_id = task.field->piece.family;
  curve.parity = task.level.k > 0.0 ? 1 : task.level.k < 0.0 ? -1 : 0;
  curve.closed = trace.closed;
  curve.ends = std::move(trace.ends);
  curve.vertices = std::move(trace.vertices);
  orient(curve, receiver);
  double length = 0.0;
  for (std::size_t i = 0; i < curve.vertices.size(); ++i) {
    CurveVertex& v = curve.vertices[i];
    if (i > 0) length += (v.p - curve.vertices[i - 1].p).norm();
    v.arc_length = length;
    // Against the level asked for, which a critical value may have moved.
    if (curve.kind == CurveKind::isolux) v.residual = std::abs(v.irradiance / curve.level - 1.0);
    curve.max_residual = std::max(curve.max_residual, v.residual);
  }
  if (curve.closed) length += (curve.vertices.front().p - curve.vertices.back().p).norm();
  curve.length = length;
  return curve;
}

namespace {

Vec2 smallest_uv(const Curve& curve) {
  Vec2 least = curve.vertices.front().uv;
  for (const CurveVertex& v : curve.vertices) {
    if (std::tie(v.uv.x(), v.uv.y()) < std::tie(least.x(), least.y())) least = v.uv;
  }
  return least;
}

}  // namespace

void sort_curves(std::vector<Curve>& curves) {
  using Key = std::tuple<int, double, int, double, double>;
  std::vector<std::pair<Key, std::size_t>> order;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const Curve& c = curves[i];
    const Vec2 uv = smallest_uv(c);
    order.push_back({{static_cast<int>(c.kind), c.level, c.family_id, uv.x(), uv.y()}, i});
  }
  std::sort(order.begin(), order.end());
  std::vector<Curve> sorted;
  for (const auto& [key, i] : order) sorted.push_back(std::move(curves[i]));
  curves = std::move(sorted);
}

}  // namespace caustic::solver
