#include "tests/support/total_checks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>

#include "solver/certify_paths.h"
#include "solver/itineraries.h"
#include "solver/point_irradiance.h"
#include "tests/support/random.h"
#include "tests/support/thorough.h"

namespace caustic::test {

using namespace solver;

namespace {

int points_wanted(int usual) {
  const char* wanted = std::getenv("ISOCAUSTIC_SAMPLES");
  return wanted ? std::atoi(wanted) : thorough(usual, usual / 20);
}

// What arrives at q over one hop, by interval Newton's proof of all paths.
struct CertifiedSheets {
  std::vector<Point> first_hits;
  double E = 0.0;
  std::size_t undecided = 0;
};
CertifiedSheets certified_sheets(const OpticalSystem& system, const Vec2& q) {
  CertifiedSheets sum;
  const Point p = system.receiver().point(q);
  for (const Family& family : families_up_to(system, 1)) {
    const SystemSurface& surface = system.surfaces()[family[0]];
    const PathFinder judge(system, family, system.light());
    const auto proven = certify_paths(judge.tracer().surfaces(), {surface.region}, system.light(),
                                      p, system.diameter());
    sum.undecided += proven.undecided;
    for (const auto& root : proven.roots) {
      if (!judge.admit(root, p)) continue;
      Vec3 N;
      surface.shape->value_gradient(root[0], N);
      const int side = N.dot(judge.tracer().incident(root[0])) < 0.0 ? 1 : -1;
      sum.E += ForwardMap(system, {{family[0], side}}).evaluate(root[0]).irradiance();
      sum.first_hits.push_back(root[0]);
    }
  }
  return sum;
}

}  // namespace

ContourResult total_of(const OpticalSystem& system, std::vector<double> levels, double chord,
                       bool direct) {
  ContourRequest request;
  request.measure = Measure::total;
  request.levels.values = std::move(levels);
  request.chord_tolerance = chord;
  request.direct = direct;
  request.time_limit = 60.0;
  return trace_contours(system, request);
}

double area_above(const ContourResult& result, double level) {
  double twice = 0.0;
  for (const Curve& c : result.curves) {
    if (c.level != level) continue;
    const std::size_t n = c.vertices.size();
    for (std::size_t i = 0; i < (c.closed ? n : n - 1); ++i) {
      const Vec2 &a = c.vertices[i].uv, &b = c.vertices[(i + 1) % n].uv;
      twice += a.x() * b.y() - a.y() * b.x();
    }
  }
  return 0.5 * twice;
}

void expect_closed_rings(const ContourResult& result, double width) {
  std::map<int, std::map<int, const Curve*>> rings;
  for (const Curve& c : result.curves) {
    if (c.kind == CurveKind::caustic) continue;
    EXPECT_EQ(c.family_id, -1);
    EXPECT_EQ(c.parity, 0);
    EXPECT_TRUE(rings[c.ring_id].emplace(c.ring_order, &c).second);
  }
  for (const auto& [id, arcs] : rings) {
    if (arcs.size() == 1 && arcs.begin()->second->closed) continue;
    for (const auto& [order, arc] : arcs) {
      ASSERT_FALSE(arc->closed);
      EXPECT_EQ(arc->ends, (std::vector{Ending::node, Ending::node}));
      const int next = (order + 1) % static_cast<int>(arcs.size());
      ASSERT_TRUE(arcs.contains(next)) << "ring " << id;
      EXPECT_LT((arcs.at(next)->vertices.front().uv - arc->vertices.back().uv).norm(), 1e-7 * width)
          << "ring " << id << " after arc " << order;
    }
  }
}

void expect_true_of_the_meter(const OpticalSystem& system, const ContourResult& result,
                              bool direct) {
  LightMeter meter(system, {}, direct);
  const double step = 1e-6 * system.receiver().width();
  int arcs = 0, jumps = 0;
  for (const Curve& c : result.curves) {
    if (c.kind == CurveKind::caustic || c.kind == CurveKind::receiver_edge) continue;
    const std::size_t n = c.vertices.size();
    for (std::size_t i = 1; i + 1 < n; i += std::max<std::size_t>(1, n / 7)) {
      const CurveVertex& v = c.vertices[i];
      const Vec2 along = (c.vertices[i + 1].uv - c.vertices[i - 1].uv).normalized();
      const Vec2 left(-along.y(), along.x());
      if (c.kind == CurveKind::isolux) {
        const auto reading = meter.at(v.uv);
        EXPECT_NEAR(reading.E / c.level, 1.0, 1e-8) << v.uv.transpose();
        EXPECT_LT((reading.gradient - v.gradient).norm(), 1e-6 * v.gradient.norm());
        const Vec2 g(system.receiver().u.dot(v.gradient), system.receiver().v.dot(v.gradient));
        EXPECT_GT(g.dot(left), 0.0);
        EXPECT_LT(v.residual, 1e-9);
        ++arcs;
        continue;
      }
      // Next to a corner the step leads to other regions.
      const double from_end =
          std::min((v.uv - c.vertices.front().uv).norm(), (v.uv - c.vertices.back().uv).norm());
      if (from_end < 10.0 * step) continue;
      EXPECT_LT(v.dark, c.level);
      EXPECT_TRUE(v.bright == -1.0 || v.bright >= c.level);
      // Both sides, as far as the totals change over the step.
      const auto dark = meter.at(v.uv - step * left), bright = meter.at(v.uv + step * left);
      const double slack =
          1e-3 * c.level +
          10.0 * step * (dark.gradient.norm() + (v.bright < 0.0 ? 0.0 : bright.gradient.norm()));
      EXPECT_NEAR(dark.E, v.dark, slack) << v.uv.transpose();
      if (v.bright >= 0.0)
        EXPECT_NEAR(bright.E, v.bright, slack) << v.uv.transpose();
      else
        EXPECT_TRUE(bright.on_caustic || bright.E > c.level);
      ++jumps;
    }
  }
  EXPECT_GT(arcs, 4);
  EXPECT_GT(jumps, 4);
}

int expect_all_paths_proven(const OpticalSystem& system, const ContourResult& result,
                            int vertices_of_curve) {
  LightMeter meter(system, {}, false);
  int proven = 0;
  for (const Curve& c : result.curves) {
    if (c.kind != CurveKind::isolux) continue;
    const std::size_t n = c.vertices.size();
    for (int k = 1; k <= vertices_of_curve; ++k) {
      const std::size_t at = k * n / (vertices_of_curve + 1);
      if (at == 0 || at + 1 == n) continue;  // at its ends sheets begin
      const CurveVertex& v = c.vertices[at];
      const auto reading = meter.at(v.uv);
      const CertifiedSheets certified = certified_sheets(system, v.uv);
      EXPECT_EQ(certified.undecided, 0u) << v.uv.transpose();
      EXPECT_EQ(certified.first_hits.size(), reading.sheets.size()) << v.uv.transpose();
      EXPECT_NEAR(certified.E / c.level, 1.0, 1e-8) << v.uv.transpose();
      for (const SheetIrradiance& sheet : reading.sheets) {
        double nearest = geometry::kInfinity;
        for (const Point& x : certified.first_hits)
          nearest = std::min(nearest, (x - sheet.hits[0]).norm());
        EXPECT_LT(nearest, 1e-8 * system.diameter()) << v.uv.transpose();
      }
      proven += static_cast<int>(certified.first_hits.size());
    }
  }
  return proven;
}

void expect_areas(const OpticalSystem& system, const ContourResult& result, double chord,
                  const TotalAt& total, int samples) {
  Random random(77);
  const Vec2 half = system.receiver().half;
  std::map<double, int> inside;
  samples = points_wanted(samples);
  for (int k = 0; k < samples; ++k) {
    const Vec2 q(random.uniform(-half.x(), half.x()), random.uniform(-half.y(), half.y()));
    const double E = total(q);
    for (const double level : result.levels) inside[level] += E >= level;
  }
  const double all = 4.0 * half.x() * half.y();
  for (const double level : result.levels) {
    const double share = inside[level] / double(samples);
    const double noise = std::sqrt(std::max(share * (1.0 - share), 1.0 / samples) / samples);
    double length = 0.0;
    for (const Curve& c : result.curves) length += c.level == level ? c.length : 0.0;
    EXPECT_NEAR(area_above(result, level), share * all, 4.0 * noise * all + length * chord)
        << level;
  }
}

void expect_areas(const OpticalSystem& system, const ContourResult& result, double chord,
                  int samples, bool direct) {
  LightMeter meter(system, {}, direct);
  expect_areas(
      system, result, chord,
      [&](const Vec2& q) {
        const auto reading = meter.at(q);
        return reading.on_caustic ? geometry::kInfinity : reading.E;
      },
      samples);
}

}  // namespace caustic::test
