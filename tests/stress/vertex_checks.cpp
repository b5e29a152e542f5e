// Curves of single sheets, vertex by vertex, and between vertices.
#include <algorithm>
#include <cmath>

#include "tests/stress/checks.h"

namespace caustic::stress {
namespace {

using solver::Curve;
using solver::CurveKind;
using solver::CurveVertex;

// Rounding moves each of the hops; the reference's surface is not rounded as the program's is.
constexpr double kSpreads = 16.0;
// Share of a gradient, or of a level over the window, that it may be off.
constexpr double kGradient = 1e-7;

bool of_one_sheet(const Curve& c) {
  return c.family_id >= 0 && (c.kind == CurveKind::isolux || c.kind == CurveKind::caustic) &&
         !c.vertices.empty();
}

Finding wrong_vertex(const Subject& s, const Curve& c, std::size_t i) {
  const Oracle& oracle = s.oracle;
  const CurveVertex& v = c.vertices[i];
  const Family& family = family_of(s.trial, c);
  const double size = oracle.size(), hops = static_cast<double>(family.size());
  if ((v.p - s.trial.receiver().point(v.uv)).norm() > 1e-13 * (size + v.p.norm()))
    return "p is not that of uv";
  const double edge = (v.uv.cwiseAbs() - s.trial.receiver().half).maxCoeff();
  if (edge > 1e-8 * s.trial.receiver().width() + 1e-13 * size)
    return text("outside by %.3g m", edge);
  const auto near = oracle.distances(family, v.x, v.uv);
  // An end may be beyond what it is named after by rounding.
  const auto at_end = [&](const CurveVertex& end) { return (v.x - end.x).norm() <= 1e-12 * size; };
  if (!family.empty() && near.empty()) {
    if (!c.closed && (at_end(c.vertices.front()) || at_end(c.vertices.back()))) return std::nullopt;
    return "no path begins at its reflector point";
  }
  const auto found = oracle.exact(family, v.x, near);
  if (!found) return "its path does not arrive";
  if (!family.empty()) {
    const double off = oracle.surface_distance(family[0], v.x);
    if (off > 256.0 * geometry::kEpsilon * (v.x.norm() + size))
      return text("reflector point %.3g m off its surface", off);
  }
  // What rounding of x may do is asked only where the plain tolerance does not do.
  const double tolerance = 1.001 * s.trial.call.request.irradiance_tolerance + 1e-13;
  const double off = (found->q - v.uv).norm();
  const bool caustic = c.kind == CurveKind::caustic;
  const double wrong = caustic ? found->flatness : std::abs(found->E / c.level - 1.0);
  const double said = caustic ? 0.0 : std::abs(v.irradiance / found->E - 1.0);
  if (!caustic && found->parity != c.parity) return "parity";
  if (off <= 1e-13 * size && wrong <= tolerance && said <= tolerance) return std::nullopt;
  const Spread spread = oracle.spread(family, v.x, near, *found);
  if (off > 1e-13 * size + kSpreads * hops * spread.q)
    return text("uv %.3g m off, rounding explains %.3g", off, spread.q);
  const double allowed = tolerance + kSpreads * hops * (caustic ? spread.flatness : spread.E);
  if (wrong > allowed)
    return text("%s %.3g, allowed %.3g", caustic ? "flatness" : "E/level - 1 =", wrong, allowed);
  if (said > allowed) return text("says E = %.12g, it is %.12g", v.irradiance, found->E);
  return std::nullopt;
}

Finding wrong_gradient(const Subject& s, const Curve& c, std::size_t i) {
  const CurveVertex& v = c.vertices[i];
  const Family& family = family_of(s.trial, c);
  const auto near = s.oracle.distances(family, v.x, v.uv);
  const auto expected = s.oracle.slope(family, v.x, near);
  if (!expected) return std::nullopt;  // what check_vertices is about
  const auto& receiver = s.trial.receiver();
  const Vec2 said(receiver.u.dot(v.gradient), receiver.v.dot(v.gradient));
  const double off = (said - *expected).norm() + std::abs(receiver.m.dot(v.gradient));
  const double allowed = kGradient * (expected->norm() + c.level / receiver.width());
  if (off <= allowed) return std::nullopt;
  // Near a caustic it hangs on the last digits of x, and of what each hop rounds.
  const double hops = static_cast<double>(family.size());
  double spread = 0.0;
  for (const Vec3& axis : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)}) {
    const double by = 16.0 * geometry::kEpsilon * (v.x.norm() + s.oracle.size());
    const auto moved = s.oracle.slope(family, v.x + by * axis, near);
    if (!moved) return std::nullopt;
    spread = std::max(spread, (*moved - *expected).norm());
  }
  if (off <= allowed + kSpreads * hops * spread) return std::nullopt;
  return text("says that E rises by (%.9g, %.9g) a metre, it does by (%.9g, %.9g)", said[0],
              said[1], (*expected)[0], (*expected)[1]);
}

