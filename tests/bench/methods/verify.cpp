#include "tests/bench/methods/verify.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "solver/point_irradiance.h"
#include "tests/bench/methods/closed_forms.h"
#include "tests/bench/methods/truth.h"
#include "tests/support/reference.h"
#include "tests/support/strips.h"

namespace caustic::bench {

using geometry::Vec2;
using solver::Curve;
using solver::CurveVertex;
using solver::Measure;

namespace {

constexpr std::size_t kClosedPlaces = 2000, kReferencePlaces = 200;
constexpr double kProofSeconds = 60.0;

struct Finding {
  const char* what;
  std::size_t points = 0;
  double farthest = 0.0;  // m

  void add(double distance) {
    ++points;
    farthest = std::max(farthest, distance);
  }
};

// Calls it for about `count` vertices of all drawn curves, evenly. Not for the ends of open ones:
// there a sheet begins, and what a meter reads is another on each side.
template <class Look>
void look_at(const solver::ContourResult& result, std::size_t count, const Look& look) {
  std::size_t all = 0;
  for (const Curve& c : result.curves) all += is_drawn(c) ? c.vertices.size() : 0;
  const std::size_t step = std::max<std::size_t>(1, all / count);
  std::size_t next = 0, seen = 0;
  for (const Curve& c : result.curves) {
    if (!is_drawn(c)) continue;
    for (; next < seen + c.vertices.size(); next += step) {
      const std::size_t i = next - seen;
      if (c.closed || (i > 0 && i + 1 < c.vertices.size())) look(c, c.vertices[i]);
    }
    seen += c.vertices.size();
  }
}

test::ReferenceScene reference_of(const Scene& scene) {
  using Kind = test::ShapeSpec::Kind;
  const auto& mirror = scene.system.surfaces()[0];
  test::ReferenceScene reference{.shape = {.name = scene.name},
                                 .side = 0,
                                 .reflectance = 1.0,
                                 .light = scene.system.light(),
                                 .receiver = scene.system.receiver(),
                                 .optics = mirror.optics};
  auto& shape = reference.shape;
  if (scene.name[0] == 'A') shape.kind = Kind::sphere;
  if (scene.name == "B") shape.kind = Kind::cylinder;
  if (scene.name == "C1") shape.expression = "z-0.1*sin(6.283185307179586*x)", shape.radius = 2.0;
  if (scene.name == "cuboid") shape.expression = "x^4+y^4+z^4-x^2-y^2-z^2", shape.radius = 1.3;
  if (!shape.expression.empty()) shape.kind = Kind::expression;
  if (scene.name == "vase") {
    shape.kind = Kind::revolution;
    shape.radius = 2.0;
    shape.profile = {0.47, 3.9, -9.78, 5.8};
  }
  return reference;
}

// Where 50 digits send the light of x, and how bright, as a distance of the level curve from q.
class FiftyDigits {
 public:
  FiftyDigits(const Scene& scene, Measure measure)
      : scene_(scene),
        measure_(measure),
        reference_(reference_of(scene)),
        meter_(scene.system, {}, false) {}

  double distance(const Curve& curve, const CurveVertex& v) {
    double E = 0.0, aside = 0.0;
    if (measure_ == Measure::sheet) {
      E = add(v.x, v.uv, aside);
    } else {
      for (const auto& sheet : meter_.at(v.uv).sheets) E += add(sheet.x, v.uv, aside);
    }
    return std::max(aside, std::abs(E - curve.level) / v.gradient.norm());
  }

 private:
  double add(const geometry::Point& x, const Vec2& uv, double& aside) {
    const auto& mirror = scene_.system.surfaces()[0];
    geometry::Vec3 N;
    mirror.shape->value_gradient(x, N);
    const auto* lamp = std::get_if<solver::PointLight>(&scene_.system.light());
    const geometry::Vec3 d =
        lamp ? geometry::Vec3(x - lamp->position)
             : std::get<solver::CollimatedLight>(scene_.system.light()).direction;
    reference_.side = N.dot(d) < 0.0 ? 1 : -1;
    const auto field = test::reference_field(reference_, x);
    aside = std::max(aside, (field.q - uv).norm());
    return std::abs(field.flux / field.a);
  }

