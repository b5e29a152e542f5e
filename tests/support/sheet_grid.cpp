#include "tests/support/sheet_grid.h"

#include <cmath>

#include "solver/point_irradiance.h"

namespace caustic::test {

using geometry::Vec2;
using solver::SheetIrradiance;
using Sheets = std::vector<SheetIrradiance>;

namespace {

// First hits belong together if no other is less than twice as far.
constexpr double kClear = 0.5;
constexpr int kBisections = 10;

// The sheet of that parity with the nearest first hit, if no other one is nearly as near.
const SheetIrradiance* nearest(const Sheets& sheets, const geometry::Point& x, int parity) {
  const SheetIrradiance* best = nullptr;
  double least = geometry::kInfinity, second = geometry::kInfinity;
  for (const SheetIrradiance& s : sheets) {
    const double distance = (s.hits[0] - x).norm();
    if (s.parity == parity && distance < least) best = &s;
    second = distance < least ? least : std::min(second, distance);
    least = std::min(least, distance);
  }
  return best && (best->hits[0] - x).norm() <= least && least < kClear * second ? best : nullptr;
}

}  // namespace

PlacesOnSheets places_on_sheets(const solver::OpticalSystem& system, const solver::Family& family,
                                const std::vector<double>& levels, int n) {
  solver::LightMeter meter(system, {family}, false);
  const auto at = [&](const Vec2& q) { return meter.at(q).sheets; };
  // Odd shares: symmetric scenes have their caustics and edges on even ones.
  const auto place = [&](int i, int j) -> Vec2 {
    const Vec2 w((i + 0.4871) / n, (j + 0.5113) / n);
    return (2.0 * w - Vec2::Ones()).cwiseProduct(system.receiver().half);
  };
  PlacesOnSheets found;
  const auto between = [&](const Vec2& p, const Sheets& from, const Vec2& q, const Sheets& to) {
    for (const SheetIrradiance& a : from) {
      const SheetIrradiance* b = nearest(to, a.hits[0], a.parity);
      if (!b || nearest(from, b->hits[0], a.parity) != &a) continue;
      for (const double level : levels) {
        if ((a.E > level) == (b->E > level)) continue;
        Vec2 lo = p, hi = q;
        geometry::Point x_lo = a.hits[0], x_hi = b->hits[0];
        bool lost = false;
        for (int k = 0; k < kBisections && !lost; ++k) {
          const Vec2 middle = 0.5 * (lo + hi);
          const Sheets sheets = at(middle);
          const SheetIrradiance* m = nearest(sheets, 0.5 * (x_lo + x_hi), a.parity);
          lost = !m;
          if (lost) break;
          const bool below = (m->E > level) == (a.E > level);
          (below ? lo : hi) = middle;
          (below ? x_lo : x_hi) = m->hits[0];
        }
        if (lost)
          ++found.lost;
        else
          found.places.push_back({0.5 * (lo + hi), level, a.parity});
      }
    }
  };
  std::vector<Sheets> above;
  for (int j = 0; j < n; ++j) {
    std::vector<Sheets> row;
    for (int i = 0; i < n; ++i) {
      row.push_back(at(place(i, j)));
      if (i > 0) between(place(i - 1, j), row[i - 1], place(i, j), row[i]);
      if (j > 0) between(place(i, j - 1), above[i], place(i, j), row[i]);
    }
    above = std::move(row);
  }
  return found;
}

}  // namespace caustic::test