/// The true curve beside the middle of a segment, by secants across it; nothing where they lead
/// away.
std::optional<Vec2> true_place(const Subject& s, const Curve& c, const CurveVertex& a,
                               const CurveVertex& b) {
  const Family& family = family_of(s.trial, c);
  const auto near = s.oracle.distances(family, a.x, a.uv);
  const Vec3 way = b.x - a.x;
  const Point middle = 0.5 * (a.x + b.x);
  const auto phi = [&](const Reading& r) { return r.parity / r.E - c.parity / c.level; };
  LongVec g = family.empty() ? LongVec(s.trial.receiver().m.cast<Long>())
                             : s.oracle.scene().surfaces[family[0]].gradient(middle.cast<Long>());
  const Vec3 across = way.cross(g.cast<double>().normalized());
  double t0 = 0.0, t1 = 1e-3;
  auto r0 = s.oracle.quick(family, middle, near),
       r1 = s.oracle.quick(family, middle + t1 * across, near);
  for (int i = 0; i < 8 && r0 && r1; ++i) {
    const double f0 = phi(*r0), f1 = phi(*r1);
    if (std::abs(f1) * c.level < 1e-9) return r1->q;
    const double t = t1 - f1 * (t1 - t0) / (f1 - f0);
    if (!(std::abs(t) < 0.3)) return std::nullopt;
    t0 = t1, r0 = r1;
    t1 = t, r1 = s.oracle.quick(family, middle + t1 * across, near);
  }
  return std::nullopt;
}

/// Is each vertex of b's next to a segment of a's, on the reflector too?
bool lies_on(const Curve& b, const Curve& a, double near) {
  const std::size_t n = a.vertices.size(), segments = a.closed ? n : n - 1;
  return std::all_of(b.vertices.begin(), b.vertices.end(), [&](const CurveVertex& v) {
    for (std::size_t i = 0; i < segments; ++i) {
      const CurveVertex &from = a.vertices[i], &to = a.vertices[(i + 1) % n];
      const Vec2 chord = to.uv - from.uv;
      const double length2 = chord.squaredNorm();
      const double w =
          length2 > 0.0 ? std::clamp((v.uv - from.uv).dot(chord) / length2, 0.0, 1.0) : 0.0;
      const double off_x = (from.x + w * (to.x - from.x) - v.x).norm();
      if ((from.uv + w * chord - v.uv).norm() <= near && off_x <= (to.x - from.x).norm())
        return true;
    }
    return false;
  });
}

}  // namespace

Finding check_once(const Subject& s) {
  const auto& curves = s.trial.result.curves;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    for (std::size_t j = 0; j < curves.size() && !late(s); ++j) {
      const Curve &a = curves[i], &b = curves[j];
      const bool alike = of_one_sheet(a) && of_one_sheet(b) && a.kind == b.kind &&
                         a.level == b.level && a.family_id == b.family_id && a.parity == b.parity;
      // What is no longer than the tolerance may be a piece between two gaps.
      if (i == j || !alike || a.vertices.size() < 2 || !(b.length > 10.0 * s.trial.chord()))
        continue;
      if (lies_on(b, a, s.trial.chord()))
        return name_of(s.trial, j) + ": once more " + name_of(s.trial, i);
    }
  }
  return std::nullopt;
}

Finding check_vertices(const Subject& s) {
  const auto& curves = s.trial.result.curves;
  for (const std::size_t k : spread_over(curves.size(), 10 * s.effort)) {
    const Curve& c = curves[k];
    if (!of_one_sheet(c) || late(s)) continue;
    for (const std::size_t i : spread_over(c.vertices.size(), 4))
      if (const auto wrong = wrong_vertex(s, c, i))
        return name_of(s.trial, k) + text(", vertex %zu of %zu: ", i, c.vertices.size()) + *wrong;
  }
  return std::nullopt;
}

Finding check_gradients(const Subject& s) {
  const auto& curves = s.trial.result.curves;
  for (const std::size_t k : spread_over(curves.size(), 10 * s.effort)) {
    const Curve& c = curves[k];
    if (!of_one_sheet(c) || c.kind != CurveKind::isolux || late(s)) continue;
    for (const std::size_t i : spread_over(c.vertices.size(), 3))
      if (const auto wrong = wrong_gradient(s, c, i))
        return name_of(s.trial, k) + text(", vertex %zu of %zu: ", i, c.vertices.size()) + *wrong;
  }
  return std::nullopt;
}

Finding check_chords(const Subject& s) {
  const auto& curves = s.trial.result.curves;
  for (const std::size_t k : spread_over(curves.size(), 8 * s.effort)) {
    const Curve& c = curves[k];
    if (!of_one_sheet(c) || c.kind != CurveKind::isolux || late(s)) continue;
    const std::size_t n = c.vertices.size(), segments = c.closed ? n : n - 1;
    if (c.closed && n < 3) return name_of(s.trial, k) + ": closed, of fewer than three vertices";
    // Of a closed curve the last segment is the one that closes it.
    for (const std::size_t i : spread_over(segments, 4)) {
      const CurveVertex &a = c.vertices[i], &b = c.vertices[(i + 1) % n];
      const auto place = true_place(s, c, a, b);
      if (!place) continue;
      const Vec2 chord = b.uv - a.uv, off = *place - a.uv;
      const double length2 = chord.squaredNorm();
      const double along = length2 > 0.0 ? std::clamp(off.dot(chord) / length2, 0.0, 1.0) : 0.0;
      const double distance = (off - along * chord).norm();
      if (distance > 1.5 * s.trial.chord() + 1e-9 * s.oracle.size())
        return name_of(s.trial, k) +
               text(", segment %zu of %zu: true curve %.3g m beside it, chord %.3g", i, segments,
                    distance, s.trial.chord());
    }
  }
  return std::nullopt;
}

}  // namespace caustic::stress
