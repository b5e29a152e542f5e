#include "solver/itineraries.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>

#include "geometry/embree_scene.h"
#include "solver/seek.h"
#include "solver/subdivision.h"
#include "solver/visibility.h"

namespace caustic::solver {

namespace {

// Rays from each surface.
constexpr int kRays = 4096;
constexpr int kLeastSide = 6;  // of a chart, in rays
// Where an aperture leaves fewer of them the surface is divided, at most so often and into so many.
constexpr int kLeastRays = 400;
constexpr int kApertureLevels = 30;
constexpr std::size_t kMostPatches = 40000;
// Where a light is near, patches are divided so often at most; more at once are near it only about
// a singular point of a chart.
constexpr int kNearLevels = 40;
constexpr std::size_t kNearAtOnce = 1000;
// Where none of these gets through, cells of the charts, so many a side at first, are divided for
// what is small: at most so often, so many in all, and so often where rays miss different
// surfaces.
constexpr int kSeekCells = 12;
constexpr int kSeekLevels = 40;
constexpr std::size_t kSeekPatches = 20000;
constexpr int kMixedLevels = 3;
// What is further outside of an aperture than this share of the scene does not exist.
constexpr double kExistsShare = 1e-12;

double outside_by(const SystemSurface& surface, const Point& x) {
  double worst = -geometry::kInfinity;
  for (const auto& bound : surface.bounds) worst = std::max(worst, bound.value(x));
  return worst;
}

/// A square of a chart.
struct Patch {
  const geometry::Chart* chart;
  double s, t, half;

  Point at(int i, int j) const { return chart->point(s + i * half, t + j * half); }
  Point middle() const { return at(0, 0); }
  double radius() const {
    const Point x = middle();
    double radius = 0.0;
    for (const int i : {-1, 1}) {
      for (const int j : {-1, 1}) radius = std::max(radius, (at(i, j) - x).norm());
    }
    return radius;
  }
  void divide(std::vector<Patch>& into) const {
    for (const int i : {-1, 1}) {
      for (const int j : {-1, 1})
        into.push_back({chart, s + 0.5 * i * half, t + 0.5 * j * half, 0.5 * half});
    }
  }
};

/// A surface in patches.
class Cover {
 public:
  Cover(const OpticalSystem& system, int surface, const OutOfTime& out_of_time)
      : system_(system),
        surface_(system.surfaces()[surface]),
        out_of_time_(out_of_time),
        charts_(surface_.shape->charts({surface_.region, system.center(), system.diameter()})) {}

  /// So many a side of each chart.
  std::vector<Patch> grid(int side) const {
    std::vector<Patch> patches;
    for (const auto& chart : charts_) {
      for (int k = 0; k < side * side; ++k)
        patches.push_back({&chart, (k % side + 0.5) / side, (k / side + 0.5) / side, 0.5 / side});
    }
    return patches;
  }
  /// One for each ray.
  std::vector<Patch> for_rays() const {
    const auto count = static_cast<double>(std::max<std::size_t>(charts_.size(), 1));
    return grid(std::max(kLeastSide, static_cast<int>(std::sqrt(kRays / count))));
  }
  /// Divides patches until what is not outside of the aperture has its share of them, if it can.
  /// False if it has.
  bool divide_at_aperture(std::vector<Patch>& patches) const;
  /// Divides patches that are large against their distance from a point light.
  void divide_near_light(std::vector<Patch>& patches) const;

  bool out_of_time() const { return out_of_time_ && out_of_time_(); }
  bool on_chart(const Patch& p) const {
    const Point x = p.middle();
    return x.allFinite() && geometry::exists_at(p.chart->cell, x);
  }
  bool exists(const Patch& p) const {
    return on_chart(p) && outside_by(surface_, p.middle()) <= kExistsShare * system_.diameter();
  }

 private:
  bool outside(const Patch& p) const {
    const double radius = kRadiusFactor * p.radius();
    return std::isfinite(radius) &&
           std::any_of(surface_.bounds.begin(), surface_.bounds.end(), [&](const auto& bound) {
             return bound.lower_bound_within(p.middle(), radius) > 0.0;
           });
  }

