// Curves of single sheets: nothing in the way inside, and at the ends what they are named after.
#include <cmath>

#include "tests/stress/checks.h"

namespace caustic::stress {
namespace {

using solver::Curve;
using solver::CurveKind;
using solver::Ending;

std::string words(const std::set<Ending>& endings) {
  std::string out;
  for (const Ending e : endings) out += std::string(out.empty() ? "" : ", ") + solver::to_string(e);
  return out.empty() ? "nothing" : out;
}

bool is_path_curve(const Curve& c) {
  return c.family_id >= 0 && (c.kind == CurveKind::isolux || c.kind == CurveKind::caustic) &&
         c.vertices.size() >= 2;
}

bool has_stopped(const Trial& trial) {
  for (const auto& [code, detail] : trial.result.warnings)
    if (code == "limit" || code == "stalled") return true;
  return !trial.result.complete;
}

/// On from an end: the tangent of the parabola through the last three vertices, and the last chord.
std::vector<Vec3> ways_on(const Curve& c, bool front) {
  const std::size_t n = c.vertices.size();
  const auto x = [&](std::size_t i) -> const Point& { return c.vertices[front ? i : n - 1 - i].x; };
  const double last = (x(0) - x(1)).norm();
  if (last == 0.0) return {};
  const Vec3 chord = (x(0) - x(1)) / last;
  if (n < 3 || (x(1) - x(2)).norm() == 0.0) return {chord};
  const double before = (x(1) - x(2)).norm();
  const Vec3 bend = chord - (x(1) - x(2)) / before;
  return {(chord + last / (last + before) * bend).normalized(), chord};
}

Finding wrong_end(const Subject& s, const Curve& c, bool front) {
  const std::size_t n = c.vertices.size();
  const Ending name = c.ends[front ? 0 : 1];
  if (name == Ending::limit)
    return has_stopped(s.trial) ? Finding() : Finding("limit, and no warning says so");
  const auto& end = c.vertices[front ? 0 : n - 1];
  // Not a vertex that is the end but for rounding.
  std::size_t next = 1;
  const auto from_end = [&](std::size_t i) -> const solver::CurveVertex& {
    return c.vertices[front ? i : n - 1 - i];
  };
  while (next + 1 < n && (from_end(next).x - end.x).norm() <= 1e-12 * s.oracle.size()) ++next;
  const auto& before = from_end(next);
  const auto& inside = c.vertices[n / 2];
  const Family& family = family_of(s.trial, c);
  const auto sides =
      s.oracle.sides(family, inside.x, s.oracle.distances(family, inside.x, inside.uv));
  auto near = s.oracle.distances(family, end.x, end.uv);
  if (near.empty()) near = s.oracle.distances(family, before.x, before.uv);
  if (near.empty() || sides.size() != family.size()) return std::nullopt;
  const double back = 0.9 * (end.x - before.x).norm();
  const auto broken = [&](const Point& x) { return s.oracle.broken(family, x, near, sides); };
  std::set<Ending> seen;
  for (const Vec3& on : ways_on(c, front)) {
    for (double step = 1e-13; step < 0.02; step *= 10.0) {
      const double by = step * s.oracle.size();
      const auto after = broken(end.x + by * on);
      seen.insert(after.begin(), after.end());
      if (after.contains(name) && !broken(end.x - std::min(by, back) * on).contains(name))
        return std::nullopt;
    }
  }
  if (back == 0.0) return std::nullopt;
  return text("named %s, past it: ", solver::to_string(name)) + words(seen);
}

}  // namespace

Finding check_seen(const Subject& s) {
  const auto& curves = s.trial.result.curves;
  for (const std::size_t k : spread_over(curves.size(), 8 * s.effort)) {
    const Curve& c = curves[k];
    if (!is_path_curve(c) || late(s)) continue;
    for (const std::size_t i : spread_over(c.vertices.size(), 4)) {
      const auto& v = c.vertices[i];
      const double from_end =
          std::min((v.x - c.vertices.front().x).norm(), (v.x - c.vertices.back().x).norm());
      if (!c.closed && from_end < 1e-5 * s.oracle.size()) continue;
      const Family& family = family_of(s.trial, c);
      const auto near = s.oracle.distances(family, v.x, v.uv);
      if (near.size() != family.size()) continue;  // the check of vertices says so
      const auto why = s.oracle.broken(family, v.x, near, {});
      // On an edge of something within rounding it may go either way.
      if (!why.empty())
        return name_of(s.trial, k) + text(", vertex %zu of %zu: ", i, c.vertices.size()) +
               words(why);
    }
  }
  return std::nullopt;
}

Finding check_ends(const Subject& s) {
  const auto& curves = s.trial.result.curves;
  for (const std::size_t k : spread_over(curves.size(), 12 * s.effort)) {
    const Curve& c = curves[k];
    if (c.closed != c.ends.empty() || (!c.closed && c.ends.size() != 2))
      return name_of(s.trial, k) + text(": closed %d with %zu ends", c.closed, c.ends.size());
    if (c.closed || !is_path_curve(c) || late(s)) continue;
    for (const bool front : {true, false})
      if (const auto wrong = wrong_end(s, c, front))
        return name_of(s.trial, k) + (front ? ", first end " : ", last end ") + *wrong;
  }
  return std::nullopt;
}

}  // namespace caustic::stress
