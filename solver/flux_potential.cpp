#include "solver/flux_potential.h"

#include <algorithm>
#include <cmath>

namespace caustic::solver {

namespace {

// Lit cells keep the pole this far away, rad, beyond their own angular radius.
constexpr double kPoleClearance = 0.1;

}  // namespace

FluxPotential::FluxPotential(const FamilyField& field, const Light& light)
    : point_source_(std::holds_alternative<PointLight>(light)), strength_(field.map.strength()) {
  if (point_source_) {
    source_ = std::get<PointLight>(light).position;
    turn_away(field);
  } else {
    source_ = std::get<CollimatedLight>(light).direction;
    move_to_middle(field);
  }
  for (int hop = 0; hop < field.map.hop_count(); ++hop) {
    if (!share_ && !field.map.surface(hop).optics.constant_share())
      share_.emplace(field.map, axis_);
  }
}

// c is in the middle of what is lit.
void FluxPotential::move_to_middle(const FamilyField& field) {
  const Exploration& e = field.exploration;
  axis_ = Vec3::Zero();
  for (const Cell& cell : e.cells) axis_ += e.samples[cell.center].x / double(e.cells.size());
  for (const Cell& cell : e.cells) {
    reach_ = std::max(reach_, (e.samples[cell.center].x - axis_).norm() + cell.radius);
  }
}

// b is the direction, of some, whose opposite is furthest from all light that matters. Where light
// goes all round, the pole is the middle of the cell that is widest as the source sees it.
void FluxPotential::turn_away(const FamilyField& field) {
  struct Beam {
    Vec3 direction;
    double angle;
    int sample;
  };
  std::vector<Beam> beams;
  Vec3 mean = Vec3::Zero();
  for (const Cell& cell : field.exploration.cells) {
    const Vec3 d = field.exploration.samples[cell.center].x - source_;
    beams.push_back({d.normalized(), cell.radius / d.norm(), cell.center});
    mean += beams.back().direction;
  }
  std::vector<Vec3> candidates{mean.norm() > 0.0 ? mean.normalized() : Vec3::UnitZ()};
  for (const double x : {-1.0, 0.0, 1.0}) {
    for (const double y : {-1.0, 0.0, 1.0}) {
      for (const double z : {-1.0, 0.0, 1.0}) {
        if (x != 0.0 || y != 0.0 || z != 0.0) candidates.push_back(Vec3(x, y, z).normalized());
      }
    }
  }
  double best = -geometry::kInfinity;
  for (const Vec3& b : candidates) {
    double clearance = geometry::kInfinity;
    for (const Beam& beam : beams) {
      const double cosine = std::clamp(-b.dot(beam.direction), -1.0, 1.0);
      clearance = std::min(clearance, std::acos(cosine) - beam.angle);
    }
    if (clearance > best) best = clearance, axis_ = b;
    if (best > 0.5 * geometry::kPi) break;  // the first is as good as any
  }
  if (best > kPoleClearance) return;
  const Beam& widest = *std::max_element(
      beams.begin(), beams.end(), [](const Beam& a, const Beam& b) { return a.angle < b.angle; });
  axis_ = -widest.direction;
  pole_ = field.exploration.samples[widest.sample];
}

Estimate FluxPotential::along(const Point& x, const Vec3& dx) const {
  double A;
  if (point_source_) {
    const Vec3 d = x - source_;
    const double distance = d.norm(), cosine = axis_.dot(d) / distance;
    A = -strength_ * axis_.dot(d.cross(dx)) / (distance * distance * (1.0 + cosine));
  } else {
    A = -0.5 * strength_ * source_.dot((x - axis_).cross(dx));
  }
  if (!share_) return {A, 0.0};
  const Estimate share = share_->at(x);
  return {A * share.value, std::abs(A) * share.error};
}

Vec3 FluxPotential::closing(const Point& x, const Vec3& dx) const {
  if (!point_source_) return strength_ * reach_ * dx;
  const Vec3 d = x - source_;
  const double distance2 = d.squaredNorm();
  return strength_ / std::sqrt(distance2) * (dx - d * (d.dot(dx) / distance2));
}

}  // namespace caustic::solver
