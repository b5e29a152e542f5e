#include "solver/visibility_brackets.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "solver/shadow_places.h"

namespace caustic::solver {

namespace {

// Radius of a circle about a corner, as a share of the scene.
constexpr double kCircle = 3e-5;
constexpr int kCirclePlaces = 24;
// Edges like to lie along the axes, on which no place must be.
constexpr double kCircleOffset = 0.28;
// Next to the curve that a corner is on places are as dense as this.
constexpr double kLeastAngle = 0.003;

// Of places round a corner, more next to the curve that it is on: edges may leave at small angles.
std::vector<double> angles_round(const FieldPoint& corner, const std::optional<Vec3>& along) {
  std::vector<double> angles;
  for (int k = 0; k < kCirclePlaces; ++k)
    angles.push_back(2.0 * geometry::kPi * (k + kCircleOffset) / kCirclePlaces);
  if (along) {
    const double ahead = std::atan2(along->dot(corner.e2), along->dot(corner.e1));
    for (double off = kLeastAngle; off < 2.0 * geometry::kPi / kCirclePlaces; off *= 3.0) {
      for (const double phi :
           {ahead - off, ahead + off, ahead - off + geometry::kPi, ahead + off + geometry::kPi})
        angles.push_back(phi - 2.0 * geometry::kPi * std::floor(0.5 * phi / geometry::kPi));
    }
  }
  std::sort(angles.begin(), angles.end());
  angles.push_back(angles.front());
  return angles;
}

}  // namespace

void BracketSearch::of_cells(Budget& budget, std::vector<Bracket>& out) const {
  const Exploration& e = field_.exploration;
  enum : char { unknown, seen, unseen, nowhere };
  std::vector<char> status(e.samples.size(), unknown);
  const auto look = [&](int sample) {
    const FieldPoint& f = e.samples[sample];
    if (status[sample] != unknown) return status[sample];
    const bool there = f.arrives() && f.lit() && field_.domain.worst(f).value <= 0.0;
    return status[sample] = there ? (hidden(f) ? unseen : seen) : nowhere;
  };
  for (const Cell& cell : e.cells) {
    if (cell.hidden == 0.0 || budget.exhausted()) continue;
    const auto edge = [&](int a, int b) {
      const char at_a = look(a), at_b = look(b);
      if (at_a == seen && at_b == unseen) out.push_back({e.samples[a], e.samples[b], cell.radius});
      if (at_b == seen && at_a == unseen) out.push_back({e.samples[b], e.samples[a], cell.radius});
    };
    for (std::size_t i = 0; i < cell.polygon.size(); ++i) {
      edge(cell.polygon[i].sample, cell.polygon[(i + 1) % cell.polygon.size()].sample);
      edge(cell.polygon[i].sample, cell.center);
    }
  }
}

void BracketSearch::of_shadows(std::vector<Bracket>& out) const {
  std::vector<const FieldPoint*> seen;
  for (const Cell& cell : field_.exploration.cells) {
    const FieldPoint& f = field_.exploration.samples[cell.center];
    if (cell.hidden < 1.0 && field_.domain.contains(f) && !hidden(f)) seen.push_back(&f);
  }
  if (seen.empty()) return;
  for (const auto& places : places_behind_surfaces(carrier_.system())) {
    for (const Point& x : places) {
      FieldPoint f = evaluate_.on_surface(x);
      if (!hidden(f)) continue;
      const auto nearest = *std::min_element(
          seen.begin(), seen.end(), [&](const FieldPoint* a, const FieldPoint* b) {
            return (a->x - x).squaredNorm() < (b->x - x).squaredNorm();
          });
      out.push_back({*nearest, f, (nearest->x - x).norm()});
      break;
    }
  }
}

double BracketSearch::radius() const { return kCircle * carrier_.system().diameter(); }

void BracketSearch::around(const FieldPoint& corner, double reach, const std::optional<Vec3>& along,
                           std::vector<Bracket>& out) const {
  std::vector<std::pair<FieldPoint, bool>> circle;  // hidden or not
  for (const double phi : angles_round(corner, along)) {
    const Vec3 step = radius() * (std::cos(phi) * corner.e1 + std::sin(phi) * corner.e2);
    FieldPoint f = evaluate_.on_surface(corner.x + step, corner.hits.get());
    if (!f.lit() || !field_.domain.contains(f)) {
      circle.clear();
      continue;
    }
    const bool is_hidden = hidden(f);
    if (!circle.empty() && circle.back().second != is_hidden) {
      const FieldPoint& before = circle.back().first;
      out.push_back(is_hidden ? Bracket{before, f, reach} : Bracket{f, before, reach});
    }
    circle.assign(1, {std::move(f), is_hidden});
  }
}

}  // namespace caustic::solver
