#include "solver/find_paths.h"

#include <algorithm>
#include <cmath>

namespace caustic::solver {

namespace {

// Rays are followed this many diameters of the scene: past the ball in which surfaces exist.
constexpr double kReach = 2e3;
// A crossing within this share of a segment's length from an end on that surface is the end itself,
// and so many roundings of its place more.
constexpr double kEndShare = 1e-7;
constexpr double kEndRoundings = 1e3;
// Light nearer to a surface than this share of the scene is taken to lie on it.
constexpr double kEndOnSurface = 1e-9;
// Apertures are closed sets, and points on them are known to rounding.
constexpr double kApertureSlack = 1e-12;

PencilTracer make_tracer(const OpticalSystem& system, const Family& family, const Light& light) {
  std::vector<PathSurface> surfaces;
  for (const int index : family) surfaces.push_back(path_surface(system.surfaces()[index]));
  return {std::move(surfaces), light, kReach * system.diameter()};
}

geometry::Extent extent_of(const OpticalSystem& system, int surface) {
  return {system.surfaces()[surface].region, system.center(), system.diameter()};
}

// A segment that leaves a convex body on its outside never meets it again.
bool leaves_convex(const geometry::Surface& shape, const Point& x, const Vec3& direction) {
  Vec3 N;
  shape.value_gradient(x, N);
  const double along = N.dot(direction);
  return along != 0.0 && shape.convex(along > 0.0 ? 1 : -1);
}

// The side from which light must come to a surface without holes, or 0 if it may be either.
int lit_side(const SystemSurface& surface, const Light& light, double scale) {
  const auto* point = std::get_if<PointLight>(&light);
  if (!point || !surface.shape->own_bounds().empty()) return 0;
  for (const auto& bound : surface.bounds) {
    if (bound.origin == geometry::Bound::Origin::aperture) return 0;
  }
  Vec3 N;
  const double g = surface.shape->value_gradient(point->position, N);
  if (std::abs(g) <= kEndOnSurface * scale * N.norm()) return 0;
  return g > 0.0 ? 1 : -1;
}

}  // namespace

void sort_paths(std::vector<FamilyPath>& paths) {
  std::sort(paths.begin(), paths.end(), [](const FamilyPath& a, const FamilyPath& b) {
    const Point &x = a.path.x.front(), &y = b.path.x.front();
    return std::lexicographical_compare(x.data(), x.data() + 3, y.data(), y.data() + 3);
  });
}

bool segment_hidden(const OpticalSystem& system, const Point& a, int from, const Point& b, int to) {
  const geometry::Ray ray{a, b - a};
  const double near =
      kEndShare + kEndRoundings * geometry::kEpsilon *
                      (a.cwiseAbs().maxCoeff() + b.cwiseAbs().maxCoeff() + system.diameter()) /
                      ray.direction.norm();
  thread_local geometry::RayParameters roots;
  for (int i = 0; i < static_cast<int>(system.surfaces().size()); ++i) {
    const auto& surface = system.surfaces()[i];
    if (!surface.region.may_meet(ray, 1e-9 * system.diameter())) continue;
    if ((i == from && leaves_convex(*surface.shape, a, ray.direction)) ||
        (i == to && i != from && leaves_convex(*surface.shape, b, -ray.direction))) {
      continue;
    }
    roots.clear();
    surface.shape->crossings(ray, i == from ? -near : 0.0, i == to ? 1.0 + near : 1.0, roots);
    const auto drop_nearest = [&](double end) {
      const auto first = std::min_element(roots.begin(), roots.end(), [&](double s, double t) {
        return std::abs(s - end) < std::abs(t - end);
      });
      if (first != roots.end() && std::abs(*first - end) <= near) roots.erase(first);
    };
    // At the end that lies on the surface one crossing is no obstacle; a free end touches only.
    if (i == from) drop_nearest(0.0);
    if (i == to) drop_nearest(1.0);
    for (const double t : roots) {
      if (t <= near * (from < 0) || t >= 1.0 - near * (to < 0)) continue;
      if (geometry::exists_at(surface.bounds, ray.at(t))) return true;
    }
  }
  return false;
}

PathFinder::PathFinder(const OpticalSystem& system, Family family, const Light& light)
    : system_(system),
      family_(std::move(family)),
      search_(make_tracer(system, family_, light), extent_of(system, family_.front()),
              lit_side(system.surfaces()[family_.front()], light, system.diameter())) {}

Point PathFinder::source_of(const Point& x) const {
  if (const auto* point = std::get_if<PointLight>(&tracer().light())) return point->position;
  // Far enough to have passed every surface.
  double reach = 0.0;
  for (const auto& s : system_.surfaces()) {
    reach = std::max(reach, (s.region.center() - x).norm() + s.region.diagonal());
  }
  return x - reach * std::get<CollimatedLight>(tracer().light()).direction;
}

bool PathFinder::exists(const std::vector<Point>& hits) const {
  for (std::size_t i = 0; i < hits.size(); ++i) {
    const auto& bounds = system_.surfaces()[family_[i]].bounds;
    if (!geometry::exists_at(bounds, hits[i], kApertureSlack * system_.diameter())) return false;
  }
  return true;
}

bool PathFinder::visible(const Point& from, const std::vector<Point>& hits, const Point& p) const {
  Point last = from;
  int on = -1;
  for (std::size_t i = 0; i <= hits.size(); ++i) {
    const bool end = i == hits.size();
    const Point& next = end ? p : hits[i];
    const int surface = end ? -1 : family_[i];
    if (segment_hidden(system_, last, on, next, surface)) return false;
    last = next;
    on = surface;
  }
  return true;
}

std::optional<FamilyPath> PathFinder::admit(const std::vector<Point>& hits, const Point& p) const {
  const Point from = source_of(hits.front());
  if (!exists(hits) || !visible(from, hits, p)) return std::nullopt;
  return FamilyPath{tracer().chain(hits), {from, p, hits, {}}};
}

PathFinder::Answer PathFinder::to(const Point& p) {
  const auto found = search_.through(p);
  const auto hits_of = [&](const Pencil& pencil) {
    return std::vector<Point>(pencil.hits.begin(), pencil.hits.begin() + family_.size());
  };
  Answer answer;
  for (const Pencil& pencil : found.pencils) {
    if (auto path = admit(hits_of(pencil), p)) answer.paths.push_back(*std::move(path));
  }
  sort_paths(answer.paths);
  Pencil pencil;
  for (const Point& x : found.undecided) {
    if (!tracer().trace_ray(x, pencil)) continue;
    const auto hits = hits_of(pencil);
    answer.undecided += exists(hits) && visible(source_of(x), hits, p);
  }
  return answer;
}

}  // namespace caustic::solver