  const OpticalSystem& system_;
  const SystemSurface& surface_;
  const OutOfTime& out_of_time_;
  std::vector<geometry::Chart> charts_;
};

bool Cover::divide_at_aperture(std::vector<Patch>& patches) const {
  const auto exists_too = [&](const Patch& p) { return exists(p); };
  for (int level = 0; level < kApertureLevels && !out_of_time(); ++level) {
    if (std::count_if(patches.begin(), patches.end(), exists_too) >= kLeastRays) return level > 0;
    std::vector<Patch> finer;
    for (const Patch& p : patches) {
      if (!outside(p)) p.divide(finer);
    }
    if (finer.size() > kMostPatches) return level > 0;
    patches.swap(finer);
  }
  return true;
}

void Cover::divide_near_light(std::vector<Patch>& patches) const {
  const auto* light = std::get_if<PointLight>(&system_.light());
  const double far = surface_.region.diagonal();
  if (!light || !surface_.region.may_meet({light->position, Vec3::Zero()}, far)) return;
  std::vector<Patch> near;
  const auto keep_near = [&](const std::vector<Patch>& all) {
    near.clear();
    for (const Patch& p : all) {
      if (out_of_time()) return;
      if (near_light(system_.light(), p.middle(), p.radius())) near.push_back(p);
    }
  };
  keep_near(patches);
  for (int level = 0; level < kNearLevels && !near.empty() && near.size() <= kNearAtOnce; ++level) {
    std::vector<Patch> finer;
    for (const Patch& p : near) p.divide(finer);
    patches.insert(patches.end(), finer.begin(), finer.end());
    keep_near(finer);
  }
}

/// Aims rays at what lies between those that pass by, until one is `through`. `follow` follows the
/// ray from a point, and says what it misses.
template <class Follow, class Through>
void seek(const OpticalSystem& system, const std::vector<int>& surfaces, const Cover& cover,
          const Follow& follow, const Through& through) {
  const auto region_of = [&](int hop) { return system.surfaces()[surfaces[hop]].region; };
  std::vector<Patch> patches = cover.grid(kSeekCells);
  std::size_t seen = 0;
  for (int level = 0; level < kSeekLevels; ++level) {
    seen += patches.size();
    if (through() || seen > kSeekPatches) return;
    std::vector<Patch> finer;
    for (const Patch& p : patches) {
      if (cover.out_of_time()) return;
      if (near_light(system.light(), p.middle(), p.radius())) {
        p.divide(finer);
        continue;
      }
      const std::array rays{follow(p.at(-1, -1)), follow(p.at(1, -1)), follow(p.at(1, 1)),
                            follow(p.at(-1, 1)), follow(p.middle())};
      const auto farthest = std::max_element(
          rays.begin(), rays.end(), [](const auto& a, const auto& b) { return a.hop < b.hop; });
      if (farthest->hop < 0) continue;
      const Between found = between(rays, rays[4], region_of(farthest->hop));
      if (found == Between::perhaps || (found == Between::mixed && level < kMixedLevels))
        p.divide(finer);
    }
    patches.swap(finer);
  }
}

Vec3 incident(const Light& light, const Point& x) {
  if (const auto* point = std::get_if<PointLight>(&light)) return x - point->position;
  return std::get<CollimatedLight>(light).direction;
}

// Follows one ray along a family, both ways where it is open which part of a surface it meets.
class SideFinder {
 public:
  SideFinder(const OpticalSystem& system, const std::vector<int>& surfaces,
             std::set<std::vector<int>>& out)
      : system_(system), surfaces_(surfaces), slack_(kExistsShare * system.diameter()), out_(out) {}

  /// The ray that meets the first surface at x from `side`; what it misses, if it does. Nothing if
  /// light comes from the other side there.
  NearMiss start(const Point& x, int side) {
    const SystemSurface& surface = system_.surfaces()[surfaces_[0]];
    const Vec3 d = incident(system_.light(), x);
    Vec3 N;
    surface.shape->value_gradient(x, N);
    miss_ = {};
    if (side * N.dot(d) < 0.0) go(x, d, 0, side, outside_by(surface, x) <= slack_);
    return miss_;
  }
  /// Some ray has met nothing but what exists.
  bool through() const { return through_; }

