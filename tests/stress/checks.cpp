#include "tests/stress/checks.h"

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "service/formats/format.h"

namespace caustic::stress {

const std::vector<NamedCheck>& checks() {
  static const std::vector<NamedCheck> table = {
      {"finite", check_finite, 1, false},     {"time", check_time, 1, false},
      {"vertices", check_vertices, 1, false}, {"gradients", check_gradients, 1, false},
      {"chords", check_chords, 1, false},     {"seen", check_seen, 1, false},
      {"ends", check_ends, 1, false},         {"rings", check_rings, 1, false},
      {"meter", check_meter, 1, true},        {"inside", check_inside, 1, true},
      {"rays", check_rays, 2, true},          {"moved", check_moved, 4, true},
      {"scaled", check_scaled, 4, true},      {"mirrored", check_mirrored, 4, true},
      {"permuted", check_permuted, 4, true},  {"analysis", check_analysis, 5, true},
      {"once", check_once, 1, false}};
  return table;
}

bool late(const Subject& subject) { return thread_seconds() > subject.until; }

std::string text(const char* format, ...) {
  char buffer[400];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

std::string name_of(const Trial& trial, std::size_t i) {
  const solver::Curve& c = trial.result.curves[i];
  return text("curve %zu (%s, level %.9g, family %d, parity %d)", i, solver::to_string(c.kind),
              c.level, c.family_id, c.parity);
}

const Family& family_of(const Trial& trial, const solver::Curve& curve) {
  return trial.result.families[curve.family_id].surfaces;
}

std::vector<std::size_t> spread_over(std::size_t n, std::size_t count) {
  std::vector<std::size_t> out;
  for (std::size_t k = 0; k < std::min(n, count); ++k) {
    const std::size_t i = count >= n || count < 2 ? k : k * (n - 1) / (count - 1);
    if (out.empty() || out.back() != i) out.push_back(i);
  }
  return out;
}

Finding check_finite(const Subject& s) {
  for (const auto& [code, detail] : s.trial.result.warnings)
    if (code == "not_finite") return detail;
  for (const service::Polyline& c : s.trial.curves.curves) {
    if (!std::isfinite(c.level + c.length)) return "level or length of a curve";
    for (std::uint64_t i = 0; i < c.count; ++i) {
      const auto& v = s.trial.curves.vertices[c.first + i];
      double sum = v.irradiance + v.residual + v.arc_length + v.dark + v.bright;
      for (int k = 0; k < 3; ++k) sum += v.position[k] + v.gradient[k] + v.reflector_point[k];
      if (!std::isfinite(sum + v.uv[0] + v.uv[1])) return "a vertex of a file";
    }
  }
  // Writers convert once more; texts show what became of it.
  for (const auto write : {service::write_svg, service::write_geojson}) {
    const std::string bytes = write(s.trial.curves);
    for (const char* word : {"nan", "NaN", "inf,", "inf]", "inf ", "Infinity"})
      if (const auto at = bytes.find(word); at != std::string::npos)
        return "a file has " + bytes.substr(at > 20 ? at - 20 : 0, 40);
  }
  return std::nullopt;
}

Finding check_time(const Subject& s) {
  const double limit = s.trial.call.request.time_limit;
  // One step of any stage may be under way when the time is up.
  if (s.trial.cpu <= limit + 0.25) return std::nullopt;
  return text("%.2f s of CPU where %.2f s were allowed", s.trial.cpu, limit);
}

}  // namespace caustic::stress
