#include "solver/levels.h"

#include <algorithm>
#include <cmath>

namespace caustic::solver {

namespace {

// The contract's limit; two numbers far apart can have more between them.
constexpr std::size_t kMaxLevels = 1000;
// Percentiles this near to each other, as a share, are of a constant, which rounding puts on either
// side of any level between them.
constexpr double kConstantShare = 1e-10;

// 1, 2 and 5 times powers of ten within [min, max], as the nearest doubles.
std::vector<double> one_two_five(double min, double max) {
  std::vector<double> levels;
  const int first = static_cast<int>(std::floor(std::log10(min))) - 1;
  const int last = static_cast<int>(std::ceil(std::log10(max))) + 1;
  for (int e = first; e <= last; ++e) {
    for (const double m : {1.0, 2.0, 5.0}) {
      // Powers up to 10²² are exact, and so is one division by one of them to rounding.
      const double level = e >= 0 ? m * std::pow(10.0, e) : m / std::pow(10.0, -e);
      if (level >= min && level <= max && levels.size() < kMaxLevels) levels.push_back(level);
    }
  }
  return levels;
}

}  // namespace

std::optional<double> percentile(std::vector<WeightedIrradiance> samples, double share) {
  if (samples.empty()) return std::nullopt;
  std::sort(samples.begin(), samples.end(),
            [](const auto& a, const auto& b) { return a.irradiance < b.irradiance; });
  double total = 0.0;
  for (const auto& s : samples) total += s.area;
  double sum = 0.0;
  for (const auto& s : samples) {
    sum += s.area;
    if (sum >= share * total) return s.irradiance;
  }
  return samples.back().irradiance;
}

std::vector<double> resolve_levels(const LevelRequest& request,
                                   const std::vector<WeightedIrradiance>& samples) {
  std::vector<double> levels = request.values;
  if (levels.empty()) {
    const auto min = request.min ? request.min : percentile(samples, 0.05);
    const auto max = request.max ? request.max : percentile(samples, 0.95);
    if (!min || !max || !(*min > 0.0) || !(*min <= *max) || !std::isfinite(*max)) return {};
    if (!request.min && !request.max && *max - *min <= kConstantShare * *max) return {};
    using Spacing = LevelRequest::Spacing;
    if (request.spacing == Spacing::one_two_five) {
      levels = one_two_five(*min, *max);
    } else {
      for (int i = 0; i < request.count; ++i) {
        const double w = request.count > 1 ? double(i) / (request.count - 1) : 0.0;
        levels.push_back(request.spacing == Spacing::log ? *min * std::pow(*max / *min, w)
                                                         : *min + w * (*max - *min));
      }
      if (request.count > 1) levels.back() = *max;
    }
  }
  std::sort(levels.begin(), levels.end());
  levels.erase(std::unique(levels.begin(), levels.end()), levels.end());
  return levels;
}

}  // namespace caustic::solver
