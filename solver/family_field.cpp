#include "solver/family_field.h"

#include <algorithm>
#include <cmath>

#include "solver/flux.h"
#include "solver/gap_search.h"

namespace caustic::solver {

namespace {

// Where more than this share of the samples in the window is degenerate, the family is: rounding
// makes up the rest, near rays that are parallel to the receiver.
constexpr double kDegenerateSamples = 0.9;
// φ that varies by less than this share over the whole window is constant.
constexpr double kUniformShare = 1e-10;

// Is this corner one of those on the way along which paths end?
bool ends_paths(const Cell& cell, std::size_t k) {
  const std::size_t count = cell.polygon.size();
  return cell.polygon[k].boundary == kPathEnds ||
         cell.polygon[(k + count - 1) % count].boundary == kPathEnds;
}

}  // namespace

FamilyField::FamilyField(const OpticalSystem& system, const PlannedPiece& planned,
                         const geometry::EmbreeScene* candidates, double margin)
    : piece(planned),
      map(system, planned.hops, planned.needless.third_derivatives),
      domain(map),
      system_(system) {
  if (planned.visibility) visibility.emplace(system, candidates, margin);
}

void FamilyField::explore(Budget& budget) {
  Evaluator evaluate(map, budget);
  Hidden hidden;
  if (visibility) {
    hidden = [this, lookout = Lookout(*visibility, piece.hops)](const FieldPoint& f) mutable {
      return lookout.hidden(LightPath(map, f));
    };
  }
  exploration = solver::explore(evaluate, domain, system_, hidden, piece.needless.unseen_cells);
  measure();
  hidden_whole = visibility && samples.empty() && !exploration.cells.empty() &&
                 !shows_through_gap(evaluate, domain, exploration, *visibility, piece.hops);
  seen = !samples.empty() || (visibility && !exploration.cells.empty() &&
                              (!hidden_whole || piece.needless.hidden_family));
  if (!degenerate && !uniform && !empty()) {
    critical = find_critical_points(evaluate, domain, exploration);
    for (const CriticalPoint& c : critical) {
      const double phi = c.field.inverse_irradiance();
      phi_min = std::min(phi_min, phi);
      phi_max = std::max(phi_max, phi);
    }
  }
}

void FamilyField::measure() {
  phi_min = geometry::kInfinity;
  phi_max = -geometry::kInfinity;
  int all = 0, degenerate_samples = 0;
  FluxSum through(exploration, domain, system_.light());
  for (const Cell& cell : exploration.cells) {
    const double visible = 1.0 - cell.hidden;
    if (visible <= 0.0) continue;
    double flux_sum = 0.0, a_sum = 0.0, share = 1.0;
    for (std::size_t k = 0; k < cell.polygon.size(); ++k) {
      const FieldPoint& f = exploration.samples[cell.polygon[k].sample];
      ++all;
      degenerate_samples += f.looks_degenerate();
      if (!(f.flux > 0.0)) continue;
      const double phi = f.inverse_irradiance();
      phi_min = std::min(phi_min, phi);
      phi_max = std::max(phi_max, phi);
      // E = 0 where paths end, whatever rounding leaves of a = ∞.
      if (ends_paths(cell, k)) {
        share -= 1.0 / static_cast<double>(cell.polygon.size());
        continue;
      }
      flux_sum += f.flux;
      a_sum += std::abs(f.a);
    }
    if (flux_sum <= 0.0) continue;
    through.add(cell, visible);
    // E in the middle; of a cell cut by the domain the mean over its corners, which neither a corner
    // on the silhouette (E = 0) nor one on the caustic (E = ∞) decides alone.
    const FieldPoint& center = exploration.samples[cell.center];
    if (domain.contains(center)) {
      flux_sum = center.flux;
      a_sum = std::abs(center.a);
      share = 1.0;
    }
    const double area = visible * image_area(exploration, cell);
    if (a_sum > 0.0 && area > 0.0) samples.push_back({share * flux_sum / a_sum, area});
  }
  flux = std::max(through.value(), 0.0);
  degenerate = all > 0 && degenerate_samples >= kDegenerateSamples * all;
  const double size = std::max(std::abs(phi_min), std::abs(phi_max));
  uniform = all > 0 && phi_max - phi_min <= kUniformShare * size;
}

}  // namespace caustic::solver
