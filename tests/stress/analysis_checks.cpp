// What an analysis promises holds for readings at random places, also where it could not settle
// everything.
#include <cmath>

#include "service/api/analysis_json.h"
#include "service/api/problem.h"
#include "solver/point_irradiance.h"
#include "tests/stress/checks.h"

namespace caustic::stress {
namespace {

using solver::Analysis;
using solver::Estimate;

constexpr int kReadings = 60;

Finding wrong_order(const Analysis& analysis, double all) {
  Estimate area{all, 0.0}, flux = analysis.flux;
  for (const auto& level : analysis.levels) {
    if (!(level.area.error >= 0.0 && level.flux.error >= 0.0)) return "an error is no number";
    if (level.area.value - level.area.error > area.value + area.error + 1e-12 * all)
      return text("area above %.9g is larger than above less", level.level);
    if (level.flux.value - level.flux.error > flux.value + flux.error + 1e-12 * flux.value)
      return text("flux above %.9g is larger than above less", level.level);
    if (level.area.value < -level.area.error) return text("area above %.9g < 0", level.level);
    // All of it is at least that bright.
    const double least = level.level * (level.area.value - level.area.error);
    if (level.flux.value + level.flux.error < least * (1.0 - 1e-9))
      return text("flux above %.9g is less than area times level", level.level);
    area = level.area, flux = level.flux;
  }
  return std::nullopt;
}

}  // namespace

Finding wrong_estimates(const Subject& s, const Analysis& analysis) {
  if (analysis.unsupported || !analysis.complete || analysis.levels.empty()) return std::nullopt;
  for (const auto& warning : analysis.warnings)
    if (warning.code == "unresolved") return std::nullopt;  // its errors are as large as can be
  const solver::OpticalSystem& system = s.trial.call.system;
  const Vec2 half = system.receiver().half;
  const double all = 4.0 * half.x() * half.y();
  if (const auto wrong = wrong_order(analysis, all)) return wrong;
  std::vector<Family> families;
  for (const auto& f : s.trial.result.families) families.push_back(f.surfaces);
  solver::LightMeter meter(system, families, s.trial.call.request.direct);
  test::Random random(s.seed + 4);
  std::vector<int> inside(analysis.levels.size());
  int read = 0;
  for (int k = 0; k < kReadings * s.effort && !late(s); ++k) {
    const Vec2 q(random.uniform(-half.x(), half.x()), random.uniform(-half.y(), half.y()));
    const auto reading = meter.at(q);
    if (reading.on_caustic) continue;
    ++read;
    for (std::size_t i = 0; i < inside.size(); ++i)
      inside[i] += reading.E >= analysis.levels[i].level;
    const double rounding = 1e-8 * reading.E;
    if (!analysis.max.unbounded && analysis.undecided == 0 &&
        reading.E > analysis.max.E.value + analysis.max.E.error + rounding)
      return text("E = %.9g at (%.9g, %.9g) m, said to be at most %.9g", reading.E, q.x(), q.y(),
                  analysis.max.E.value);
    if (reading.E < analysis.min.E.value - analysis.min.E.error - rounding)
      return text("E = %.9g at (%.9g, %.9g) m, said to be at least %.9g", reading.E, q.x(), q.y(),
                  analysis.min.E.value);
  }
  if (read == 0) return std::nullopt;
  for (std::size_t i = 0; i < inside.size(); ++i) {
    const double share = inside[i] / static_cast<double>(read);
    const double noise = std::sqrt(std::max(share * (1.0 - share), 1.0 / read) / read) * all;
    const Estimate& area = analysis.levels[i].area;
    if (std::abs(area.value - share * all) > area.error + 6.0 * noise)
      return text("area above %.9g is %.6g m2, of random places %.6g", analysis.levels[i].level,
                  area.value, share * all);
  }
  return std::nullopt;
}

Finding check_analysis(const Subject& s) {
  json request = {{"scene", s.trial.request["scene"]}};
  for (const char* key : {"families", "levels", "direct"})
    if (s.trial.request.contains(key)) request[key] = s.trial.request[key];
  service::AnalysisCall call = service::read_analysis_call(request.dump());
  call.request.time_limit = s.trial.call.request.time_limit;
  return wrong_estimates(s, solver::analyse(call.system, call.request));
}

}  // namespace caustic::stress