  const Scene& scene_;
  Measure measure_;
  test::ReferenceScene reference_;
  solver::LightMeter meter_;
};

Finding fifty_digits(const Scene& scene, Measure measure, const solver::ContourResult& result) {
  Finding finding{"50 digits"};
  FiftyDigits digits(scene, measure);
  look_at(result, kReferencePlaces, [&](const Curve& c, const CurveVertex& v) {
    if (c.kind == solver::CurveKind::isolux) finding.add(digits.distance(c, v));
  });
  return finding;
}

Finding circles(const Scene& scene, const solver::ContourResult& result) {
  Finding finding{"circles"};
  for (const double level : scene.levels) {
    const double radius = circle_of_a_ball(level);
    look_at(result, kClosedPlaces, [&](const Curve& c, const CurveVertex& v) {
      if (c.level == level) finding.add(std::abs(v.uv.norm() - radius));
    });
  }
  return finding;
}

Finding water(const solver::ContourResult& result) {
  Finding finding{"one dimension"};
  const test::Strips strips = test::strips_of_water(1.0);
  look_at(result, kClosedPlaces, [&](const Curve& c, const CurveVertex& v) {
    finding.add(std::abs(strips.irradiance(v.p.x()) - c.level) / v.gradient.norm());
  });
  return finding;
}

std::vector<Finding> nephroid(const Scene& scene, const solver::ContourResult& result) {
  std::vector<Finding> findings{
      {"level arcs by one dimension"}, {"caustic's arc"}, {"edges of the ring"}};
  const NephroidRing ring;
  look_at(result, kClosedPlaces, [&](const Curve& c, const CurveVertex& v) {
    const Vec2 q = scene.system.receiver().point(v.uv).head<2>();
    if (c.kind == solver::CurveKind::isolux)
      findings[0].add(std::abs(ring.irradiance(q) - c.level) / v.gradient.norm());
    else if (c.boundary == solver::BoundaryKind::caustic)
      findings[1].add(ring.distance_from_caustic(q));
    else
      findings[2].add(ring.distance_from_edges(q));
  });
  return findings;
}

}  // namespace

void verify(const Scene& scene, std::ostream& out) {
  for (const Measure measure : {Measure::total, Measure::sheet}) {
    const Truth truth = make_truth(scene, measure);
    // Whether a curve is missed does not depend on how finely they are drawn.
    auto request = request_of(scene, measure, 1e-3);
    request.certify = true;
    request.cell_limit = 10'000'000;
    request.time_limit = kProofSeconds;
    const auto proof = solver::trace_contours(scene.system, request);

    std::vector<Finding> findings{fifty_digits(scene, measure, truth.result)};
    if (scene.name == "A1") findings.push_back(circles(scene, truth.result));
    if (scene.name == "C1" && measure == Measure::total) findings.push_back(water(truth.result));
    if (scene.name == "B" && measure == Measure::total)
      for (const Finding& f : nephroid(scene, truth.result)) findings.push_back(f);
    std::size_t vertices = 0;
    for (const Curve& c : truth.result.curves) vertices += is_drawn(c) ? c.vertices.size() : 0;
    for (const Finding& f : findings) {
      char numbers[120];
      std::snprintf(numbers, sizeof numbers, "%g,%.3g,%zu,%s,%zu,\"%s\",%zu,%.2g",
                    scene.truth_chord, truth.result.seconds, vertices,
                    proof.certified ? "yes" : "no", proof.undecided_cells, f.what, f.points,
                    f.farthest / scene.width());
      out << scene.name << ',' << (measure == Measure::total ? "total" : "sheets") << ',' << numbers
          << '\n'
          << std::flush;
    }
  }
}

}  // namespace caustic::bench
