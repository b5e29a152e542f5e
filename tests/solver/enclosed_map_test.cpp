// Enclosures of the level function over cells: they hold what the closed form gives at any point,
// and shrink as they should.
#include "solver/enclosed_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include "solver/domain.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"
#include "tests/support/thorough.h"

namespace caustic::solver {
namespace {

using namespace geometry;
using test::Random;

constexpr int kCells = test::thorough(400, 20);

struct Scene {
  std::string name;
  OpticalSystem system;
  int side;
};

OpticalSystem under(Light light, SurfacePtr shape, bool refracts, std::vector<Bound> bounds = {},
                    const std::function<void(Optics&)>& change = {}) {
  SystemSurface surface = test::mirror(std::move(shape), std::move(bounds), 0.8);
  if (refracts) {
    surface.optics.kind = Optics::Kind::refract;
    surface.optics.index_inside = 1.4;
  }
  if (change) change(surface.optics);
  return OpticalSystem::build(
      std::move(light), {std::move(surface)},
      ReceiverFrame::make({0.2, -0.1, -2.5}, {1, 0.2, 0.1}, {-0.3, 1, 0.2}, {5, 4}));
}

std::vector<Scene> scenes() {
  const PointLight lamp{{0.3, 0.4, 2.5}, 2.0};
  const CollimatedLight beam{Vec3(0.2, -0.3, -1.0).normalized(), 3.0};
  const Mat3 turned = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const auto egg = make_ellipsoid({0, 0.1, 0}, {1.0, 1.3, 0.8}, turned);
  const auto ball = make_sphere({0.1, 0, 0}, 1.1);
  const auto tube = make_cylinder({0, 0, 0}, Vec3(0.3, 1, 0.2).normalized(), 0.9);
  const std::vector<Bound> cut{cylinder_aperture({0, 0, 0}, Vec3(0.1, 0, 1).normalized(), 0.7),
                               half_space_aperture({0, 0, 0.1}, Vec3(0.2, 0.1, -1).normalized())};
  std::vector<Scene> all;
  for (const int side : {1, -1}) {
    all.push_back({"ball", under(lamp, ball, false, cut), side});
    all.push_back({"egg", under(beam, egg, false), side});
    all.push_back({"tube", under(lamp, tube, false, box_aperture({-1, -1, -1}, {1, 1, 1})), side});
    all.push_back({"plane",
                   under(lamp, make_plane({0, 0, 0}, Vec3(0.1, 0.2, 1).normalized()), false,
                         box_aperture({-1, -1, -1}, {1, 1, 1})),
                   side});
    all.push_back({"glass egg", under(beam, egg, true), side});
    all.push_back({"glass ball", under(lamp, ball, true), side});
    all.push_back({"Fresnel's glass",
                   under(lamp, ball, true, {}, [](Optics& o) { o.fresnel = true; }), side});
    all.push_back({"aluminium",
                   under(beam, egg, false, {},
                         [](Optics& o) {
                           o.metal = {1.1, 6.8};
                         }),
                   side});
    all.push_back({"tar",
                   under(lamp, egg, false, {},
                         [](Optics& o) {
                           o.metal = {1.6, 0.05};
                         }),
                   side});
  }
  return all;
}

// A, Σ and their slopes at a point of the graph, from the closed form and the chain rule.
struct Exact {
  double a, a_s, a_t, flux, flux_s, flux_t;
};
Exact exact(const ForwardMap& map, const GraphChart& chart, const FieldPoint& f) {
  const auto d = map.shape().derivatives(f.x);
  const auto i = chart.first(), j = chart.second(), k = chart.along();
  const double size = d.gradient.norm(), up = d.gradient[k], J = size / std::abs(up);
  Exact e{f.a * J, 0, 0, f.flux * J, 0, 0};
  const auto slopes = [&](std::size_t first, double& a, double& flux) {
    Vec3 along = Vec3::Zero();
    along[first] = 1.0;
    along[k] = -d.gradient[first] / up;
    const Vec3 turn = d.hessian * along;
    const double J_slope = d.gradient.dot(turn) / (size * std::abs(up)) -
                           size * std::copysign(1.0, up) * turn[k] / (up * up);
    a = f.grad_a.dot(along) * J + f.a * J_slope;
    flux = f.grad_flux.dot(along) * J + f.flux * J_slope;
  };
  slopes(i, e.a_s, e.flux_s);
  slopes(j, e.a_t, e.flux_t);
  return e;
}

Point on_graph(const Surface& shape, const GraphChart& chart, const GraphCell& cell, double s,
               double t) {
  Point x;
  x[chart.first()] = s;
  x[chart.second()] = t;
  x[chart.along()] = cell.z.middle();
  Vec3 gradient;
  for (int i = 0; i < 50; ++i) {
    const double g = shape.value_gradient(x, gradient);
    x[chart.along()] -= g / gradient[chart.along()];
  }
  return x;
}

// A random cell of a random chart over which there is a graph.
struct DrawnCell {
  const GraphChart* chart;
  GraphCell cell;
};
bool draw(const EnclosedMap& map, const GraphCover& cover, Random& random, double size,
          DrawnCell& out) {
  out.chart = &cover.charts[random.index(static_cast<int>(cover.charts.size()))];
  const Interval& s = out.chart->own[out.chart->first()];
  const Interval& t = out.chart->own[out.chart->second()];
  const double at_s = random.uniform(s.lo, s.hi), at_t = random.uniform(t.lo, t.hi);
  out.cell = {Interval(at_s, at_s + size * s.width()), Interval(at_t, at_t + size * t.width()),
              out.chart->reach, false};
  return map.narrow(*out.chart, out.cell) && out.cell.whole;
}

bool holds(const Interval& range, double value, double scale) {
  const double slack = 1e-11 * (std::abs(value) + scale);
  return Interval(range.lo - slack, range.hi + slack).contains(value);
}

TEST(EnclosedMap, HoldsWhatItEncloses) {
  int seen = 0, enclosed = 0;
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(scene.name);
    Random random(7301);
    const ForwardMap map(scene.system, 0, scene.side);
    const Domain domain(map);
    ASSERT_TRUE(EnclosedMap::encloses(map));
    const EnclosedMap enclosures(map);
    const auto cover = cover_by_graphs(map.shape(), map.mirror().bounds, map.mirror().region);
    EXPECT_TRUE(cover.undecided.empty());
    EnclosedField f;
    for (int n = 0; n < kCells; ++n) {
      DrawnCell drawn;
      if (!draw(enclosures, cover, random, random.log_uniform(1e-7, 1.0), drawn)) continue;
      const auto& [chart, cell] = drawn;
      enclosures.enclose(*chart, cell, f);
      for (int m = 0; m < 5; ++m) {
        const double s = random.uniform(cell.s.lo, cell.s.hi);
        const double t = random.uniform(cell.t.lo, cell.t.hi);
        const Point x = on_graph(map.shape(), *chart, cell, s, t);
        EXPECT_TRUE(holds(cell.z, x[chart->axis], 1.0));
        const FieldPoint at = map.evaluate(x);
        if (!at.finite) continue;
        ++seen;
        if (f.dark) {
          EXPECT_FALSE(at.arrives() && at.lit() && map.receiver().contains(at.q));
          continue;
        }
        // Not outside of a boundary that the point is inside of.
        const bool excluded = std::any_of(f.bounds.begin(), f.bounds.end(),
                                          [](const Slopes& h) { return h.v.lo > 1e-11; });
        const bool in_box = chart->own[chart->along()].contains(x[chart->axis]);
        EXPECT_FALSE(excluded && in_box && domain.contains(at));
        if (!f.regular) continue;
        ++enclosed;
        const Exact e = exact(map, *chart, at);
        const double scale = at.scale_of_a() * map.system().diameter();
        EXPECT_TRUE(holds(f.a.v, e.a, scale)) << f.a.v.lo << " " << e.a << " " << f.a.v.hi;
        EXPECT_TRUE(holds(f.a.s, e.a_s, scale)) << f.a.s.lo << " " << e.a_s << " " << f.a.s.hi;
        EXPECT_TRUE(holds(f.a.t, e.a_t, scale)) << f.a.t.lo << " " << e.a_t << " " << f.a.t.hi;
        EXPECT_TRUE(holds(f.flux.v, e.flux, 1.0));
        EXPECT_TRUE(holds(f.flux.s, e.flux_s, 1.0));
        EXPECT_TRUE(holds(f.flux.t, e.flux_t, 1.0));
        const double k = random.sign() * random.log_uniform(0.01, 100.0);
        const Slopes F = f.level(k);
        EXPECT_TRUE(holds(F.v, e.a - k * e.flux, scale + std::abs(k)));
        EXPECT_TRUE(holds(F.s, e.a_s - k * e.flux_s, scale + std::abs(k)));
        EXPECT_TRUE(holds(F.t, e.a_t - k * e.flux_t, scale + std::abs(k)));
      }
    }
  }
  EXPECT_GT(seen, 10 * kCells);
  EXPECT_GT(enclosed, 5 * kCells);
}

// Each boundary of the domain is positive where its enclosure is, with the slopes of differences.
TEST(EnclosedMap, EnclosesSlopesOfBoundaries) {
  for (const Scene& scene : scenes()) {
    Random random(7302);
    const ForwardMap map(scene.system, 0, scene.side);
    const EnclosedMap enclosures(map);
    const auto cover = cover_by_graphs(map.shape(), map.mirror().bounds, map.mirror().region);
    EnclosedField f, at, to_s, to_t;
    for (int n = 0; n < kCells / 4; ++n) {
      DrawnCell drawn;
      if (!draw(enclosures, cover, random, 1e-3, drawn)) continue;
      const auto& [chart, cell] = drawn;
      enclosures.enclose(*chart, cell, f);
      if (f.dark || !f.regular) continue;
      const auto value_at = [&](double s, double t, EnclosedField& out) {
        GraphCell point{s, t, cell.z, true};
        enclosures.narrow(*chart, point);
        enclosures.enclose(*chart, point, out);
        return !out.dark;
      };
      if (!value_at(cell.s.lo, cell.t.lo, at) || !value_at(cell.s.hi, cell.t.lo, to_s) ||
          !value_at(cell.s.lo, cell.t.hi, to_t)) {
        continue;
      }
      for (std::size_t b = 0; b < f.bounds.size(); ++b) {
        const auto difference = [&](const EnclosedField& to, double step) {
          return (to.bounds[b].v - at.bounds[b].v) / Interval(step);
        };
        EXPECT_FALSE(intersection(difference(to_s, cell.s.width()), f.bounds[b].s).empty()) << b;
        EXPECT_FALSE(intersection(difference(to_t, cell.t.width()), f.bounds[b].t).empty()) << b;
      }
    }
  }
}

// Halving a cell leaves half of the excess of the slopes and a quarter of that of the values (S72).
TEST(EnclosedMap, ConvergesAtItsOrder) {
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(scene.name);
    Random random(7303);
    const ForwardMap map(scene.system, 0, scene.side);
    const EnclosedMap enclosures(map);
    const auto cover = cover_by_graphs(map.shape(), map.mirror().bounds, map.mirror().region);
    EnclosedField f;
    int measured = 0;
    // Until some have been measured, where the sanitizers leave few cells.
    for (int n = 0; n < kCells / 4 || (measured == 0 && n < 1000); ++n) {
      DrawnCell drawn;
      if (!draw(enclosures, cover, random, 1e-4, drawn)) continue;
      const auto& [chart, cell] = drawn;
      // Widths beyond what a linear function with these slopes has.
      double excess[3], slope[3];
      bool all = true;
      for (int level = 0; level < 3 && all; ++level) {
        const double share = std::ldexp(1.0, -level);
        GraphCell part = cell;
        part.s.hi = part.s.lo + share * cell.s.width();
        part.t.hi = part.t.lo + share * cell.t.width();
        all = enclosures.narrow(*chart, part) && part.whole;
        enclosures.enclose(*chart, part, f);
        all = all && !f.dark && f.regular;
        const double spread = f.a.s.middle() * part.s.width(),
                     rest = f.a.t.middle() * part.t.width();
        excess[level] = f.a.v.width() - std::abs(spread) - std::abs(rest);
        slope[level] = f.a.s.width();
      }
      if (!all) continue;
      ++measured;
      EXPECT_LT(slope[2], 0.7 * slope[1] + 1e-12);
      EXPECT_LT(excess[2], 0.35 * excess[1] + 1e-12);
    }
    EXPECT_GT(measured, 0);
  }
}

}  // namespace
}  // namespace caustic::solver
