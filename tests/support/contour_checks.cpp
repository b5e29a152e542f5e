#include "tests/support/contour_checks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "solver/itineraries.h"

namespace caustic::test {

using namespace solver;
using geometry::Point;
using geometry::Vec2;
using geometry::Vec3;

bool in_sight(const OpticalSystem& system, const FieldPoint& f, int hops) {
  const double size = system.diameter();
  const auto free = [&](const Point& from, const Vec3& way, double end_margin) {
    const double length = way.norm();
    for (const SystemSurface& s : system.surfaces()) {
      std::vector<double> roots;
      s.shape->crossings({from, way}, 0.0, 1.0, roots);
      for (const double t : roots) {
        if (t * length < 1e-7 * size || (1.0 - t) * length < end_margin * size) continue;
        if (geometry::exists_at(s.bounds, from + t * way)) return false;
      }
    }
    return true;
  };
  // Hit by hop, then to the receiver.
  std::vector<Point> stations{f.x};
  for (int j = 1; f.hits && j < hops; ++j) stations.push_back(f.hits[j].y);
  stations.push_back(system.receiver().point(f.q));
  if (const auto* point = std::get_if<PointLight>(&system.light())) {
    if (!free(f.x, point->position - f.x, 1e-7)) return false;
  } else {
    // A beam comes from beyond everything.
    if (!free(f.x, -4e3 * size * std::get<CollimatedLight>(system.light()).direction, 0.0)) {
      return false;
    }
  }
  for (std::size_t j = 1; j < stations.size(); ++j) {
    const bool last = j + 1 == stations.size();
    if (!free(stations[j - 1], stations[j] - stations[j - 1], last ? 1e-10 : 1e-7)) return false;
  }
  return true;
}

namespace {

// Which side of the mirror sees the light along a curve: ends may lie on the silhouette.
int lit_side(const OpticalSystem& system, int surface, const Curve& c) {
  const ForwardMap map(system, surface, 1);
  double largest = 0.0;
  for (const CurveVertex& v : c.vertices) {
    const double cosine = map.evaluate(v.x).cos_alpha;
    if (std::abs(cosine) > std::abs(largest)) largest = cosine;
  }
  return largest >= 0.0 ? 1 : -1;
}

// The sides by which a curve's family runs: those that lead from its reflector points to its image.
Hops hops_of(const OpticalSystem& system, const std::vector<int>& family, const Curve& c) {
  const int side = lit_side(system, family[0], c);
  if (family.size() == 1) return {{family[0], side}};
  const CurveVertex& v = c.vertices[c.vertices.size() / 2];
  Hops best;
  double least = geometry::kInfinity;
  for (const Hops& hops : sides_of(system, family, side)) {
    const double off = (ForwardMap(system, hops).arrival(v.x) - v.uv).norm();
    if (off < least) {
      least = off;
      best = hops;
    }
  }
  return best;
}

// Next to a place where all levels meet, and E is undetermined: a and σ vanish together, or the ray
// runs within the receiver's plane.
bool all_levels_meet(const ForwardMap& map, const FieldPoint& f) {
  return std::abs(f.a) < 1e-3 * f.scale_of_a() &&
         (std::abs(f.cos_alpha) < 1e-5 || std::abs(f.facing) < 1e-4 * map.incident(f.x).norm());
}

// The height of an asphere and its derivatives cancel near its last radius.
bool near_rim(const SystemSurface& mirror, const Point& x) {
  for (const auto& b : mirror.bounds) {
    if (b.origin == geometry::Bound::Origin::shape && !mirror.shape->at_most_quadratic() &&
        b.value(x) > -1e-5 * b.radius) {
      return true;
    }
  }
  return false;
}

void expect_end(const OpticalSystem& system, const ForwardMap& map, const FieldPoint& f,
                Ending ending, bool caustic, const std::string& what) {
  const double size = system.diameter(), width = system.receiver().width();
  const double slope = 1.0 + f.q_s.norm() + f.q_t.norm();
  const bool meet = all_levels_meet(map, f);
  const double slack = meet ? 1e-5 : near_rim(map.mirror(), f.x) ? 1e-7 : 1e-10;
  switch (ending) {
    case Ending::receiver_edge: {
      const Vec2 gap = system.receiver().half - f.q.cwiseAbs();
      EXPECT_LE(gap.cwiseAbs().minCoeff(), slack * width + 1e-13 * size * slope) << what;
      break;
    }
    case Ending::aperture: {
      double nearest = geometry::kInfinity;
      for (int j = 0; j < map.hop_count(); ++j) {
        for (const auto& b : map.surface(j).bounds) {
          nearest = std::min(nearest, std::abs(b.value(j == 0 ? f.x : f.hits[j].y)));
        }
      }
      EXPECT_LE(nearest, slack * size) << what;
      break;
    }
    case Ending::silhouette:
      EXPECT_TRUE(caustic || meet)
          << what << ": isolux curves never end at a silhouette; a " << f.a / f.scale_of_a();
      EXPECT_NEAR(f.cos_alpha, 0.0, meet ? 1e-5 : 1e-9) << what;
      break;
    case Ending::total_internal_reflection:
      EXPECT_NEAR(f.hits[map.hop_count() - 1].headroom, 0.0, 1e-5) << what;
      break;
    case Ending::shadow:
    case Ending::occlusion:
      break;  // in sight on one side only
    case Ending::limit:
      EXPECT_TRUE(meet) << what << ": stalled at x " << f.x.transpose() << " q " << f.q.transpose()
                        << " a " << f.a / f.scale_of_a() << " cos " << f.cos_alpha << " facing "
                        << f.facing << " lambda " << f.lambda;
      break;
    case Ending::node:
      ADD_FAILURE() << what << ": a sheet's curve ends at a node";
      break;
  }
}

}  // namespace

void expect_sound(const OpticalSystem& system, const ContourResult& result, double tolerance,
                  const std::string& what) {
  const auto& receiver = system.receiver();
  for (std::size_t i = 0; i < result.curves.size(); ++i) {
    const Curve& c = result.curves[i];
    const bool caustic = c.kind == CurveKind::caustic;
    const std::string name =
        what + ", curve " + std::to_string(i) + " level " + std::to_string(c.level);
    ASSERT_GE(c.vertices.size(), 2u) << name;
    ASSERT_EQ(c.ends.size(), c.closed ? 0u : 2u) << name;
    ASSERT_GE(c.family_id, 0);
    const int surface = result.families[c.family_id].surfaces[0];
    const SystemSurface& mirror = system.surfaces()[surface];
    const Hops hops = hops_of(system, result.families[c.family_id].surfaces, c);
    ASSERT_FALSE(hops.empty()) << name;
    const ForwardMap map(system, hops);
    double length = 0.0, worst = 0.0;
    int bad = 0;
    for (std::size_t k = 0; k < c.vertices.size() && bad < 3; ++k) {
      const CurveVertex& v = c.vertices[k];
      const FieldPoint f = map.evaluate(v.x);
      const bool failed = testing::Test::HasFailure();
      const std::string at =
          name + " vertex " + std::to_string(k) + " of " + std::to_string(c.vertices.size());
      ASSERT_TRUE(f.finite && v.uv.allFinite() && v.p.allFinite() && v.gradient.allFinite() &&
                  std::isfinite(v.irradiance) && std::isfinite(v.residual))
          << at;
      const double slope = 1.0 + f.q_s.norm() + f.q_t.norm();
      // A path that rounding bends at each hop.
      const double rounding = 64.0 * map.hop_count() * map.rounding(v.x) * slope;
      EXPECT_LE((v.uv - f.q).norm(), rounding) << at;
      EXPECT_LE((v.p - receiver.point(v.uv)).norm(), 1e-14 * system.diameter()) << at;
      const double edge = (v.uv.cwiseAbs() - receiver.half).maxCoeff();
      EXPECT_LE(edge, 1e-9 * receiver.width() + rounding) << at;
      const double off = (map.project(v.x) - v.x).norm();
      EXPECT_LE(off, (near_rim(mirror, v.x) ? 128.0 : 16.0) * map.rounding(v.x)) << at;
      EXPECT_TRUE(geometry::exists_at(mirror.bounds, v.x, 1e-9 * system.diameter())) << at;
      EXPECT_GT(f.cos_alpha, -1e-9) << at;
      const bool at_end = !c.closed && (k == 0 || k + 1 == c.vertices.size());
      const double behind = all_levels_meet(map, f) ? 1e-6 : 1e-11 * slope;
      EXPECT_TRUE(at_end ? f.lambda >= -behind : f.arrives()) << at << " lambda " << f.lambda;
      // What the rounding of x allows, (S14).
      if (caustic) {
        EXPECT_EQ(v.irradiance, -1.0);
        EXPECT_EQ(v.gradient.norm(), 0.0);
        const double allowed = 64.0 * (map.rounding(v.x) * f.grad_a.norm() / f.scale_of_a() +
                                       geometry::kEpsilon * slope) +
                               (near_rim(mirror, v.x) ? 1e-8 : 0.0);
        EXPECT_LE(std::abs(f.a) / f.scale_of_a(), tolerance + allowed) << at;
      } else {
        const Vec3 grad = f.grad_a - (f.a / f.flux) * f.grad_flux;
        double allowed = 64.0 * map.hop_count() * map.rounding(v.x) * grad.norm() / std::abs(f.a);
        // Cancellation in a, which steep maps (cones at their apex) make worse.
        allowed += 64.0 * geometry::kEpsilon * slope * f.scale_of_a() / std::abs(f.a);
        if (near_rim(mirror, v.x)) allowed += 1e-7;
        EXPECT_LE(std::abs(f.irradiance() / c.level - 1.0), tolerance + allowed) << at;
        EXPECT_EQ(f.a > 0.0, c.parity > 0) << at;
        EXPECT_NEAR(v.residual, std::abs(v.irradiance / c.level - 1.0), 1e-15) << at;
      }
      worst = std::max(worst, v.residual);
      if (k > 0) length += (v.p - c.vertices[k - 1].p).norm();
      EXPECT_NEAR(v.arc_length, length, 1e-12 * (system.diameter() + length)) << at;
      EXPECT_TRUE(at_end || in_sight(system, f, map.hop_count()))
          << at << ": hidden, x " << v.x.transpose();
      if (at_end) expect_end(system, map, f, c.ends[k == 0 ? 0 : 1], caustic, at);
      bad += testing::Test::HasFailure() && !failed;
    }
    if (bad >= 3) continue;
    if (c.closed) length += (c.vertices.back().p - c.vertices.front().p).norm();
    EXPECT_NEAR(c.length, length, 1e-12 * (system.diameter() + length)) << name;
    EXPECT_EQ(c.max_residual, worst) << name;
  }
}

double largest_chord_error(const OpticalSystem& system, const Curve& c, int samples) {
  const std::size_t n = c.vertices.size();
  const ForwardMap map(system, 0, lit_side(system, 0, c));
  double worst = 0.0;
  for (std::size_t i = 0; i + (c.closed ? 0 : 1) < n; ++i) {
    const CurveVertex &a = c.vertices[i], &b = c.vertices[(i + 1) % n];
    const double k = c.kind == CurveKind::caustic ? 0.0 : c.parity / c.level;
    const Vec2 chord = b.uv - a.uv;
    const double length2 = chord.squaredNorm();
    for (int j = 1; j <= samples; ++j) {
      const double w = j / (samples + 1.0);
      Point x = map.project(a.x + w * (b.x - a.x));
      const Point start = x;
      FieldPoint f = map.evaluate(x);
      for (int step = 0; step < 12; ++step) {
        const Vec3 slope = f.grad_a - k * f.grad_flux;
        x = map.project(x - ((f.a - k * f.flux) / slope.squaredNorm()) * slope);
        f = map.evaluate(x);
      }
      // A step turns by half a radian at most and bulges by a sixteenth. Newton's method may have
      // gone to another branch, and where the map is steep beyond measure rounding of x moves q by
      // more: not this test's matter.
      const double noise = map.rounding(x) * (f.q_s.norm() + f.q_t.norm());
      if (!f.finite || (x - start).norm() > 0.08 * (b.x - a.x).norm() || noise > 1e-9) continue;
      const Vec2 off = f.q - a.uv;
      const double along = length2 > 0.0 ? std::clamp(off.dot(chord) / length2, 0.0, 1.0) : 0.0;
      worst = std::max(worst, (off - along * chord).norm());
    }
  }
  return worst;
}

std::vector<FieldPoint> points_on_grid(const OpticalSystem& system, int surface, int side,
                                       double level, int parity, int n) {
  const ForwardMap map(system, surface, side);
  const auto& mirror = map.mirror();
  const auto charts = map.shape().charts({mirror.region, system.center(), system.diameter()});
  const auto f_of = [&](const FieldPoint& f) { return f.a - parity / level * f.flux; };
  std::vector<FieldPoint> found;
  // Surfaces without global coordinates have many small charts.
  const double share = std::sqrt(6.0 / std::max(6.0, static_cast<double>(charts.size())));
  n = std::max(4, static_cast<int>(n * share));
  for (const auto& chart : charts) {
    struct Node {
      double s, t, f, facing;
      bool inside;
    };
    const auto node_at = [&](double s, double t) {
      const FieldPoint f = map.evaluate(chart.point(s, t));
      const bool inside = f.arrives() && f.lit() && system.receiver().contains(f.q) &&
                          geometry::exists_at(mirror.bounds, f.x) &&
                          geometry::exists_at(chart.cell, f.x);
      return Node{s, t, f_of(f), f.facing, inside};
    };
    std::vector<Node> nodes;
    for (int i = 0; i <= n; ++i) {
      for (int j = 0; j <= n; ++j) nodes.push_back(node_at(double(i) / n, double(j) / n));
    }
    const auto edge = [&](Node a, Node b) {
      if (!a.inside || !b.inside || (a.f > 0.0) == (b.f > 0.0) || a.facing * b.facing < 0.0) return;
      for (int k = 0; k < 60; ++k) {
        const Node m = node_at(0.5 * (a.s + b.s), 0.5 * (a.t + b.t));
        ((m.f > 0.0) == (a.f > 0.0) ? a : b) = m;
      }
      // On the way the edge may leave the receiver or the aperture, and cross the level there.
      const FieldPoint f = map.evaluate(chart.point(a.s, a.t));
      if (f.finite && node_at(a.s, a.t).inside && in_sight(system, f)) found.push_back(f);
    };
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const Node& a = nodes[i * (n + 1) + j];
        edge(a, nodes[i * (n + 1) + j + 1]);
        edge(a, nodes[(i + 1) * (n + 1) + j]);
      }
    }
  }
  return found;
}

}  // namespace caustic::test
