#include "solver/region_integrals.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace caustic::solver {

namespace {

// Gauss's rule of two points on [−1, 1] and Kronrod's of five that contains them: exact for cubics
// and for degree 7.
constexpr std::array<double, 5> kPlaces{-0.92582009977255146, -0.57735026918962576, 0.0,
                                        0.57735026918962576, 0.92582009977255146};
constexpr std::array<double, 5> kWeights{98.0 / 495.0, 27.0 / 55.0, 28.0 / 45.0, 27.0 / 55.0,
                                         98.0 / 495.0};
// A segment is halved until it is wrong by less than this share of the whole, or so often.
constexpr double kSegmentShare = 1e-11;
constexpr int kMaxSegmentHalvings = 12;
constexpr double kNoiseFactor = 4.0;
// An edge whose ends are further apart than this share of the whole is open.
constexpr double kOpenShare = 1e-5;
// Sums of terms of the size of the whole, each wrong by some roundings.
constexpr double kSumRoundings = 8.0;

enum { kArea, kFlux, kNoise, kShareError, kClosing, kClosingFlux = kClosing + 2 };

// Of a value that is sure to lie between 0 and `most`, and of nothing else.
void bound(Estimate& estimate, double most) {
  estimate.value = std::clamp(estimate.value, 0.0, most);
  estimate.error = std::max(estimate.value, most - estimate.value);
}

}  // namespace

RegionIntegrator::RegionIntegrator(SheetCarrier& carrier, const std::vector<BoundaryCurve>& curves)
    : carrier_(carrier), curves_(curves) {
  const Vec2& half = carrier.system().receiver().half;
  area_scale_ = 4.0 * half.x() * half.y();
  for (int i = 0; i < carrier.field_count(); ++i) {
    potentials_.emplace_back(carrier.field(i), carrier.system().light());
    flux_scale_ += carrier.field(i).flux;
    most_flux_ += potentials_.back().power();
    const auto& pole = potentials_.back().pole();
    pole_totals_.push_back(pole ? total_of(carrier.find(pole->q)).E : 0.0);
  }
}

std::optional<std::string> RegionIntegrator::unsupported() const {
  for (const FluxPotential& potential : potentials_) {
    if (potential.lacks_pole_flux())
      return "the analysis of light that goes all round and loses a share which varies with the "
             "angle";
  }
  return std::nullopt;
}

// s A(x)[dx], and the exact form.
void RegionIntegrator::add_sheet(const Branch& sheet, const Vec3& dx, Density& sum) const {
  const double s = std::copysign(1.0, sheet.at.a);
  const FluxPotential& potential = potentials_[sheet.field];
  const Estimate term = potential.along(sheet.at.x, dx);
  sum[kFlux] += s * term.value;
  sum[kShareError] += term.error;
  sum.segment<3>(kClosingFlux) += s * potential.closing(sheet.at.x, dx);
}

RegionIntegrator::Density RegionIntegrator::level_density(const ArcPoint& at) const {
  Density sum = Density::Zero();
  for (const Branch& b : at.branches) add_sheet(b, b.at.pull_back(at.dq), sum);
  sum[kArea] = 0.5 * (at.q.x() * at.dq.y() - at.q.y() * at.dq.x());
  const double moved =
      rounding_of_total(carrier_, at.branches) / total_of(at.branches).gradient.norm();
  sum[kNoise] = (moved + at.off) * at.dq.norm();
  sum.segment<2>(kClosing) = at.dq;
  return sum;
}

RegionIntegrator::Density RegionIntegrator::boundary_density(const ArcPoint& at, int field,
                                                             const Count& count) const {
  Density sum = Density::Zero();
  const Vec2 dq = count.turned ? Vec2(-at.dq) : at.dq;
  if (count.others) {
    for (const Branch& b : at.branches) add_sheet(b, b.at.pull_back(dq), sum);
  }
  if (count.inside) add_sheet({field, *at.own}, at.dx, sum);
  // The boundary runs with its inside on the left.
  for (const Companion& c : at.companions) {
    if (!(c.inside ? count.inside : count.outside)) continue;
    const Vec3 dx = c.sheet.at.pull_back(at.dq);
    add_sheet(c.sheet, c.inside ? dx : Vec3(-dx), sum);
  }
  if (count.area) {
    sum[kArea] = 0.5 * (at.q.x() * dq.y() - at.q.y() * dq.x());
    sum.segment<2>(kClosing) = dq;
  }
  return sum;
}

