#include "service/formats/svg_labels.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace caustic::service {
namespace {

constexpr double kDistanceOfLabels = 420;  ///< along one curve, pixels
constexpr int kMostLabels = 3;             ///< on one curve
constexpr double kLineHeight = 14;

/// Places along a curve to try for one label, best first: shares of its stretch.
constexpr double kTries[] = {0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8, 0.12, 0.88};

/// The curve by its arc length on the page.
class Stretch {
 public:
  explicit Stretch(const std::vector<Pixel>& line) : line_(line), s_(line.size(), 0.0) {
    for (std::size_t i = 1; i < line.size(); ++i)
      s_[i] = s_[i - 1] + std::hypot(line[i].x - line[i - 1].x, line[i].y - line[i - 1].y);
  }
  double length() const { return s_.back(); }
  Pixel at(double s) const {
    const auto next = std::upper_bound(s_.begin(), s_.end(), s) - s_.begin();
    const std::size_t i = std::clamp<std::ptrdiff_t>(next, 1, std::ssize(s_) - 1);
    const double step = s_[i] - s_[i - 1], t = step > 0 ? (s - s_[i - 1]) / step : 0.0;
    return {line_[i - 1].x + t * (line_[i].x - line_[i - 1].x),
            line_[i - 1].y + t * (line_[i].y - line_[i - 1].y)};
  }

 private:
  const std::vector<Pixel>& line_;
  std::vector<double> s_;
};

}  // namespace

bool SvgLabelPlacer::is_free(const Pixel& p, double text_width) const {
  if (!plot_.contains(p, 0.5 * text_width)) return false;
  return std::none_of(taken_.begin(), taken_.end(), [&](const Pixel& other) {
    return std::hypot(p.x - other.x, p.y - other.y) < text_width + kLineHeight;
  });
}

std::vector<SvgLabel> SvgLabelPlacer::place(const std::vector<Pixel>& line, double text_width) {
  std::vector<SvgLabel> out;
  if (line.size() < 2) return out;
  const Stretch curve(line);
  if (curve.length() < 1.8 * text_width) return out;
  const int count =
      std::clamp(static_cast<int>(curve.length() / kDistanceOfLabels), 1, kMostLabels);
  for (int i = 0; i < count; ++i) {
    for (double share : kTries) {
      const double s = curve.length() * (i + share) / count;
      const Pixel at = curve.at(s), from = curve.at(s - 0.5 * text_width),
                  to = curve.at(s + 0.5 * text_width);
      const double chord = std::hypot(to.x - from.x, to.y - from.y);
      if (chord < 0.85 * text_width || !is_free(at, text_width)) continue;  // bent, or no room
      double degrees = std::atan2(to.y - from.y, to.x - from.x) * 180.0 / std::numbers::pi;
      if (degrees > 90) degrees -= 180;
      if (degrees < -90) degrees += 180;
      taken_.push_back(at);
      out.push_back({at, degrees});
      break;
    }
  }
  return out;
}

}  // namespace caustic::service