 private:
  // `exists`: all that it has met, x too.
  void go(const Point& x, const Vec3& direction, std::size_t hop, int side, bool exists) {
    const SystemSurface& surface = system_.surfaces()[surfaces_[hop]];
    Vec3 N;
    surface.shape->value_gradient(x, N);
    const auto on = bend(surface.optics, side, direction, N);
    if (!on) return;
    sides_.push_back(side);
    if (hop + 1 == surfaces_.size()) {
      out_.insert(sides_);
      through_ |= exists;
    } else {
      meet({x, *on}, hop + 1, exists);
    }
    sides_.pop_back();
  }

  void meet(const geometry::Ray& ray, std::size_t hop, bool all_exist) {
    const SystemSurface& surface = system_.surfaces()[surfaces_[hop]];
    const bool returns = surfaces_[hop] == surfaces_[hop - 1];
    const double least = returns ? least_return(ray, system_.diameter()) : 0.0;
    std::optional<double> tau[2];
    bool exists[2] = {};
    for (int k = 0; k < 2; ++k) {
      tau[k] = next_hit(surface, 1 - 2 * k, ray, least, nullptr);
      exists[k] = tau[k] && outside_by(surface, ray.at(*tau[k])) <= slack_;
    }
    const bool open = !exists[0] && !exists[1];
    if (open && miss_.hop < 0) miss_ = {static_cast<int>(hop), ray.origin, ray.direction};
    for (int k = 0; k < 2; ++k) {
      if (!tau[k] || (!open && !exists[k])) continue;
      // Behind what exists nothing of the same surface is reached.
      if (exists[1 - k] && *tau[1 - k] < *tau[k]) continue;
      go(ray.at(*tau[k]), ray.direction, hop, 1 - 2 * k, all_exist && exists[k]);
    }
  }

  const OpticalSystem& system_;
  const std::vector<int>& surfaces_;
  double slack_;
  bool through_ = false;
  std::vector<int> sides_;
  NearMiss miss_;
  std::set<std::vector<int>>& out_;
};

// Follows rays wherever they go.
class Wanderer {
 public:
  Wanderer(const OpticalSystem& system, int max_bounces, Arrival arrival)
      : system_(system),
        max_bounces_(max_bounces),
        arrival_(arrival),
        slack_(kExistsShare * system.diameter()) {
    if (system.surfaces().size() >= static_cast<std::size_t>(kEmbreeSurfaces)) {
      std::vector<geometry::Box> boxes;
      for (const auto& surface : system.surfaces()) boxes.push_back(surface.region);
      embree_ = std::make_unique<geometry::EmbreeScene>(boxes, 0.0);
    }
  }

  void start(int surface, const Point& x) {
    const SystemSurface& s = system_.surfaces()[surface];
    Vec3 N;
    const Vec3 d = incident(system_.light(), x);
    s.shape->value_gradient(x, N);
    const int side = N.dot(d) < 0.0 ? 1 : -1;
    // Anything on the way from the light?
    const bool point = std::holds_alternative<PointLight>(system_.light());
    const geometry::Ray back{x, point ? Vec3(-d) : Vec3(-system_.reach(x) * d)};
    const auto blocker = first_hit(back, surface);
    if (blocker && blocker->tau < 1.0 - 1e-9) return;
    surfaces_.clear();
    go(surface, x, d, side);
  }

  std::set<std::vector<int>> found;

 private:
  struct Meeting {
    double tau;
    int surface, side;
  };

  // The first surface that exists on the ray, which begins on the surface `own`.
  std::optional<Meeting> first_hit(const geometry::Ray& ray, int own) {
    std::optional<Meeting> first;
    const double least = least_return(ray, system_.diameter());
    const auto ask = [&](int i) {
      const SystemSurface& surface = system_.surfaces()[i];
      for (const int side : {1, -1}) {
        const auto tau = next_hit(surface, side, ray, i == own ? least : 0.0, nullptr);
        if (!tau || (first && *tau >= first->tau)) continue;
        if (outside_by(surface, ray.at(*tau)) <= slack_) first = {*tau, i, side};
      }
    };
    if (embree_) {
      candidates_.clear();
      embree_->candidates(ray, system_.reach(ray.origin) / ray.direction.norm(), candidates_);
      for (const int i : candidates_) ask(i);
    } else {
      for (int i = 0; i < static_cast<int>(system_.surfaces().size()); ++i) ask(i);
    }
    return first;
  }

