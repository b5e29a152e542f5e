// Any quadric of ten coefficients to its normal form: what it is, where its centre and axes are,
// and which charts cover it.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "geometry/quadric.h"

namespace caustic::geometry {

namespace {

// Coefficients below this share of the largest of their kind are rounding of zero.
constexpr double kZeroShare = 1e-13;
// An axis of less than this share of the largest curvature is flat: its centre may be far away.
constexpr double kFlatShare = 0.04;
// A centre that is this many times farther than the surface and its radius of curvature is not used:
// g about it loses as many digits as this has.
constexpr double kFarFactor = 25.0;
// A semi-axis is long if the region reaches less than the root of this share of it; two such axes
// leave a positive height between them.
constexpr double kLongAxis = 0.4;

// xᵀQx + 2G·x + J = 0, reduced: Σ λᵢ yᵢ² + 2ℓ y₂ + k = 0 with λ sorted so that its non-zero entries
// come first; if ℓ ≠ 0 then λ₂ = 0 and k = 0.
struct Reduced {
  Point origin = Point::Zero();
  Mat3 axes;
  Vec3 lambda;
  double linear = 0.0;
  double constant = 0.0;
  int rank = 0;
};

Reduced reduce(const Mat3& Q, const Vec3& G, double J) {
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(Q);
  Reduced r;
  std::array<int, 3> order{0, 1, 2};
  const Vec3 values = solver.eigenvalues();
  const double largest = values.cwiseAbs().maxCoeff();
  std::stable_sort(order.begin(), order.end(),
                   [&](int i, int j) { return std::abs(values[i]) > std::abs(values[j]); });
  for (int i = 0; i < 3; ++i) {
    r.axes.col(i) = solver.eigenvectors().col(order[i]);
    const double value = values[order[i]];
    r.lambda[i] = std::abs(value) > kZeroShare * largest ? value : 0.0;
    if (r.lambda[i] != 0.0) ++r.rank;
  }

  // Complete the squares; what is left of G lies in the null space of Q.
  const Vec3 b = r.axes.transpose() * G;
  Vec3 center = Vec3::Zero(), rest = b;
  double magnitude = std::abs(J);
  r.constant = J;
  for (int i = 0; i < r.rank; ++i) {
    center[i] = -b[i] / r.lambda[i];
    rest[i] = 0.0;
    r.constant += b[i] * center[i];
    magnitude += std::abs(b[i] * center[i]);
  }
  if (std::abs(r.constant) <= kZeroShare * magnitude) r.constant = 0.0;

  if (rest.norm() > kZeroShare * b.norm()) {
    // Turn the null space so that the linear part lies along the last axis, and absorb k there.
    const Direction along = (r.axes * rest).normalized();
    if (r.rank <= 1) {
      const Direction first = r.rank == 1 ? Direction(r.axes.col(0)) : Frame(along).e1;
      r.axes << first, along.cross(first), along;
    } else {
      r.axes.col(2) = along;
    }
    r.linear = rest.norm();
    center[2] = 0.0;
    r.origin = r.axes.leftCols(r.rank) * center.head(r.rank) -
               along * (0.5 * r.constant / r.linear);
    r.constant = 0.0;
  } else {
    r.origin = r.axes * center;
  }
  if (r.axes.determinant() < 0.0) r.axes.col(0) = -r.axes.col(0);
  return r;
}

// The same quadric about one of its points, for when the centre is far away or infinitely so:
// Σ λᵢ yᵢ² + 2ℓ·y = 0 in the axes of Reduced. Nearly parabolic surfaces lose nothing here.
struct Vertex {
  Point origin;
  Vec3 linear;  // ℓ, in the flat axes only
};

std::optional<Vertex> vertex_of(const Reduced& r, const Vec3& G, double J) {
  const Vec3 b = r.axes.transpose() * G;
  Vec3 y = Vec3::Zero(), flat = Vec3::Zero();  // b in the flat axes
  const double largest = r.lambda.cwiseAbs().maxCoeff();
  double constant = J, largest_flat = 0.0;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(r.lambda[i]) > kFlatShare * largest) {
      y[i] = -b[i] / r.lambda[i];
      constant += b[i] * y[i];
    } else {
      flat[i] = b[i];
      largest_flat = std::max(largest_flat, std::abs(r.lambda[i]));
    }
  }
  const double slope = flat.norm();
  if (!(slope > kZeroShare * b.norm())) return {};

