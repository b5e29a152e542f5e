// What a compiled expression costs against the surface written by hand, with all derivatives that
// tracing asks for at a point: g, ∇g, Hessian, and the third derivative along three pairs. Both are
// timed in turns; "ratio" is that of the minima. Jets run through the same expression are the
// alternative that was not taken.
#include <benchmark/benchmark.h>

#include "geometry/expression/field.h"
#include "geometry/surface.h"
#include "tests/bench/samples.h"
#include "tests/bench/taylor_jet.h"
#include "tests/support/random.h"

namespace caustic::bench {
namespace {

using namespace geometry;

constexpr int kPoints = 256;

SurfacePtr expression(const char* text) {
  return make_expression(read_expression(text, 1.0), Box::around(Point::Zero(), 1.6), {}).surface;
}

// As solver/forward_map does.
double everything(const Surface& surface, const Point& x, const Vec3& u, const Vec3& v) {
  const auto d = surface.derivatives(x);
  const auto third = surface.third_derivatives(x, u, v);
  return d.g + d.gradient.sum() + d.hessian.sum() + (third.uu + third.uv + third.vv).sum();
}

void against_hand(benchmark::State& state, const SurfacePtr& by_hand, const SurfacePtr& compiled) {
  test::Random random(1);
  std::vector<Point> points;
  for (int i = 0; i < kPoints; ++i) points.push_back(random.in_cube(1.2));
  const Direction u = random.direction(), v = random.direction();
  Samples hand, program;
  const auto time = [&](Samples& samples, const Surface& surface) {
    samples.time([&] {
      for (const Point& x : points) benchmark::DoNotOptimize(everything(surface, x, u, v));
    });
  };
  for (auto _ : state) {
    time(hand, *by_hand);
    time(program, *compiled);
  }
  state.counters["hand_ns"] = 1e9 * hand.min() / kPoints;
  state.counters["expression_ns"] = 1e9 * program.min() / kPoints;
  state.counters["ratio"] = program.min() / hand.min();
}

BENCHMARK_CAPTURE(against_hand, sphere, make_sphere(Point::Zero(), 1.0),
                  expression("x^2+y^2+z^2-1"));
BENCHMARK_CAPTURE(against_hand, torus, make_torus(Point::Zero(), {0, 0, 1}, 1.0, 0.5),
                  expression("(x^2+y^2+z^2+0.75)^2-4*(x^2+y^2)"));
BENCHMARK_CAPTURE(against_hand, asphere,
                  make_conic(Point::Zero(), {0, 0, 1}, 2.0, -1.0, {0.01, -0.002}),
                  expression("z-(x^2+y^2)/4-0.01*(x^2+y^2)^2+0.002*(x^2+y^2)^3"));

// The same numbers from third-order jets; "ratio" is what those cost in compiled derivatives.
void against_jets(benchmark::State& state, const char* text) {
  const Expression read = read_expression(text, 1.0);
  const Field field(read, 1.0);
  JetInterpreter jets(read);
  test::Random random(1);
  std::vector<Point> points;
  for (int i = 0; i < kPoints; ++i) points.push_back(random.in_cube(1.2));
  const Direction u = random.direction(), v = random.direction();
  const auto compiled = [&](const Point& x) {
    JetDerivatives r;
    r.d.g = field.derivatives(x, r.d.gradient, r.d.hessian);
    const auto third = field.third_derivatives(x, u, v);
    r.third = {third[0], third[1], third[2]};
    return r;
  };
  const auto by_jets = [&](const Point& x) { return derivatives_of(jets.run(x), u, v); };
  for (const Point& x : points) {
    const JetDerivatives a = compiled(x), b = by_jets(x);
    const double error = (a.d.hessian - b.d.hessian).norm() + (a.third.uu - b.third.uu).norm() +
                         (a.third.uv - b.third.uv).norm() + (a.third.vv - b.third.vv).norm();
    if (!(error <= 1e-10 * (1.0 + a.d.hessian.norm() + b.third.uu.norm()))) {
      return state.SkipWithError("jets and compiled derivatives differ");
    }
  }
  Samples program, jet;
  const auto time = [&](Samples& samples, const auto& action) {
    samples.time([&] {
      for (const Point& x : points) benchmark::DoNotOptimize(action(x));
    });
  };
  for (auto _ : state) {
    time(program, compiled);
    time(jet, by_jets);
  }
  state.counters["expression_ns"] = 1e9 * program.min() / kPoints;
  state.counters["jets_ns"] = 1e9 * jet.min() / kPoints;
  state.counters["ratio"] = jet.min() / program.min();
}

BENCHMARK_CAPTURE(against_jets, sphere, "x^2+y^2+z^2-1");
BENCHMARK_CAPTURE(against_jets, torus, "(x^2+y^2+z^2+0.75)^2-4*(x^2+y^2)");
BENCHMARK_CAPTURE(against_jets, cuboid, "x^4+y^4+z^4-x^2-y^2-z^2");
BENCHMARK_CAPTURE(against_jets, asphere, "z-(x^2+y^2)/4-0.01*(x^2+y^2)^2+0.002*(x^2+y^2)^3");
BENCHMARK_CAPTURE(against_jets, torus_by_roots, "(sqrt(x^2+y^2)-1)^2+z^2-0.25");
BENCHMARK_CAPTURE(against_jets, water, "z-0.1*sin(2*pi*x)");

void crossings(benchmark::State& state, const SurfacePtr& surface) {
  test::Random random(2);
  std::vector<Ray> rays;
  for (int i = 0; i < kPoints; ++i) {
    const Point from = 3.0 * random.direction();
    rays.push_back({from, random.in_cube(1.0) - from});
  }
  RayParameters found;
  for (auto _ : state) {
    for (const Ray& ray : rays) {
      found.clear();
      surface->crossings(ray, 0.0, 2.0, found);
      benchmark::DoNotOptimize(found.data());
    }
  }
  state.counters["ray_us"] = benchmark::Counter(
      1e-6 * kPoints, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
}

BENCHMARK_CAPTURE(crossings, torus_by_hand, make_torus(Point::Zero(), {0, 0, 1}, 1.0, 0.5));
BENCHMARK_CAPTURE(crossings, torus, expression("(x^2+y^2+z^2+0.75)^2-4*(x^2+y^2)"));
BENCHMARK_CAPTURE(crossings, torus_by_roots, expression("(sqrt(x^2+y^2)-1)^2+z^2-0.25"));
BENCHMARK_CAPTURE(crossings, cuboid, expression("x^4+y^4+z^4-x^2-y^2-z^2"));
BENCHMARK_CAPTURE(crossings, water, expression("z-0.1*sin(2*pi*x)"));

}  // namespace
}  // namespace caustic::bench
