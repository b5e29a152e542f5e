// The same request gives the same numbers, to the last bit, for any number of threads inside a request,
// with other requests beside it, and whatever ran before.
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <thread>
#include <vector>

#include "geometry/surface.h"
#include "solver/contours.h"

namespace caustic::solver {
namespace {

using namespace geometry;

OpticalSystem torus_and_ball() {
  std::vector<SystemSurface> surfaces{
      {"ring", make_torus({0, 0, 0.4}, {0, 0, 1}, 1.0, 0.35), {}, {}, {}},
      {"ball", make_sphere({0.4, -0.3, 1.5}, 0.2), {}, {}, {}}};
  return OpticalSystem::build(PointLight{{1.5, 0.5, 3.0}, 1.0}, std::move(surfaces),
                              ReceiverFrame::make({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {8, 8}));
}

// Thirty small blockers, so that Embree takes part.
OpticalSystem many_blockers() {
  std::vector<SystemSurface> surfaces{{"ball", make_sphere({0, 0, 0}, 1.0), {}, {}, {}}};
  for (int i = 0; i < 30; ++i) {
    const double angle = 2.4 * i, r = 0.3 * std::sqrt(double(i));
    surfaces.push_back({"b" + std::to_string(i),
                        make_sphere({r * std::cos(angle), r * std::sin(angle), 2.5}, 0.1),
                        {},
                        {Optics::Kind::absorb, 1.0},
                        {}});
  }
  return OpticalSystem::build(PointLight{{0.3, 0.2, 4}, 1.0}, std::move(surfaces),
                              ReceiverFrame::make({0, 0, 5}, {1, 0, 0}, {0, 1, 0}, {8, 8}));
}

std::vector<std::uint64_t> bits(const ContourResult& result) {
  std::vector<std::uint64_t> all;
  const auto add = [&](double v) { all.push_back(std::bit_cast<std::uint64_t>(v)); };
  for (const Curve& c : result.curves) {
    all.push_back(static_cast<std::uint64_t>(c.kind));
    all.push_back(static_cast<std::uint64_t>(c.family_id));
    add(c.level);
    add(c.length);
    add(c.max_residual);
    for (const Ending e : c.ends) all.push_back(static_cast<std::uint64_t>(e));
    for (const CurveVertex& v : c.vertices) {
      for (int i = 0; i < 3; ++i) {
        add(v.p[i]);
        add(v.x[i]);
        add(v.gradient[i]);
      }
      add(v.irradiance);
      add(v.arc_length);
    }
  }
  for (const FamilyReport& family : result.families) add(family.flux);
  all.push_back(result.evaluations);
  return all;
}

ContourResult trace(const OpticalSystem& system, int threads) {
  ContourRequest request;
  request.time_limit = 300.0;  // sanitizers are slow, and a cut result may differ
  request.threads = threads;
  return trace_contours(system, request);
}

TEST(Determinism, any_number_of_threads) {
  for (const OpticalSystem& system : {torus_and_ball(), many_blockers()}) {
    const auto alone = trace(system, 1);
    ASSERT_GT(alone.curves.size(), 5u);
    for (const int threads : {2, 4}) EXPECT_EQ(bits(trace(system, threads)), bits(alone)) << threads;
  }
}

TEST(Determinism, whatever_runs_beside_or_before) {
  const OpticalSystem a = torus_and_ball(), b = many_blockers();
  const auto bits_a = bits(trace(a, 1)), bits_b = bits(trace(b, 1));
  std::vector<std::vector<std::uint64_t>> found(4);
  std::vector<std::thread> threads;
  for (int i = 0; i < 4; ++i) {
    threads.emplace_back([&, i] { found[i] = bits(trace(i % 2 == 0 ? a : b, 1)); });
  }
  for (std::thread& thread : threads) thread.join();
  for (int i = 0; i < 4; ++i) EXPECT_EQ(found[i], i % 2 == 0 ? bits_a : bits_b) << i;
}

}  // namespace
}  // namespace caustic::solver
