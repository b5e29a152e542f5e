// Specular paths drawn at random: a ray sent from a point through shapes of the zoo, reflected or
// refracted at each, until a place on its way becomes the other end.
#pragma once

#include <optional>
#include <vector>

#include "solver/specular_path.h"
#include "tests/support/random.h"
#include "tests/support/reference_path.h"

namespace caustic::test {

struct RandomPath {
  std::vector<ReferenceVertex> hops;         ///< what the reference is told
  std::vector<geometry::SurfacePtr> shapes;  ///< what the program is told
  solver::SpecularChain chain;
  solver::SpecularPath path;
};

/// Cosine with the normal below which derivatives grow beyond what a tolerance in units of one
/// says.
constexpr double kLeastCosine = 0.25;

inline geometry::Vec3 sent_on(const ReferenceVertex& hop, const geometry::Vec3& w,
                              const geometry::Vec3& n) {
  if (hop.reflects) return w - 2.0 * w.dot(n) * n;
  const double eta = hop.index_before / hop.index_after, c = w.dot(n);
  const double xi = 1.0 - eta * eta * (1.0 - c * c);
  if (xi < 0.05) return geometry::Vec3::Zero();
  return (eta * w + (std::copysign(std::sqrt(xi), c) - eta * c) * n).normalized();
}

/// Nothing if the ray misses a shape or grazes it.
inline std::optional<RandomPath> try_random_path(int hops, Random& random) {
  RandomPath r;
  geometry::Point o = random.in_cube(3.0);
  r.path.from = o;
  geometry::Vec3 w = (random.in_cube(0.7) - o).normalized();
  double index = random.uniform(1.0, 1.5);
  for (int i = 0; i < hops; ++i) {
    ReferenceVertex hop{shape_zoo()[random.index(static_cast<int>(shape_zoo().size()))]};
    hop.shape.pose.translation += 0.3 * random.direction() + (i > 0 ? 1.5 : 0.0) * w;
    hop.reflects = random.index(2) == 0;
    hop.index_before = index;
    if (!hop.reflects) index = random.uniform(1.0, 1.8);
    hop.index_after = index;
    r.shapes.push_back(build(hop.shape));
    geometry::RayParameters t;
    r.shapes[i]->crossings({o, w}, 0.3, 8.0, t);
    if (t.empty()) return std::nullopt;
    o += t.front() * w;
    for (const auto& bound : r.shapes[i]->own_bounds()) {
      if (bound.value(o) > -0.05) return std::nullopt;  // the rim of a conic, the apex of none
    }
    geometry::Vec3 n;
    r.shapes[i]->value_gradient(o, n);
    n.normalize();
    if (std::abs(n.dot(w)) < kLeastCosine) return std::nullopt;
    w = sent_on(hop, w, n);
    if (!(std::abs(n.dot(w)) > kLeastCosine)) return std::nullopt;
    r.hops.push_back(hop);
    r.chain.push_back({r.shapes[i].get(), hop.reflects, hop.index_before, hop.index_after});
    r.path.x.push_back(o);
  }
  r.path.to = o + random.uniform(0.3, 3.0) * w;
  return r;
}

inline RandomPath random_path(int hops, Random& random) {
  for (;;) {
    if (auto path = try_random_path(hops, random)) return *std::move(path);
  }
}

}  // namespace caustic::test
