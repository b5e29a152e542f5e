// What freeform shapes cost: derivatives at a point, the crossings of a ray, the loading of a grid.
#include <benchmark/benchmark.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "geometry/sag.h"
#include "service/api/contour_json.h"
#include "service/examples/examples.h"
#include "tests/bench/samples.h"
#include "tests/support/random.h"
#include "tests/support/sampling.h"

namespace caustic::bench {
namespace {

using namespace geometry;

constexpr int kSurfacePoints = 256;

SurfacePtr vase() {
  return make_revolution(Point(0, 0, -1), {0, 0, 1}, 2.0, {0.47, 3.90, -9.78, 5.80}).surface;
}
SurfacePtr polynomial() {
  XyPolynomial f;
  f.add(2, 0, 0.2);
  f.add(0, 2, 0.3);
  f.add(3, 1, 0.05);
  f.add(0, 4, -0.02);
  return make_sag(Point::Zero(), Mat3::Identity(), f);
}
SurfacePtr zernike_of(int last) {
  std::vector<std::pair<int, double>> coefficients{{4, 0.1}};
  for (int j = 5; j <= last; ++j) coefficients.push_back({j, 1e-3});
  return make_sag(Point::Zero(), Mat3::Identity(), zernike(coefficients, 1.5));
}
HeightGrid wavy(int n) {
  HeightGrid grid{{-1, -1}, {1, 1}, n, n, {}};
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) {
      const double x = 2.0 * i / (n - 1) - 1.0, y = 2.0 * j / (n - 1) - 1.0;
      grid.values.push_back(0.3 * (x * x + y * y) +
                            0.002 * std::sin(40.0 * x) * std::cos(31.0 * y));
    }
  }
  return grid;
}
SurfacePtr heights(int n) { return make_sag(Point::Zero(), Mat3::Identity(), wavy(n)); }

void shape(benchmark::State& state, const SurfacePtr& surface) {
  test::Random random(1);
  const auto points =
      test::sample_surface(*surface, test::extent_about(Point::Zero(), 1.2), kSurfacePoints, random);
  std::vector<Ray> rays, misses;
  for (const Point& x : points) {
    rays.push_back({x + 5.0 * Vec3(0.3, 0.2, 1.0), -5.0 * Vec3(0.3, 0.2, 1.0)});
    // A light's way along the surface, a tenth above it.
    misses.push_back({x + 0.1 * Vec3::UnitZ(), random.direction()});
  }
  Samples derivatives, third, crossings, stationary;
  RayParameters found;
  for (auto _ : state) {
    derivatives.time([&] {
      for (const Point& x : points) benchmark::DoNotOptimize(surface->derivatives(x));
    });
    third.time([&] {
      for (const Point& x : points)
        benchmark::DoNotOptimize(surface->third_derivative(x, Vec3::UnitX(), Vec3::UnitY()));
    });
    crossings.time([&] {
      for (const Ray& ray : rays) {
        found.clear();
        surface->crossings(ray, 0.0, 1.0, found);
      }
    });
    stationary.time([&] {
      for (const Ray& ray : misses) {
        found.clear();
        surface->stationary(ray, 0.0, 1.0, found);
      }
    });
  }
  state.counters["derivatives_ns"] = 1e9 * derivatives.min() / kSurfacePoints;
  state.counters["third_ns"] = 1e9 * third.min() / kSurfacePoints;
  state.counters["crossings_ns"] = 1e9 * crossings.min() / kSurfacePoints;
  state.counters["stationary_ns"] = 1e9 * stationary.min() / kSurfacePoints;
}
BENCHMARK_CAPTURE(shape, asphere, make_conic(Point::Zero(), {0, 0, 1}, 2.0, -0.8, {0.01, -0.002}));
BENCHMARK_CAPTURE(shape, vase, vase());
BENCHMARK_CAPTURE(shape, xy_polynomial, polynomial());
BENCHMARK_CAPTURE(shape, zernike_14, zernike_of(14));
BENCHMARK_CAPTURE(shape, zernike_230, zernike_of(230));
BENCHMARK_CAPTURE(shape, heights_32, heights(32));
BENCHMARK_CAPTURE(shape, heights_512, heights(512));

// 512 × 512 samples, from numbers and from the text of a request.
void load_heights(benchmark::State& state) {
  const HeightGrid grid = wavy(512);
  nlohmann::json body = nlohmann::json::parse(service::find_example("freeform-heights")->body);
  nlohmann::json rows = nlohmann::json::array();
  for (int j = 0; j < grid.ny; ++j) {
    rows.push_back(std::vector<double>(grid.values.begin() + j * grid.nx,
                                       grid.values.begin() + (j + 1) * grid.nx));
  }
  body["scene"]["surfaces"][0]["shape"]["values"] = rows;
  const std::string text = body.dump();
  Samples spline, request;
  for (auto _ : state) {
    spline.time([&] { make_sag(Point::Zero(), Mat3::Identity(), grid); });
    request.time([&] { service::read_contour_call(text); });
  }
  state.counters["spline_ms"] = 1e3 * spline.min();
  state.counters["request_ms"] = 1e3 * request.min();
  state.counters["body_MB"] = 1e-6 * static_cast<double>(text.size());
}
BENCHMARK(load_heights)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace caustic::bench
