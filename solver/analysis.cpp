#include "solver/analysis.h"

#include <algorithm>

#include "solver/region_integrals.h"
#include "solver/total_contours.h"
#include "solver/total_extremes.h"

namespace caustic::solver {

namespace {

class Analyst final : public TotalObserver {
 public:
  explicit Analyst(Analysis& out) : out_(out) {}

  void boundaries(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves,
                  const BoundaryPieces& pieces) override {
    integrator_.emplace(carrier, curves);
    out_.unsupported = integrator_->unsupported();
    if (out_.unsupported) return;
    const RegionIntegrals all = integrator_->all(pieces);
    out_.flux = all.flux;
    out_.undecided += all.unresolved;
    const TotalExtremes extremes = find_extremes(carrier, curves, pieces.pieces);
    out_.min = extremes.min;
    out_.max = extremes.max;
  }
  void level_on_boundaries(double level, const LevelOnBoundaries& found) override {
    integrator_->begin(level, found);
  }
  void level_arc(double, const LevelArc& arc) override { integrator_->add(arc); }
  void level_traced(double level, std::size_t unresolved) override {
    const RegionIntegrals region = integrator_->result(unresolved);
    out_.levels.push_back({level, region.area, region.flux});
    out_.undecided += region.unresolved;
  }

 private:
  Analysis& out_;
  std::optional<RegionIntegrator> integrator_;
};

// Of families that were left out for bringing next to nothing.
double flux_left_out(const ContourResult& result, const ContourRequest& request) {
  if (!request.families.empty()) return 0.0;
  double all = 0.0, faint = 0.0;
  for (const FamilyReport& family : result.families) all += family.flux;
  for (const FamilyReport& family : result.families) {
    if (family.flux < request.min_flux_share * all) faint += family.flux;
  }
  return faint;
}

bool warned(const ContourResult& result, const char* code) {
  return std::any_of(result.warnings.begin(), result.warnings.end(),
                     [&](const Warning& w) { return w.code == code; });
}

}  // namespace

Analysis analyse(const OpticalSystem& system, ContourRequest request) {
  Analysis out;
  Analyst analyst(out);
  request.measure = Measure::total;
  request.isolux = true;
  request.caustic = false;
  request.observer = &analyst;
  const ContourResult result = trace_contours(system, request);
  if (result.unsupported) out.unsupported = result.unsupported;
  if (warned(result, "degenerate_family"))
    out.unsupported = "the analysis of light that is all focused into one point or line";
  if (out.unsupported) return out;
  out.complete = result.complete;
  out.warnings = result.warnings;
  if (out.undecided > 0) {
    out.warnings.push_back({"unresolved", std::to_string(out.undecided) +
                                              " pieces of edges could not be followed: where they "
                                              "matter, errors are as large as areas and fluxes may "
                                              "be"});
  }
  out.undecided += result.undecided_cells;
  // Next to what could not be settled there may be a darker place.
  if (out.undecided > 0) out.min.E.error = std::max(out.min.E.error, out.min.E.value);
  // Where nothing is lit, nothing was traced.
  if (out.levels.empty()) {
    for (const double level : result.levels) out.levels.push_back({level, {}, {}});
  }
  const double left_out = flux_left_out(result, request);
  out.flux.error += left_out;
  for (LevelAnalysis& level : out.levels) level.flux.error += left_out;
  const Vec2& half = system.receiver().half;
  const double area = 4.0 * half.x() * half.y();
  out.average = {out.flux.value / area, out.flux.error / area};
  return out;
}

}  // namespace caustic::solver
