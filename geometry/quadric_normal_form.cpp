// Any quadric of ten coefficients to its normal form: what it is, where its centre and axes are,
// and which charts cover it.
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "geometry/quadric.h"

namespace caustic::geometry {

namespace {

// Coefficients below this share of the largest of their kind are rounding of zero.
constexpr double kZeroShare = 1e-13;

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

struct Charted {
  ChartMaker charts;
  Box box{};
  std::string fault;
};

// Σ sᵢ yᵢ² = 1 with `rank` non-zero s: ellipsoid, hyperboloids, cylinders, parallel planes.
Charted central(const Reduced& r) {
  Vec3 s = -r.lambda / r.constant;
  Mat3 axes = r.axes;
  const auto positive = (s.array() > 0.0).count();
  if (positive == 0) return {{}, {}, "the quadric has no real point"};
  if (positive == 3) {
    const Vec3 semi = s.cwiseSqrt().cwiseInverse();
    const Vec3 reach = (axes * semi.asDiagonal()).rowwise().norm();
    return {ellipsoid_charts(r.origin, axes, semi), {r.origin - reach, r.origin + reach}, ""};
  }
  if (positive == 2) {
    // Tube about the axis whose s is not positive.
    int last = 2;
    for (int i = 0; i < 3; ++i) if (!(s[i] > 0.0)) last = i;
    Mat3 turned;
    turned << axes.col((last + 1) % 3), axes.col((last + 2) % 3), axes.col(last);
    const double a = 1.0 / std::sqrt(s[(last + 1) % 3]), b = 1.0 / std::sqrt(s[(last + 2) % 3]);
    return {tube_charts(r.origin, turned, a, b, 1.0, -s[last]), {}, ""};
  }
  // Two sheets over the plane across the one positive axis.
  int up = 0;
  for (int i = 0; i < 3; ++i) if (s[i] > 0.0) up = i;
  Mat3 turned;
  turned << axes.col((up + 1) % 3), axes.col((up + 2) % 3), axes.col(up);
  const double sa = s[(up + 1) % 3], sb = s[(up + 2) % 3], su = s[up];
  const Height height = [=](double a, double b) {
    return std::sqrt((1.0 - sa * a * a - sb * b * b) / su);
  };
  return {sheet_charts(r.origin, turned, {height, [=](double a, double b) { return -height(a, b); }}),
          {}, ""};
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

}  // namespace

QuadricResult make_quadric(const std::array<double, 10>& c, const Pose& pose) {
  Mat3 Q;
  Q << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];
  const Reduced r = reduce(Q, {c[6], c[7], c[8]}, c[9]);
  const Charted charted = classify(r);
  if (!charted.fault.empty()) return {nullptr, charted.fault};

  // Scale g to a length: by the radius of curvature at the vertices, or by the slope.
  double scale = 1.0 / r.lambda.cwiseAbs().maxCoeff();
  if (r.linear != 0.0) {
    scale = 0.5 / r.linear;
  } else if (r.constant != 0.0) {
    scale *= 0.5 * std::sqrt(r.lambda.cwiseAbs().maxCoeff() / std::abs(r.constant));
  } else {
    scale *= 0.5;
  }
  // The posed frame; charts were made for the unposed one, so make them again.
  Reduced posed = r;
  posed.origin = pose.point(r.origin);
  posed.axes = pose.rotation * r.axes;
  const Charted placed = classify(posed);
  const QuadricForm form{posed.origin, posed.axes, 2.0 * scale * r.lambda, 2.0 * scale * r.linear,
                         scale * r.constant};
  return {make_quadric_surface(form, placed.charts, placed.box), ""};
}

}  // namespace caustic::geometry
