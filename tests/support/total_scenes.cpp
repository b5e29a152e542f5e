#include "tests/support/total_scenes.h"

#include "geometry/expression/field.h"
#include "tests/support/scenes.h"

namespace caustic::test {

using namespace solver;
using geometry::Box;
using geometry::Point;
using geometry::Vec3;

namespace {

SystemSurface expression(const char* text, const Box& bounds) {
  return mirror(
      geometry::make_expression(geometry::read_expression(text, 1.0), bounds, {}).surface);
}

OpticalSystem waves_over(const geometry::ReceiverFrame& floor) {
  SystemSurface water = expression("z-0.1*sin(6.283185307179586*x)-0.06*cos(6.283185307179586*y)",
                                   {Point(-1, -1, -0.2), Point(2, 2, 0.2)});
  water.optics = {.kind = Optics::Kind::refract, .index_outside = 1.0, .index_inside = 1.33};
  return OpticalSystem::build(CollimatedLight{{0, 0, -1}, 1.0}, {water}, floor);
}

}  // namespace

OpticalSystem ball_under_ceiling() {
  return one_mirror(PointLight{{0, 0, 4}, 1.0}, geometry::make_sphere(Point::Zero(), 1.0),
                    floor_at({0, 0, 6}, 12, 12));
}

OpticalSystem nephroid_ring() {
  return one_mirror(CollimatedLight{Vec3(1, 0, -1).normalized(), 1.0},
                    geometry::make_cylinder(Point::Zero(), {0, 0, 1}, 1.0),
                    floor_at({0.5, 0, 0}, 1.2, 1.2),
                    geometry::box_aperture({0.5, -1, 0}, {1.001, 1, 1}));
}

const Plate kPlates[2] = {
    {{-0.5, 0, 0}, Vec3(0.2, 0, 1).normalized(), {-0.8, -0.3}, {-0.2, 0.3}, 0.9},
    {{0.5, 0, 0}, Vec3(-0.2, 0.05, 1).normalized(), {0.2, -0.25}, {0.8, 0.35}, 0.8}};

OpticalSystem two_plates() {
  std::vector<SystemSurface> surfaces;
  for (const Plate& p : kPlates) {
    surfaces.push_back(mirror(
        geometry::make_plane(p.middle, p.normal),
        geometry::box_aperture({p.lo.x(), p.lo.y(), -1}, {p.hi.x(), p.hi.y(), 1}), p.reflectance));
  }
  surfaces[1].name = "right";
  return OpticalSystem::build(PointLight{kLampOverPlates, 1.0}, surfaces,
                              floor_at({0, 0, 1.5}, 3, 3));
}

OpticalSystem crossing_waves() { return waves_over(floor_at({0.45, 0.37, -1.6}, 1, 1)); }
OpticalSystem shallow_crossing_waves() { return waves_over(floor_at({0.45, 0.37, -0.4}, 1, 1)); }

OpticalSystem tilted_dish() {
  return one_mirror(CollimatedLight{Vec3(0.3, 0.1, -1).normalized(), 1.0},
                    geometry::make_sphere({0, 0, 2}, 2.0), floor_at({0.3, 0.1, 1.0}, 0.6, 0.6),
                    {geometry::half_space_aperture({0, 0, 0.25}, {0, 0, 1})});
}

OpticalSystem torus_beside_lamp() {
  return one_mirror(PointLight{{3, 0, 2}, 1.0},
                    geometry::make_torus(Point::Zero(), {0, 0, 1}, 1.5, 0.5),
                    floor_at({0, 0, 4}, 8, 8));
}

OpticalSystem cuboid_over_floor() {
  return OpticalSystem::build(
      PointLight{{3, 1.5, 3}, 1.0},
      {expression("x^4+y^4+z^4-x^2-y^2-z^2", Box::around(Point::Zero(), 1.3))},
      floor_at({0, 0, -1.3}, 8, 8));
}

}  // namespace caustic::test
