// The same scene said otherwise has the same curves in the receiver's axes.
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "service/api/problem.h"
#include "tests/stress/checks.h"
#include "tests/stress/transform.h"
#include "tests/support/distance_to.h"

namespace caustic::stress {
namespace {

using solver::Curve;

/// What two curves must have in common to be the same: kind, level, surfaces of the family, parity.
using Label = std::tuple<int, std::size_t, std::vector<std::string>, int>;

Label label_of(const Trial& trial, const Curve& c, int turn) {
  const auto& levels = trial.result.levels;
  const auto level = std::find(levels.begin(), levels.end(), c.level);
  std::vector<std::string> names;
  if (c.family_id >= 0)
    for (const int surface : family_of(trial, c))
      names.push_back(trial.call.system.surfaces()[surface].name);
  return {static_cast<int>(c.kind), level - levels.begin(), names, turn * c.parity};
}

std::map<Label, std::vector<const Curve*>> labelled(const Trial& trial, int turn) {
  std::map<Label, std::vector<const Curve*>> out;
  // Boundaries of the total say on which side there is how much, which is not a curve's matter.
  for (const Curve& c : trial.result.curves)
    if (c.kind != solver::CurveKind::boundary) out[label_of(trial, c, turn)].push_back(&c);
  return out;
}

std::string words_of(const Label& label) {
  const auto& [kind, level, names, parity] = label;
  std::string out = text("%s, level %zu, parity %d, family",
                         solver::to_string(static_cast<solver::CurveKind>(kind)), level, parity);
  for (const std::string& name : names) out += " " + name;
  return out;
}

/// A place on one set of curves that is far from all of the other; q times `scale`.
Finding far_from(const std::vector<const Curve*>& curves, const std::vector<const Curve*>& others,
                 double scale, double tolerance) {
  for (const Curve* c : curves) {
    for (const std::size_t i : spread_over(c->vertices.size(), 9)) {
      const Vec2 q = scale * c->vertices[i].uv;
      double least = geometry::kInfinity;
      for (const Curve* other : others) least = std::min(least, test::distance_to(*other, q));
      if (least > tolerance)
        return text("(%.9g, %.9g) m is %.3g m from the other's", q.x(), q.y(), least);
    }
  }
  return std::nullopt;
}

double length_of(const std::vector<const Curve*>& curves) {
  double sum = 0.0;
  for (const Curve* c : curves) sum += c->length;
  return sum;
}

/// `b` is the answer to the same question with lengths times `scale`.
Finding different(const Trial& a, const Trial& b, double scale, int turn) {
  const auto in_a = labelled(a, 1), in_b = labelled(b, turn);
  const double tolerance = 3.0 * b.chord();
  const auto longer = [&](const std::vector<const Curve*>& curves, double factor) {
    return std::count_if(curves.begin(), curves.end(),
                         [&](const Curve* c) { return c->length * factor > 20.0 * b.chord(); });
  };
  for (const auto& [label, curves] : in_a) {
    const auto found = in_b.find(label);
    const std::vector<const Curve*> none;
    const auto& others = found == in_b.end() ? none : found->second;
    if (const auto far = far_from(curves, others, scale, tolerance))
      return words_of(label) + ": " + *far;
    if (const auto far = far_from(others, curves, 1.0 / scale, tolerance / scale))
      return words_of(label) + ", of the second: " + *far;
    const double sum = length_of(curves) * scale, other_sum = length_of(others);
    if (std::abs(sum - other_sum) > 0.02 * sum + 40.0 * b.chord())
      return words_of(label) + text(": %.6g m long and %.6g", sum, other_sum);
    // Arcs of a total may be cut in two where their ring begins.
    const auto n = longer(curves, scale), m = longer(others, 1.0);
    if (n != m && !a.total()) return words_of(label) + text(": %td curves and %td", n, m);
  }
  for (const auto& [label, curves] : in_b)
    if (!in_a.contains(label) && longer(curves, 1.0) > 0)
      return words_of(label) + ": not in the first";
  return std::nullopt;
}

/// The request with the levels that it has found, so that both are asked the same.
json with_levels(const Subject& s) {
  json request = s.trial.request;
  if (!s.trial.result.levels.empty()) request["levels"] = s.trial.result.levels;
  return request;
}

Finding compare(const Subject& s, const json& again, double scale, int turn) {
  if (!s.trial.result.complete) return std::nullopt;
  try {
    const Trial other = run_trial(again);
    if (!other.result.complete) return std::nullopt;
    const auto found = different(s.trial, other, scale, turn);
    if (found && is_warned(other.result) && !is_warned(s.trial.result)) return std::nullopt;
    return found;
  } catch (const service::ProblemError& error) {
    return "refused: " + service::to_json(error.problem());
  }
}

}  // namespace

Finding check_moved(const Subject& s) {
  test::Random random(s.seed + 2);
  const Vec3 shift =
      random.uniform() * s.oracle.size() / s.oracle.scene().metres * random.direction();
  return compare(s, moved(with_levels(s), random.rotation(), shift), 1.0, 1);
}

Finding check_scaled(const Subject& s) {
  test::Random random(s.seed + 3);
  const double factor = std::pow(10.0, random.uniform(-3.0, 3.0));
  return compare(s, scaled(with_levels(s), factor), factor, 1);
}

Finding check_mirrored(const Subject& s) { return compare(s, mirrored(with_levels(s)), 1.0, -1); }

Finding check_permuted(const Subject& s) {
  if (s.trial.call.system.surfaces().size() < 2) return std::nullopt;
  return compare(s, permuted(with_levels(s)), 1.0, 1);
}

}  // namespace caustic::stress