  // The nearest point straight down the slope: α δ² + 2 slope δ + constant = 0.
  const Vec3 along = flat / slope;
  const double alpha = along.dot(r.lambda.cwiseProduct(along));
  const double discriminant = slope * slope - alpha * constant;
  if (!(discriminant > 0.0)) return {};
  const double step = -constant / (slope + std::sqrt(discriminant));
  const double radius = largest > 0.0 ? slope / largest : 0.0;
  if (largest_flat * kFarFactor * (std::abs(step) + radius) > slope) return {};
  const Vec3 down = step * along;
  return Vertex{r.axes * (y + down), flat + r.lambda.cwiseProduct(down)};
}

struct Charted {
  ChartMaker charts;
  Box box{};
  std::string fault;
};

// Charts of Σ sᵢ yᵢ² = 1 around axes that `closes` marks: the surface closes around two of them (a
// tube), around all three, or around one only (two sheets across it).
ChartMaker charts_around(const std::array<bool, 3>& closes, const Point& origin, const Mat3& axes,
                         const Vec3& s) {
  const int count = closes[0] + closes[1] + closes[2];
  if (count == 3) return ellipsoid_charts(origin, axes, s.cwiseSqrt().cwiseInverse());
  // The axis that is unlike the others comes last.
  int last = 0;
  for (int i = 0; i < 3; ++i) if (closes[i] == (count == 1)) last = i;
  const int first = (last + 1) % 3, second = (last + 2) % 3;
  Mat3 turned;
  turned << axes.col(first), axes.col(second), axes.col(last);
  if (count == 2) {
    return tube_charts(origin, turned, 1.0 / std::sqrt(s[first]), 1.0 / std::sqrt(s[second]), 1.0,
                       -s[last]);
  }
  const double sa = s[first], sb = s[second], su = s[last];
  const Height height = [=](double a, double b) {
    return std::sqrt((1.0 - sa * a * a - sb * b * b) / su);
  };
  return sheet_charts(origin, turned, {height, [=](double a, double b) { return -height(a, b); }});
}

// Σ sᵢ yᵢ² = 1 with `rank` non-zero s: ellipsoid, hyperboloids, cylinders, parallel planes.
Charted central(const Reduced& r) {
  const Vec3 s = -r.lambda / r.constant;
  if (!(s.array() > 0.0).any()) return {{}, {}, "the quadric has no real point"};
  Box box{};
  if ((s.array() > 0.0).all()) {
    const Vec3 reach = (r.axes * s.cwiseSqrt().cwiseInverse().asDiagonal()).rowwise().norm();
    box = {r.origin - reach, r.origin + reach};
  }
  const ChartMaker charts = [s, origin = r.origin, axes = r.axes](const Extent& extent) {
    // Seen from a region that ends well before it, a long axis is as good as endless: charts that
    // went all the way around would leave the region a small share of the unit square.
    const double reach = (extent.region.center() - origin).norm() + extent.region.diagonal();
    std::array<bool, 3> positive, closes;
    for (int i = 0; i < 3; ++i) {
      positive[i] = s[i] > 0.0;
      closes[i] = s[i] * reach * reach > kLongAxis;
    }
    const bool none = !closes[0] && !closes[1] && !closes[2];
    return charts_around(none ? positive : closes, origin, axes, s)(extent);
  };
  return {charts, box, ""};
}

// Σ λᵢ yᵢ² = 0: a cone, two crossing planes, or less than a surface.
Charted homogeneous(const Reduced& r) {
  const auto positive = (r.lambda.array() > 0.0).count();
  const auto negative = (r.lambda.array() < 0.0).count();
  if (positive == 0 || negative == 0) {
    return {{}, {}, r.rank == 1 ? "the quadric is a double plane, which has no normal"
                                : "the quadric is a single point or line"};
  }
  if (r.rank == 2) return {{}, {}, "the quadric is a pair of crossing planes; give two planes"};
  const int odd_sign = positive == 1 ? 1 : -1;
  int last = 2;
  for (int i = 0; i < 3; ++i) if (r.lambda[i] * odd_sign > 0.0) last = i;
  Mat3 turned;
  turned << r.axes.col((last + 1) % 3), r.axes.col((last + 2) % 3), r.axes.col(last);
  const double la = std::abs(r.lambda[(last + 1) % 3] / r.lambda[last]);
  const double lb = std::abs(r.lambda[(last + 2) % 3] / r.lambda[last]);
  return {tube_charts(r.origin, turned, 1.0 / std::sqrt(la), 1.0 / std::sqrt(lb), 0.0, 1.0), {}, ""};
}

