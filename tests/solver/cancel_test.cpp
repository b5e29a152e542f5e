// A request that is cancelled ends soon, whatever it is at. What "soon" is is counted in work, not
// in time: a mirror counts what it is asked, and withdraws the request in the middle of it.
#include <gtest/gtest.h>

#include <atomic>

#include "solver/contours.h"
#include "tests/support/random.h"
#include "tests/support/scenes.h"
#include "tests/support/thorough.h"

namespace caustic::solver {
namespace {

using geometry::IntervalVec3;
using geometry::Point;
using geometry::Ray;
using geometry::RayParameters;
using geometry::SurfacePtr;
using geometry::Vec3;

/// Another surface, and how often it was asked.
class Counting : public geometry::Surface {
 public:
  explicit Counting(SurfacePtr of) : of_(std::move(of)) {}

  double value(const Point& x) const override { return asked().value(x); }
  double value_gradient(const Point& x, Vec3& gradient) const override {
    return asked().value_gradient(x, gradient);
  }
  geometry::SurfaceDerivatives derivatives(const Point& x) const override {
    return asked().derivatives(x);
  }
  Vec3 third_derivative(const Point& x, const Vec3& u, const Vec3& v) const override {
    return asked().third_derivative(x, u, v);
  }
  geometry::SurfaceEnclosure enclose(const IntervalVec3& x) const override {
    return asked().enclose(x);
  }
  geometry::IntervalSym333 enclose_third(const IntervalVec3& x) const override {
    return asked().enclose_third(x);
  }
  void crossings(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    asked().crossings(ray, t0, t1, out);
  }
  void stationary(const Ray& ray, double t0, double t1, RayParameters& out) const override {
    asked().stationary(ray, t0, t1, out);
  }
  bool flat() const override { return of_->flat(); }
  bool at_most_quadratic() const override { return of_->at_most_quadratic(); }
  bool convex(int side) const override { return of_->convex(side); }
  geometry::Box bounds() const override { return of_->bounds(); }
  std::vector<geometry::Bound> own_bounds() const override { return of_->own_bounds(); }
  std::vector<geometry::Chart> charts(const geometry::Extent& extent) const override {
    return of_->charts(extent);
  }

  /// From now on: raises `flag` at the `n`-th question.
  void raise(std::atomic<bool>& flag, long n) const {
    count_ = 0;
    at_ = n;
    flag_ = &flag;
  }
  long count() const { return count_; }

 private:
  const Surface& asked() const {
    if (++count_ == at_) *flag_ = true;
    return *of_;
  }

  const SurfacePtr of_;
  mutable long count_ = 0, at_ = 0;
  mutable std::atomic<bool>* flag_ = nullptr;
};

// Questions to the mirror after the flag was raised. Each takes some microseconds at most, so that
// this many take less than 0.1 s.
constexpr long kMostAfter = 20'000;

struct CancelledScene {
  const char* name;
  SurfacePtr shape;
  Light light;
  geometry::ReceiverFrame receiver;
};

class Cancelled : public testing::TestWithParam<CancelledScene> {};

TEST_P(Cancelled, EndsSoon) {
  const CancelledScene& scene = GetParam();
  const auto mirror = std::make_shared<const Counting>(scene.shape);
  const OpticalSystem system = test::one_mirror(scene.light, mirror, scene.receiver);
  test::Random random(5);
  for (const Measure measure : {Measure::total, Measure::sheet}) {
    for (const bool certify : {false, true}) {
      ContourRequest request;
      request.measure = measure;
      request.certify = certify;
      request.levels.count = 3;
      request.time_limit = 3600.0;
      for (int k = 0; k < test::thorough(12, 3); ++k) {
        std::atomic<bool> cancelled = false;
        request.cancelled = &cancelled;
        const long at = std::lround(random.log_uniform(10.0, 1e6));
        mirror->raise(cancelled, at);  // anywhere, but as often early as late
        const ContourResult result = trace_contours(system, request);
        if (!cancelled) continue;  // it had ended
        EXPECT_FALSE(result.complete);
        EXPECT_LT(mirror->count() - at, kMostAfter) << at << (certify ? " certified" : "");
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Scenes, Cancelled,
    testing::Values(
        CancelledScene{"Torus", geometry::make_torus({0, 0, 0}, {0, 0, 1}, 1.0, 0.4),
                       PointLight{{0.3, 0.2, 4.0}, 1.0}, test::floor_at({0, 0, -2}, 12, 12)},
        CancelledScene{"Dish", geometry::make_conic({0, 0, 0}, {0, 0, 1}, 2.0, -1.0, {}),
                       PointLight{{0.3, 0.2, 1.5}, 1.0}, test::floor_at({0, 0, 3}, 2, 2)}),
    [](const auto& scene) { return scene.param.name; });

}  // namespace
}  // namespace caustic::solver