template <class DensityAt>
void RegionIntegrator::integrate(const DensityAt& density_at, double begin, double end, int depth) {
  Density five = Density::Zero(), two = five;
  const double half = 0.5 * (end - begin);
  for (std::size_t k = 0; k < kPlaces.size(); ++k) {
    const std::optional<Density> at = density_at(begin + half * (1.0 + kPlaces[k]));
    ++points_;
    if (!at || !at->allFinite()) {
      ++unresolved_;
      return;
    }
    five += half * kWeights[k] * *at;
    if (k == 1 || k == 3) two += half * *at;
  }
  const Density error = (five - two).cwiseAbs();
  // What points are off by themselves does not become less by halving.
  const double area_noise = kNoiseFactor * five[kNoise],
               flux_noise = level_ * area_noise + kNoiseFactor * five[kShareError];
  const bool rough = error[kArea] > kSegmentShare * area_scale_ + area_noise ||
                     error[kFlux] > kSegmentShare * flux_scale_ + flux_noise;
  if (rough && depth < kMaxSegmentHalvings) {
    integrate(density_at, begin, begin + half, depth + 1);
    integrate(density_at, begin + half, end, depth + 1);
    return;
  }
  sum_ += five;
  errors_ += error;
}

void RegionIntegrator::add(const BoundaryCurve& curve, const std::vector<BoundaryVertex>& vertices,
                           bool closed, const Count& count) {
  const std::size_t n = vertices.size();
  for (std::size_t i = 0; i < (closed ? n : n - 1); ++i) {
    const BoundaryVertex &a = vertices[i], &b = vertices[(i + 1) % n];
    integrate(
        [&](double t) -> std::optional<Density> {
          const auto at = along_boundary(carrier_, curve, a, b, t);
          if (!at) return std::nullopt;
          return boundary_density(*at, curve.field, count);
        },
        0.0, 1.0);
  }
}

RegionIntegrals RegionIntegrator::all(const BoundaryPieces& pieces) {
  begin(0.0, {});
  for (const BoundaryPiece& piece : pieces.pieces) {
    const BoundaryCurve& curve = curves_[piece.curve];
    if (curve.kind == BoundaryKind::caustic) continue;
    const bool edge = curve.on_receiver_edge();
    // A closed piece repeats its first vertex.
    add(curve, piece.vertices, false, {edge, !edge, !edge, edge});
  }
  const RegionIntegrals all = result(pieces.unresolved);
  unsure_ = pieces.unresolved + all.unresolved > 0;
  most_flux_ = std::min(most_flux_, all.flux.value + all.flux.error);
  return all;
}

void RegionIntegrator::begin(double level, const LevelOnBoundaries& found) {
  level_ = level;
  sum_.setZero();
  errors_.setZero();
  unresolved_ = points_ = 0;
  for (const JumpArc& jump : found.jumps) {
    const BoundaryCurve& curve = curves_[jump.curve];
    const bool ends = curve.kind != BoundaryKind::caustic && !curve.on_receiver_edge();
    add(curve, jump.vertices, jump.closed,
        {true, ends && !jump.turned, ends && jump.turned, true, jump.turned});
  }
  for (const JumpArc& within : found.within) {
    const BoundaryCurve& curve = curves_[within.curve];
    if (curve.kind == BoundaryKind::caustic) continue;
    add(curve, within.vertices, within.closed, {false, true, true, false});
  }
}

void RegionIntegrator::add(const LevelArc& arc) {
  const std::size_t n = arc.vertices.size();
  for (std::size_t i = 0; i < (arc.closed ? n : n - 1); ++i) {
    const ArcVertex &a = arc.vertices[i], &b = arc.vertices[(i + 1) % n];
    integrate(
        [&](double t) -> std::optional<Density> {
          const auto at = along_level(carrier_, level_, a, b, t);
          if (!at) return std::nullopt;
          return level_density(*at);
        },
        0.0, 1.0);
  }
}

double RegionIntegrator::flux_beyond_poles() const {
  double sum = 0.0;
  for (std::size_t k = 0; k < potentials_.size(); ++k) {
    if (potentials_[k].pole() && pole_totals_[k] >= level_) sum += potentials_[k].pole_flux();
  }
  return sum;
}

RegionIntegrals RegionIntegrator::result(std::size_t unresolved) {
  const double rounding = kSumRoundings * geometry::kEpsilon * double(points_);
  const double lever = carrier_.system().receiver().half.norm();
  RegionIntegrals out;
  out.area.value = sum_[kArea];
  out.area.error = errors_[kArea] + sum_[kNoise] + 0.5 * lever * sum_.segment<2>(kClosing).norm() +
                   rounding * area_scale_;
  out.flux.value = sum_[kFlux] + flux_beyond_poles();
  out.flux.error = errors_[kFlux] + sum_[kShareError] + level_ * sum_[kNoise] +
                   sum_.segment<3>(kClosingFlux).norm() + rounding * flux_scale_;
  // An edge that does not close lacks a part.
  const bool open = sum_.segment<2>(kClosing).norm() > kOpenShare * lever ||
                    sum_.segment<3>(kClosingFlux).norm() > kOpenShare * flux_scale_;
  out.unresolved = unresolved_ + open;
  if (unresolved + out.unresolved > 0 || unsure_) {
    bound(out.area, area_scale_);
    bound(out.flux, most_flux_);
  }
  return out;
}

}  // namespace caustic::solver
