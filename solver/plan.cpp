#include "solver/plan.h"

#include <algorithm>
#include <cmath>

#include "solver/itineraries.h"
#include "solver/visibility.h"

namespace caustic::solver {

namespace {

using geometry::Box;
using geometry::Point;

// Light nearer to a surface than this share of the scene is taken to lie on it.
constexpr double kOnSurfaceShare = 1e-9;

Box hull(const Box& a, const Box& b) { return {a.min.cwiseMin(b.min), a.max.cwiseMax(b.max)}; }

Box window_of(const geometry::ReceiverFrame& r) {
  const geometry::Vec3 reach = r.half.x() * r.u.cwiseAbs() + r.half.y() * r.v.cwiseAbs();
  return {r.origin - reach, r.origin + reach};
}

bool has_aperture(const SystemSurface& surface) {
  return std::any_of(surface.bounds.begin(), surface.bounds.end(), [](const auto& bound) {
    return bound.origin == geometry::Bound::Origin::aperture;
  });
}

bool whole(const SystemSurface& surface) {
  return !has_aperture(surface) && surface.shape->own_bounds().empty();
}

// Boxes on the faces of a surface's own box that are looked at before the proof below is given up.
constexpr int kFaceBoxes = 2000;

bool finite(const geometry::SurfaceEnclosure& e) {
  const auto bounded = [](const geometry::Interval& i) {
    return std::isfinite(i.lo) && std::isfinite(i.hi);
  };
  return bounded(e.g) && std::all_of(e.gradient.begin(), e.gradient.end(), bounded) &&
         std::all_of(e.hessian.begin(), e.hessian.end(), bounded);
}

// The sign of g all over the faces of the box that a surface is given in, if intervals prove that
// there is one and that g is smooth inside; else 0. Then the box cuts nothing off, and the surface
// separates its inside from its outside.
int sign_around(const SystemSurface& surface) {
  const auto own = surface.shape->own_bounds();
  const bool boxed = std::all_of(own.begin(), own.end(), [](const geometry::Bound& bound) {
    return bound.kind == geometry::Bound::Kind::half_space &&
           bound.axis.cwiseAbs().maxCoeff() == 1.0;
  });
  const Box box = surface.shape->bounds();
  if (own.empty() || !boxed || !box.bounded() || has_aperture(surface)) return 0;
  if (!finite(surface.shape->enclose(geometry::intervals(box)))) return 0;
  std::vector<Box> faces;
  for (int axis = 0; axis < 3; ++axis) {
    Box low = box, high = box;
    low.max[axis] = box.min[axis];
    high.min[axis] = box.max[axis];
    faces.insert(faces.end(), {low, high});
  }
  const int sign = surface.shape->value(box.min) > 0.0 ? 1 : -1;
  for (int seen = 0; !faces.empty(); ++seen) {
    const Box face = faces.back();
    faces.pop_back();
    // Directly, and by the mean value form about the middle.
    const auto over = surface.shape->enclose(geometry::intervals(face));
    const double middle = sign * surface.shape->value(face.center());
    double reach = 0.0;
    for (int i = 0; i < 3; ++i) {
      reach += 0.5 * (face.max[i] - face.min[i]) * over.gradient[i].magnitude();
    }
    if ((sign > 0 ? over.g.lo > 0.0 : over.g.hi < 0.0) || middle > (1.0 + 1e-9) * reach) continue;
    if (seen > kFaceBoxes || !(middle > 0.0)) return 0;
    int widest = 0;
    (face.max - face.min).maxCoeff(&widest);
    Box left = face, right = face;
    left.max[widest] = right.min[widest] = face.center()[widest];
    faces.insert(faces.end(), {left, right});
  }
  return sign;
}

// The side from which light must come, or 0 if it may be either. A surface without holes separates
// its inside from its outside, so light arrives on the side where its source is; a lamp inside a
// convex surface lights its inside, holes or not.
int lit_side(const OpticalSystem& system, const SystemSurface& surface) {
  geometry::Vec3 gradient;
  if (const int around = sign_around(surface)) {
    const auto* point = std::get_if<PointLight>(&system.light());
    if (!point || !surface.shape->bounds().contains(point->position)) return around;
    const double g = surface.shape->value_gradient(point->position, gradient);
    if (std::abs(g) <= kOnSurfaceShare * system.diameter() * gradient.norm()) return 0;
    return g > 0.0 ? 1 : -1;
  }
  if (const auto* point = std::get_if<PointLight>(&system.light())) {
    const double g = surface.shape->value_gradient(point->position, gradient);
    if (std::abs(g) <= kOnSurfaceShare * system.diameter() * gradient.norm()) return 0;
    const int side = g > 0.0 ? 1 : -1;
    return surface.shape->convex(-side) || whole(surface) ? side : 0;
  }
  if (!whole(surface)) return 0;
  const Box box = surface.shape->bounds();
  if (!box.bounded()) return 0;
  // A beam comes from infinity, outside of every closed shape; which sign g has there is the
  // user's.
  return surface.shape->value(box.center() + geometry::Vec3::Constant(box.diagonal())) > 0.0 ? 1
                                                                                             : -1;
}

// Of surfaces apart from those of the family: does one reach into the room of one of its segments?
bool others_in_the_way(const OpticalSystem& system, const Hops& hops) {
  const auto* point = std::get_if<PointLight>(&system.light());
  std::vector<Box> stations;
  if (point) stations.push_back({point->position, point->position});
  for (const Hop& hop : hops) stations.push_back(system.surfaces()[hop.surface].region);
  stations.push_back(window_of(system.receiver()));
  for (int i = 0; i < static_cast<int>(system.surfaces().size()); ++i) {
    const bool own = std::any_of(hops.begin(), hops.end(), [&](Hop h) { return h.surface == i; });
    if (own) continue;
    if (!point) return true;
    for (std::size_t k = 1; k < stations.size(); ++k) {
      const Box room = hull(stations[k - 1], stations[k]);
      if (!system.surfaces()[i].region.intersected(room).empty()) return true;
    }
  }
  return false;
}

// Light reflected off a convex surface, and light through it, in and out.
bool leaves_convex_surface(const OpticalSystem& system, const Hops& hops) {
  if (hops.empty()) return true;
  const SystemSurface& surface = system.surfaces()[hops[0].surface];
  if (hops.size() == 1 && surface.optics.kind == Optics::Kind::mirror) {
    return surface.shape->convex(hops[0].side);
  }
  return hops.size() == 2 && hops[0].surface == hops[1].surface && hops[0].side == 1 &&
         surface.optics.kind == Optics::Kind::refract && surface.shape->convex(1);
}

bool may_be_hidden(const OpticalSystem& system, const Hops& hops) {
  return !leaves_convex_surface(system, hops) || others_in_the_way(system, hops);
}

// Light in the receiver's plane does not light it.
bool lights_receiver(const OpticalSystem& system) {
  const auto& receiver = system.receiver();
  if (const auto* point = std::get_if<PointLight>(&system.light())) {
    const double height = receiver.m.dot(point->position - receiver.origin);
    return std::abs(height) > kOnSurfaceShare * system.diameter();
  }
  const auto& beam = std::get<CollimatedLight>(system.light());
  return std::abs(receiver.m.dot(beam.direction)) > kOnSurfaceShare;
}

std::vector<Hops> pieces_of(const OpticalSystem& system, const std::vector<int>& family, int side,
                            const OutOfTime& out_of_time) {
  if (family.size() == 1) return {{{family[0], side}}};
  return sides_of(system, family, side, out_of_time);
}

}  // namespace

std::span<const char* const> skippable_stages() {
  static constexpr const char* kStages[] = {"dark_side", "third_derivatives", "visibility",
                                            "embree",    "unseen_cells",      "hidden_family",
                                            "family"};
  return kStages;
}

Plan make_plan(const OpticalSystem& system, const std::vector<std::vector<int>>& families,
               bool direct, const std::set<std::string>& no_skip, const OutOfTime& out_of_time) {
  Plan plan;
  const Needless needless{no_skip.count("third_derivatives") > 0, no_skip.count("unseen_cells") > 0,
                          no_skip.count("hidden_family") > 0};
  int dark_sides = 0, unhidden = 0;
  for (int family = 0; family < static_cast<int>(families.size()); ++family) {
    const int mirror = families[family].front();
    const int lit = lit_side(system, system.surfaces()[mirror]);
    for (const int side : {1, -1}) {
      if (lit == -side && !no_skip.count("dark_side")) {
        ++dark_sides;
        continue;
      }
      for (const Hops& hops : pieces_of(system, families[family], side, out_of_time)) {
        const bool needed = may_be_hidden(system, hops);
        unhidden += !needed;
        plan.pieces.push_back({family, hops, needed || no_skip.count("visibility") > 0, needless});
      }
    }
  }
  if (dark_sides > 0) {
    plan.skipped.push_back({"dark_side", std::to_string(dark_sides) +
                                             (dark_sides == 1 ? " side" : " sides") +
                                             " of surfaces that no light can reach"});
  }
  if (direct && lights_receiver(system)) {
    const bool needed = may_be_hidden(system, {}) || no_skip.count("visibility") > 0;
    plan.direct = PlannedPiece{kDirectFamily, {}, needed, needless};
  }
  bool quadrics = !plan.pieces.empty();
  for (const PlannedPiece& piece : plan.pieces) {
    for (const Hop& hop : piece.hops) {
      quadrics &= system.surfaces()[hop.surface].shape->at_most_quadratic();
    }
  }
  if (quadrics && !needless.third_derivatives) {
    plan.skipped.push_back({"third_derivatives",
                            "all surfaces are planes or quadrics, whose third "
                            "derivatives vanish"});
  }
  bool visibility = plan.direct && plan.direct->visibility;
  for (const PlannedPiece& piece : plan.pieces) visibility |= piece.visibility;
  if (unhidden > 0 && !no_skip.count("visibility")) {
    const bool alone = system.surfaces().size() == 1;
    plan.skipped.push_back(
        {"visibility", alone ? "one convex surface, nothing else to hit"
                             : std::to_string(unhidden) +
                                   " families of convex surfaces with nothing in the way"});
  }
  const int count = static_cast<int>(system.surfaces().size());
  plan.embree = visibility && (count >= kEmbreeSurfaces || no_skip.count("embree") > 0);
  if (!plan.embree) {
    plan.skipped.push_back({"embree", !visibility ? "visibility is not asked"
                                                  : "asking each of " + std::to_string(count) +
                                                        (count == 1 ? " surface" : " surfaces") +
                                                        " is faster than a hierarchy"});
  }
  return plan;
}

}  // namespace caustic::solver
