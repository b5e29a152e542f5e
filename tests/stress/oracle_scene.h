// A second reader of requests: the scene as the 50-digit reference needs it, from the same text as
// the service's reader and with none of its code.
#pragma once

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "geometry/receiver_frame.h"
#include "solver/light.h"
#include "solver/optics.h"
#include "tests/support/expression_oracle.h"
#include "tests/support/shape_zoo.h"

namespace caustic::stress {

using geometry::Point;
using geometry::Vec2;
using geometry::Vec3;
using nlohmann::json;
using Long = long double;
using LongVec = Eigen::Matrix<Long, 3, 1>;
using LongExpression = test::ExpressionOracle<Long>;

/// Where a surface exists: excess ≤ 0. A length, except of expressions.
struct OracleAperture {
  enum class Kind { box, cylinder, half_space, expression };
  Kind kind;
  Point a = Point::Zero(), b = Point::Zero();  ///< box: min, max; else point and axis or normal
  double radius = 0.0;
  std::shared_ptr<const LongExpression> expression = nullptr;
  double metres = 1.0;

  Long excess(const LongVec& x) const;
};

struct OracleSurface {
  std::string name;
  test::ShapeSpec shape;
  std::shared_ptr<const LongExpression> expression;  ///< of the shape, if it is one
  geometry::Vec3 lo, hi;                             ///< own box of an expression, in its frame
  std::vector<OracleAperture> apertures;
  solver::Optics optics;

  /// g or a multiple of it; NaN where it is not defined.
  Long value(const LongVec& x) const;
  LongVec gradient(const LongVec& x) const;
  /// > 0 beyond the end of the shape itself or of an aperture.
  Long excess(const LongVec& x) const;
  /// World ball that holds all of it; infinite radius if it is unbounded.
  std::pair<Point, double> ball() const;

 private:
  LongVec local(const LongVec& x) const;
  Long own_excess(const LongVec& y) const;
};

struct OracleScene {
  double metres = 1.0;
  solver::Light light;
  std::vector<OracleSurface> surfaces;
  geometry::ReceiverFrame receiver;
  double size = 1.0;  ///< of receiver, point light and bounded surfaces

  bool point_light() const { return light.index() == 0; }
  int index_of(const std::string& name) const;
};

/// For requests that the service accepts.
OracleScene read_oracle_scene(const json& scene);
/// Shape and pose of one surface, SI.
OracleSurface read_oracle_surface(const json& surface, double metres);

Vec3 vec3(const json& array);
geometry::Pose read_pose(const json& surface, double metres);

}  // namespace caustic::stress