  void go(int surface, const Point& x, const Vec3& d, int side) {
    const SystemSurface& s = system_.surfaces()[surface];
    if (!s.optics.passes_light_on()) return;
    Vec3 N;
    s.shape->value_gradient(x, N);
    const auto on = bend(s.optics, side, d, N);
    if (!on) return;
    surfaces_.push_back(surface);
    const geometry::Ray ray{x, *on};
    const auto next = first_hit(ray, surface);
    if (arrives(ray, next)) found.insert(surfaces_);
    if (next && static_cast<int>(surfaces_.size()) < max_bounces_) {
      go(next->surface, ray.at(next->tau), ray.direction, next->side);
    }
  }

  bool arrives(const geometry::Ray& ray, const std::optional<Meeting>& next) const {
    if (arrival_ == Arrival::anywhere) return true;
    const auto& receiver = system_.receiver();
    const double lambda =
        receiver.m.dot(receiver.origin - ray.origin) / receiver.m.dot(ray.direction);
    if (!(lambda > 0.0) || (next && next->tau < lambda)) return false;
    const Vec3 p = ray.at(lambda) - receiver.origin;
    return std::abs(p.dot(receiver.u)) <= receiver.half.x() &&
           std::abs(p.dot(receiver.v)) <= receiver.half.y();
  }

  const OpticalSystem& system_;
  int max_bounces_;
  Arrival arrival_;
  double slack_;
  std::unique_ptr<geometry::EmbreeScene> embree_;
  std::vector<int> candidates_, surfaces_;
};

}  // namespace

std::vector<Hops> sides_of(const OpticalSystem& system, const std::vector<int>& surfaces, int side,
                           const OutOfTime& out_of_time) {
  std::set<std::vector<int>> found;
  SideFinder finder(system, surfaces, found);
  const Cover cover(system, surfaces[0], out_of_time);
  const auto follow = [&](const Point& x) { return finder.start(x, side); };
  const auto follow_all = [&](std::vector<Patch> patches) {
    cover.divide_near_light(patches);
    for (const Patch& p : patches) {
      if (cover.out_of_time()) return;
      if (cover.on_chart(p)) follow(p.middle());
    }
  };
  follow_all(cover.for_rays());
  if (auto patches = cover.for_rays(); !finder.through() && cover.divide_at_aperture(patches))
    follow_all(std::move(patches));
  if (!finder.through()) seek(system, surfaces, cover, follow, [&] { return finder.through(); });
  std::vector<Hops> out;
  for (const std::vector<int>& sides : found) {
    Hops hops;
    for (std::size_t j = 0; j < sides.size(); ++j) hops.push_back({surfaces[j], sides[j]});
    out.push_back(hops);
  }
  return out;
}

std::vector<std::vector<int>> families_that_occur(const OpticalSystem& system, int max_bounces,
                                                  Arrival arrival, const OutOfTime& out_of_time) {
  Wanderer wanderer(system, max_bounces, arrival);
  for (int i = 0; i < static_cast<int>(system.surfaces().size()); ++i) {
    if (!system.surfaces()[i].optics.passes_light_on()) continue;
    const Cover cover(system, i, out_of_time);
    auto patches = cover.for_rays();
    cover.divide_at_aperture(patches);
    cover.divide_near_light(patches);
    for (const Patch& p : patches) {
      if (cover.out_of_time()) break;
      if (cover.exists(p)) wanderer.start(i, p.middle());
    }
  }
  std::vector<std::vector<int>> out(wanderer.found.begin(), wanderer.found.end());
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return out;
}

std::vector<std::vector<int>> families_up_to(const OpticalSystem& system, int max_bounces,
                                             Arrival arrival, const OutOfTime& out_of_time) {
  std::vector<std::vector<int>> families;
  for (int i = 0; i < static_cast<int>(system.surfaces().size()); ++i) {
    if (system.surfaces()[i].optics.passes_light_on()) families.push_back({i});
  }
  if (max_bounces <= 1) return families;
  for (auto& family : families_that_occur(system, max_bounces, arrival, out_of_time)) {
    if (family.size() > 1) families.push_back(std::move(family));
  }
  return families;
}

}  // namespace caustic::solver
