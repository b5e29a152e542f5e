#include "solver/itineraries.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <set>

#include "geometry/embree_scene.h"
#include "solver/seek.h"
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
// The corners underestimate a patch's radius on curved charts.
constexpr double kPatchRadius = 1.3;
// Where none of these gets through, cells of the charts, so many a side at first, are divided for
// what is small: at most so often, so many at once, and so often where rays miss different
// surfaces.
constexpr int kSeekCells = 12;
constexpr int kSeekLevels = 40;
constexpr std::size_t kSeekAtOnce = 20000;
constexpr int kMixedLevels = 3;
// What is further outside of an aperture than this share of the scene does not exist.
constexpr double kExistsShare = 1e-12;

double outside_by(const SystemSurface& surface, const Point& x) {
  double worst = -geometry::kInfinity;
  for (const auto& bound : surface.bounds) worst = std::max(worst, bound.value(x));
  return worst;
}

/// Calls back with points spread over the surface, whether they exist or not.
template <class Action>
void for_each_point(const OpticalSystem& system, const SystemSurface& surface, const Action& act) {
  const auto charts = surface.shape->charts({surface.region, system.center(), system.diameter()});
  const double each =
      std::sqrt(kRays / static_cast<double>(std::max<std::size_t>(charts.size(), 1)));
  const int n = std::max(kLeastSide, static_cast<int>(each));
  for (const auto& chart : charts) {
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const Point x = chart.point((i + 0.5) / n, (j + 0.5) / n);
        if (x.allFinite() && geometry::exists_at(chart.cell, x)) act(x);
      }
    }
  }
}

/// Calls back with points spread over the part of the surface that exists, however small an
/// aperture leaves it: where few are found, what is not outside of the aperture is divided.
template <class Action>
void for_each_existing_point(const OpticalSystem& system, const SystemSurface& surface,
                             const Action& act) {
  struct Patch {
    const geometry::Chart* chart;
    double s, t, half;
  };
  const auto charts = surface.shape->charts({surface.region, system.center(), system.diameter()});
  const auto middle = [](const Patch& p) { return p.chart->point(p.s, p.t); };
  const auto outside = [&](const Patch& p) {
    const Point x = middle(p);
    double radius = 0.0;
    for (const double i : {-p.half, p.half}) {
      for (const double j : {-p.half, p.half})
        radius = std::max(radius, (p.chart->point(p.s + i, p.t + j) - x).norm());
    }
    return std::isfinite(radius) &&
           std::any_of(surface.bounds.begin(), surface.bounds.end(), [&](const auto& bound) {
             return bound.lower_bound_within(x, kPatchRadius * radius) > 0.0;
           });
  };
  const double slack = kExistsShare * system.diameter();
  const auto exists = [&](const Patch& p) {
    const Point x = middle(p);
    return x.allFinite() && geometry::exists_at(p.chart->cell, x) &&
           outside_by(surface, x) <= slack;
  };
  const double each =
      std::sqrt(kRays / static_cast<double>(std::max<std::size_t>(charts.size(), 1)));
  const int n = std::max(kLeastSide, static_cast<int>(each));
  std::vector<Patch> patches;
  for (const auto& chart : charts) {
    for (int k = 0; k < n * n; ++k)
      patches.push_back({&chart, (k % n + 0.5) / n, (k / n + 0.5) / n, 0.5 / n});
  }
  for (int level = 0; level < kApertureLevels; ++level) {
    if (std::count_if(patches.begin(), patches.end(), exists) >= kLeastRays) break;
    std::vector<Patch> finer;
    for (const Patch& p : patches) {
      if (outside(p)) continue;
      const double half = 0.5 * p.half;
      for (const double i : {-half, half}) {
        for (const double j : {-half, half}) finer.push_back({p.chart, p.s + i, p.t + j, half});
      }
    }
    if (finer.size() > kMostPatches) break;
    patches.swap(finer);
  }
  for (const Patch& p : patches) {
    if (exists(p)) act(middle(p));
  }
}

