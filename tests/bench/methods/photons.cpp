// 5: a photon map. Light is sent out evenly, where it arrives is kept, and the irradiance at a
// point is that of its k nearest photons over the disc that they fill (Schjøth, ch. 2); then
// marching squares.
#include <algorithm>
#include <cmath>
#include <optional>

#include "solver/find_paths.h"
#include "solver/forward_map.h"
#include "tests/bench/methods/marching_squares.h"

namespace caustic::bench {

using geometry::Point;
using geometry::Vec2;
using geometry::Vec3;

namespace {

// Photons a little beyond the window are kept, so that discs at its edge are full.
constexpr double kMargin = 1.25;
// Bias grows as k/n and noise falls as 1/√k: both fall fastest together for k ~ n^(2/3).
double neighbours(double photons) { return std::max(8.0, 0.1 * std::pow(photons, 2.0 / 3.0)); }
// Points of the irradiance along a side: no finer than discs are wide.
constexpr int kLeastSide = 64, kMostSide = 512;
int side(double photons, double k) {
  return std::clamp(static_cast<int>(4.0 * std::sqrt(photons / k)), kLeastSide, kMostSide);
}

// Rays that may meet a box, all alike likely, and the light that each stands for.
class Emitter {
 public:
  Emitter(const solver::Light& light, const geometry::Box& target) {
    middle_ = target.center();
    const double radius = 0.5 * target.diagonal();
    if (const auto* lamp = std::get_if<solver::PointLight>(&light)) {
      origin_ = lamp->position;
      axis_ = (middle_ - origin_).normalized();
      const double far = (middle_ - origin_).norm();
      least_cosine_ = far > radius ? std::sqrt(1.0 - radius * radius / (far * far)) : -1.0;
      light_ = lamp->intensity * 2.0 * geometry::kPi * (1.0 - least_cosine_);
    } else {
      const auto& beam = std::get<solver::CollimatedLight>(light);
      axis_ = beam.direction;
      radius_ = radius;
      light_ = beam.irradiance * geometry::kPi * radius * radius;
    }
  }
  double light() const { return light_; }

  // Number i of a sequence that fills the square more evenly than chance: additive, by the powers
  // of the plastic number. By chance errors are five times these and more.
  geometry::Ray operator()(double i) const {
    const geometry::Frame frame(axis_);
    const double turn = 2.0 * geometry::kPi * std::fmod(0.7548776662466927 * i, 1.0),
                 share = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
    const Vec3 across = std::cos(turn) * frame.e1 + std::sin(turn) * frame.e2;
    if (radius_ > 0.0)
      return {middle_ - 2.0 * radius_ * axis_ + radius_ * std::sqrt(share) * across, axis_};
    const double c = 1.0 - share * (1.0 - least_cosine_);
    return {origin_, c * axis_ + std::sqrt(1.0 - c * c) * across};
  }

 private:
  Point middle_, origin_ = Point::Zero();
  Vec3 axis_;
  double least_cosine_ = -1.0, radius_ = 0.0, light_ = 0.0;
};

// Arrivals in the squares of a grid, and the distance of the k-th nearest.
class PhotonMap {
 public:
  PhotonMap(const std::vector<Vec2>& photons, const Vec2& half, double k) : half_(half) {
    const double area = 4.0 * half.x() * half.y();
    // A square holds about a quarter of k.
    size_ = std::sqrt(
        area * std::clamp(0.25 * k / (1.0 + static_cast<double>(photons.size())), 1e-7, 1.0));
    nx_ = static_cast<int>(2.0 * half.x() / size_) + 1;
    ny_ = static_cast<int>(2.0 * half.y() / size_) + 1;
    begin_.assign(static_cast<std::size_t>(nx_) * ny_ + 1, 0);
    for (const Vec2& q : photons) ++begin_[square(q) + 1];
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    photons_.resize(photons.size());
    std::vector<std::size_t> next(begin_.begin(), begin_.end() - 1);
    for (const Vec2& q : photons) photons_[next[square(q)]++] = q;
  }