Charted classify(const Reduced& r) {
  if (r.linear != 0.0) {
    const double la = r.lambda[0], lb = r.lambda[1], twice = 2.0 * r.linear;
    return {sheet_charts(r.origin, r.axes,
                         {[=](double a, double b) { return -(la * a * a + lb * b * b) / twice; }}),
            {}, ""};
  }
  if (r.rank == 0) return {{}, {}, "all coefficients of x, y and z are zero"};
  return r.constant != 0.0 ? central(r) : homogeneous(r);
}

// Around the vertex one sheet over the plane across its slope, the smaller root of
// α h² + 2β h + γ = 0; `far` where the region reaches beyond what that sheet covers.
ChartMaker vertex_charts(const Point& origin, const Mat3& axes, const Vec3& lambda,
                         const Vec3& linear, const ChartMaker& far) {
  const double slope = linear.norm();
  const Mat3 frame = axes_about((axes * (linear / slope)).normalized());
  const Mat3 A = axes * lambda.asDiagonal() * axes.transpose(), M = frame.transpose() * A * frame;
  const Height height = [M, slope](double a, double b) {
    const double alpha = M(2, 2), beta = slope + M(0, 2) * a + M(1, 2) * b;
    const double gamma = M(0, 0) * a * a + 2.0 * M(0, 1) * a * b + M(1, 1) * b * b;
    return -gamma / (beta + std::sqrt(beta * beta - alpha * gamma));
  };
  const ChartMaker sheet = sheet_charts(origin, frame, {height});
  const double flat = M.col(2).norm(), bend = M.norm();
  return [=](const Extent& extent) {
    const double reach = (extent.region.center() - origin).norm() + extent.region.diagonal();
    // Keeps β > ¾ slope, the root real, and the other sheet out of reach.
    if (4.0 * flat * reach < slope && 4.0 * flat * bend * reach * reach < slope * slope) {
      return sheet(extent);
    }
    // Those charts know the surface to the rounding of the far centre: Newton's step from there.
    std::vector<Chart> charts = far(extent);
    for (Chart& chart : charts) {
      chart.point = [=, rough = std::move(chart.point), b = Vec3(axes * linear)](double s, double t) {
        const Vec3 y = rough(s, t) - origin, Ay = A * y, half_gradient = Ay + b;
        const double g = y.dot(Ay + 2.0 * b);
        return Point(origin + y - half_gradient * (0.5 * g / half_gradient.squaredNorm()));
      };
    }
    return charts;
  };
}

}  // namespace

QuadricResult make_quadric(const std::array<double, 10>& c, const Pose& pose) {
  Mat3 Q;
  Q << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];
  const Vec3 G(c[6], c[7], c[8]);
  const Reduced r = reduce(Q, G, c[9]);
  const std::optional<Vertex> vertex = vertex_of(r, G, c[9]);
  Reduced posed = r;
  posed.origin = pose.point(r.origin);
  posed.axes = pose.rotation * r.axes;
  Charted charted = classify(posed);
  if (!charted.fault.empty()) return {nullptr, charted.fault};

  // Scale g to a length: by the slope at the vertex, or by the radius of curvature at the ends of
  // the steepest axis.
  if (vertex) {
    const double scale = 1.0 / vertex->linear.norm();
    const Point origin = pose.point(vertex->origin);
    const ChartMaker charts =
        vertex_charts(origin, posed.axes, r.lambda, vertex->linear, charted.charts);
    // The far centre knows the box to its own rounding only.
    const double slack = 8.0 * kEpsilon * charted.box.diagonal();
    if (charted.box.bounded()) {
      charted.box = {charted.box.min.array() - slack, charted.box.max.array() + slack};
    }
    const QuadricForm form{origin, posed.axes, scale * r.lambda, scale * vertex->linear, 0.0};
    return {make_quadric_surface(form, charts, charted.box), ""};
  }
  const double largest = r.lambda.cwiseAbs().maxCoeff();
  const double scale = r.constant != 0.0 ? 0.5 / std::sqrt(largest * std::abs(r.constant))
                                         : 0.5 / largest;
  const QuadricForm form{posed.origin, posed.axes, 2.0 * scale * r.lambda,
                         {0.0, 0.0, 2.0 * scale * r.linear}, scale * r.constant};
  return {make_quadric_surface(form, charted.charts, charted.box), ""};
}

}  // namespace caustic::geometry