/// Aims rays at what lies between those that pass by, until one is `through`. `follow` follows the
/// ray from a point, and says what it misses.
template <class Follow, class Through>
void seek(const OpticalSystem& system, const std::vector<int>& surfaces, const Follow& follow,
          const Through& through) {
  const SystemSurface& surface = system.surfaces()[surfaces[0]];
  const auto region_of = [&](int hop) { return system.surfaces()[surfaces[hop]].region; };
  struct Patch {
    int chart;
    double s, t, half;
  };
  const auto charts = surface.shape->charts({surface.region, system.center(), system.diameter()});
  std::vector<Patch> parts;
  constexpr double kHalf = 0.5 / kSeekCells;
  for (int chart = 0; chart < static_cast<int>(charts.size()); ++chart) {
    for (int k = 0; k < kSeekCells * kSeekCells; ++k) {
      parts.push_back(
          {chart, (2 * (k % kSeekCells) + 1) * kHalf, (2 * (k / kSeekCells) + 1) * kHalf, kHalf});
    }
  }
  for (int level = 0; level < kSeekLevels && parts.size() <= kSeekAtOnce; ++level) {
    if (through()) return;
    std::vector<Patch> finer;
    for (const Patch& part : parts) {
      const auto at = [&](int i, int j) {
        return follow(charts[part.chart].point(part.s + i * part.half, part.t + j * part.half));
      };
      const std::array rays{at(-1, -1), at(1, -1), at(1, 1), at(-1, 1), at(0, 0)};
      const auto farthest = std::max_element(
          rays.begin(), rays.end(), [](const auto& a, const auto& b) { return a.hop < b.hop; });
      if (farthest->hop < 0) continue;
      const Between found = between(rays, rays[4], region_of(farthest->hop));
      const bool divide =
          found == Between::perhaps || (found == Between::mixed && level < kMixedLevels);
      if (!divide) continue;
      const double half = 0.5 * part.half;
      for (const double i : {-half, half}) {
        for (const double j : {-half, half}) {
          finer.push_back({part.chart, part.s + i, part.t + j, half});
        }
      }
    }
    parts.swap(finer);
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
    const Vec3 d = incident(system_.light(), x);
    Vec3 N;
    system_.surfaces()[surfaces_[0]].shape->value_gradient(x, N);
    miss_ = {};
    if (side * N.dot(d) < 0.0) go(x, d, 0, side);
    return miss_;
  }

 private:
  void go(const Point& x, const Vec3& direction, std::size_t hop, int side) {
    const SystemSurface& surface = system_.surfaces()[surfaces_[hop]];
    Vec3 N;
    surface.shape->value_gradient(x, N);
    const auto on = bend(surface.optics, side, direction, N);
    if (!on) return;
    sides_.push_back(side);
    if (hop + 1 == surfaces_.size()) {
      out_.insert(sides_);
    } else {
      meet({x, *on}, hop + 1);
    }
    sides_.pop_back();
  }

  void meet(const geometry::Ray& ray, std::size_t hop) {
    const SystemSurface& surface = system_.surfaces()[surfaces_[hop]];
    const bool returns = surfaces_[hop] == surfaces_[hop - 1];
    const double least = returns ? least_return(ray, system_.diameter()) : 0.0;
    std::optional<double> tau[2];
    bool exists[2] = {};
    for (int k = 0; k < 2; ++k) {
      tau[k] = next_hit(surface, 1 - 2 * k, ray, least, nullptr);
      exists[k] = tau[k] && outside_by(surface, ray.at(*tau[k])) <= slack_;
    }
    if (!tau[0] && !tau[1]) miss_ = {static_cast<int>(hop), ray.origin, ray.direction};
    const bool open = !exists[0] && !exists[1];
    for (int k = 0; k < 2; ++k) {
      if (!tau[k] || (!open && !exists[k])) continue;
      // Behind what exists nothing of the same surface is reached.
      if (exists[1 - k] && *tau[1 - k] < *tau[k]) continue;
      go(ray.at(*tau[k]), ray.direction, hop, 1 - 2 * k);
    }
  }

  const OpticalSystem& system_;
  const std::vector<int>& surfaces_;
  double slack_;
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
  const auto follow = [&](const Point& x) {
    return out_of_time && out_of_time() ? NearMiss{} : finder.start(x, side);
  };
  for_each_point(system, system.surfaces()[surfaces[0]], follow);
  if (found.empty()) seek(system, surfaces, follow, [&] { return !found.empty(); });
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
    const SystemSurface& surface = system.surfaces()[i];
    if (!surface.optics.passes_light_on()) continue;
    for_each_existing_point(system, surface, [&](const Point& x) {
      if (!out_of_time || !out_of_time()) wanderer.start(i, x);
    });
  }
  std::vector<std::vector<int>> out(wanderer.found.begin(), wanderer.found.end());
  std::stable_sort(out.begin(), out.end(),
                   [](const auto& a, const auto& b) { return a.size() < b.size(); });
  return out;
}

std::vector<std::vector<int>> families_up_to(const OpticalSystem& system, int max_bounces,
                                             Arrival arrival, const OutOfTime& out_of_time) {
  if (max_bounces > 1) return families_that_occur(system, max_bounces, arrival, out_of_time);
  std::vector<std::vector<int>> families;
  for (int i = 0; i < static_cast<int>(system.surfaces().size()); ++i) {
    if (system.surfaces()[i].optics.passes_light_on()) families.push_back({i});
  }
  return families;
}

}  // namespace caustic::solver