  /// Squared; infinite if there are fewer.
  double kth_nearest(const Vec2& q, std::size_t k) {
    const auto [i, j] = place(q);
    const Vec2 in = q + half_ - size_ * Vec2(i, j);
    const double inner = std::min({in.x(), in.y(), size_ - in.x(), size_ - in.y()});
    found_.clear();
    for (int ring = 0; ring <= std::max(nx_, ny_); ++ring) {
      for (int y = std::max(j - ring, 0); y <= std::min(j + ring, ny_ - 1); ++y) {
        const int step = std::abs(y - j) == ring ? 1 : std::max(2 * ring, 1);
        for (int x = i - ring; x <= i + ring; x += step)
          if (x >= 0 && x < nx_) gather(static_cast<std::size_t>(y) * nx_ + x, q);
      }
      if (found_.size() < k) continue;
      std::nth_element(found_.begin(), found_.begin() + (k - 1), found_.end());
      const double reach = inner + ring * size_;  // all within it are found
      if (found_[k - 1] <= reach * reach) return found_[k - 1];
    }
    return found_.size() < k ? geometry::kInfinity : found_[k - 1];
  }

 private:
  std::pair<int, int> place(const Vec2& q) const {
    return {std::clamp(static_cast<int>((q.x() + half_.x()) / size_), 0, nx_ - 1),
            std::clamp(static_cast<int>((q.y() + half_.y()) / size_), 0, ny_ - 1)};
  }
  std::size_t square(const Vec2& q) const {
    const auto [i, j] = place(q);
    return static_cast<std::size_t>(j) * nx_ + i;
  }
  void gather(std::size_t square, const Vec2& q) {
    for (std::size_t i = begin_[square]; i < begin_[square + 1]; ++i)
      found_.push_back((photons_[i] - q).squaredNorm());
  }

  Vec2 half_;
  double size_;
  int nx_, ny_;
  std::vector<std::size_t> begin_;
  std::vector<Vec2> photons_;
  std::vector<double> found_;
};

// Where the light of a ray arrives by one hop on the scene's only surface.
class Flight {
 public:
  explicit Flight(const Scene& scene)
      : reach_(2.0 * scene.system.diameter()),
        system_(scene.system),
        surface_(system_.surfaces()[0]),
        maps_{{system_, 0, 1}, {system_, 0, -1}} {}

  std::optional<Vec2> operator()(const geometry::Ray& ray) {
    crossings_.clear();
    surface_.shape->crossings(ray, 0.0, reach_, crossings_);
    for (const double t : crossings_) {
      const Point x = ray.at(t);
      if (!geometry::exists_at(surface_.bounds, x)) continue;
      Vec3 N;
      surface_.shape->value_gradient(x, N);
      const int side = N.dot(ray.direction) < 0.0 ? 1 : -1;
      const auto& map = maps_[side > 0 ? 0 : 1];
      Vec3 onward;
      if (!map.follow(x, hits_, onward)) return std::nullopt;
      const auto& receiver = system_.receiver();
      const double lambda = receiver.m.dot(receiver.origin - x) / receiver.m.dot(onward);
      if (!(lambda > 0.0)) return std::nullopt;
      const Vec3 p = x + lambda * onward - receiver.origin;
      const Vec2 q(receiver.u.dot(p), receiver.v.dot(p));
      if (!surface_.shape->convex(side) &&
          solver::segment_hidden(system_, x, 0, receiver.point(q), -1))
        return std::nullopt;
      return q;
    }
    return std::nullopt;
  }

 private:
  double reach_;  // of a ray, m
  const solver::OpticalSystem& system_;
  const solver::SystemSurface& surface_;
  solver::ForwardMap maps_[2];
  geometry::RayParameters crossings_;
  std::vector<Point> hits_;
};

Drawing draw_photons(const Scene& scene, double photons) {
  const Emitter emit(scene.system.light(), scene.system.surfaces()[0].region);
  Flight fly(scene);
  const Vec2 half = kMargin * scene.system.receiver().half;
  std::vector<Vec2> arrived;
  const auto count = static_cast<std::uint64_t>(photons);
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto q = fly(emit(static_cast<double>(i)));
    if (q && (q->cwiseAbs().array() <= half.array()).all()) arrived.push_back(*q);
  }
  const auto k = static_cast<std::size_t>(neighbours(static_cast<double>(arrived.size())));
  const int n = side(static_cast<double>(arrived.size()), static_cast<double>(k));
  const double each = emit.light() / photons;
  PhotonMap map(arrived, half, static_cast<double>(k));
  return {marching_squares(scene, n, n,
                           [&](const Vec2& q) {
                             // The k-th lies on the edge of the disc, which holds k − 1.
                             return (static_cast<double>(k) - 1.0) * each /
                                    (geometry::kPi * map.kth_nearest(q, k));
                           }),
          static_cast<std::uint64_t>(photons), "k = " + std::to_string(k)};
}

}  // namespace

std::vector<Method> photon_methods() {
  return {{"photons", solver::Measure::total, {1e4, 1e5, 1e6, 1e7}, draw_photons}};
}

}  // namespace caustic::bench
