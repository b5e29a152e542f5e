// Tracing allocates only where its result grows: no allocation per step.
#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>

#include "solver/trace_contour.h"

namespace {
std::atomic<std::size_t> allocations{0};
}

// All of the program's; sanitizers keep their own, which this still passes on to. Not inlined, or
// GCC sees free() meet operator new.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size > 0 ? size : 1)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace caustic::solver {
namespace {

using namespace geometry;

struct Count {
  std::size_t vertices, allocations;
};

class AllocationTest : public ::testing::Test {
 protected:
  Count trace(const SurfacePtr& shape, double chord_share) {
    const auto system =
        OpticalSystem::build(PointLight{{1.0, 0.5, 3.0}, 1.0}, {{"mirror", shape, {}, {}}},
                             ReceiverFrame::make({0, 0, 4}, {1, 0, 0}, {0, 1, 0}, {6, 6}));
    const ForwardMap map(system, 0, shape->value({0, 0, 2}) > 0.0 ? 1 : -1);
    const Domain domain(map);
    Budget budget(60.0, 1u << 30, nullptr);
    Evaluator evaluate(map, budget);
    const FieldPoint seed = evaluate(map.project({0.15, 0.1, 2.0}));
    const LevelFunction level{seed.inverse_irradiance()};
    TraceOptions options;
    options.chord = chord_share * system.receiver().width();
    options.first_step = 0.05;
    const std::size_t before = allocations;
    const Trace trace = trace_contour(evaluate, domain, level, seed, options);
    return {trace.vertices.size(), allocations - before};
  }
};

TEST_F(AllocationTest, TracingAllocatesOnlyAsItsResultGrows) {
  const SurfacePtr shapes[] = {
      make_sphere(Point::Zero(), 1.0),
      make_ellipsoid(Point::Zero(), {1.0, 1.4, 0.8}, Mat3::Identity()),
      make_torus({0, 0, 0.5}, Vec3::UnitX(), 1.0, 0.4),
      make_conic(Point::Zero(), Vec3::UnitZ(), -2.0, -0.8, {-0.01}),
  };
  for (const SurfacePtr& shape : shapes) {
    const Count coarse = trace(shape, 1e-3);
    for (const double share : {1e-4, 1e-5, 1e-6}) {
      const Count fine = trace(shape, share);
      EXPECT_GT(fine.vertices, coarse.vertices);
      // Two vectors grow by doubling.
      const double growth = std::log2(double(fine.vertices) / double(coarse.vertices));
      EXPECT_LE(double(fine.allocations - coarse.allocations), 2.0 * std::ceil(growth))
          << fine.vertices << " vertices, " << fine.allocations << " allocations; "
          << coarse.vertices << " vertices, " << coarse.allocations << " allocations";
    }
  }
}

}  // namespace
}  // namespace caustic::solver
