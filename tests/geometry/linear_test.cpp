#include "geometry/linear.h"

#include <gtest/gtest.h>

#include "geometry/cube_sphere.h"
#include "geometry/pose.h"
#include "geometry/receiver_frame.h"
#include "tests/support/random.h"

namespace caustic::geometry {
namespace {

using test::Random;

void expect_orthonormal(const Vec3& a, const Vec3& b, const Vec3& c) {
  Mat3 m;
  m << a, b, c;
  EXPECT_LT((m.transpose() * m - Mat3::Identity()).norm(), 2e-15);
  EXPECT_GT(m.determinant(), 0.0);
}

TEST(Frame, CompletesEveryNormal) {
  Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Direction n = random.direction();
    const Frame frame(n);
    expect_orthonormal(frame.e1, frame.e2, n);
  }
  // Poles, and just beside them on either side of the sign's jump.
  for (const Vec3& n : {Vec3(0, 0, 1), Vec3(0, 0, -1), Vec3(1, 0, 0), Vec3(1, 0, -0.0),
                        Vec3(1e-9, 0, -1), Vec3(1e-200, 1e-200, -1), Vec3(0, -1, 1e-300)}) {
    const Direction unit = n.normalized();
    expect_orthonormal(Frame(unit).e1, Frame(unit).e2, unit);
    EXPECT_EQ(axes_about(unit).col(2), unit);
  }
}

TEST(Pose, RotatesAboutTheOriginThenShifts) {
  const Pose pose = Pose::make({0, 0, 1}, kPi / 2, {1, 0, 0});
  EXPECT_LT((pose.point({1, 0, 0}) - Point(1, 1, 0)).norm(), 1e-15);
  EXPECT_LT((pose.direction({1, 0, 0}) - Vec3(0, 1, 0)).norm(), 1e-15);
}

TEST(ReceiverFrame, OrthogonalisesAndMeasures) {
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    const Vec3 u = 3.0 * random.direction(), v = 0.2 * random.direction();
    if (u.cross(v).norm() < 0.05) continue;
    const auto r = ReceiverFrame::make(random.in_cube(3.0), u, v, {4.0, 2.0});
    expect_orthonormal(r.u, r.v, r.m);
    EXPECT_GT(r.v.dot(v), 0.0);
    EXPECT_EQ(r.width(), 4.0);
    const Vec2 q(1.9, -0.9);
    EXPECT_TRUE(r.contains(q));
    EXPECT_FALSE(r.contains({2.1, 0.0}));
    EXPECT_FALSE(r.contains({0.0, -1.1}));
    EXPECT_NEAR(r.u.dot(r.point(q) - r.origin), q.x(), 1e-14);
    EXPECT_NEAR(r.v.dot(r.point(q) - r.origin), q.y(), 1e-14);
  }
}

TEST(CubeSphere, SixFacesCoverTheSphereOnce) {
  Random random(3);
  for (int i = 0; i < 1000; ++i) {
    const int face = random.index(6);
    const Direction d = cube_sphere(face, random.uniform(), random.uniform());
    EXPECT_NEAR(d.norm(), 1.0, 1e-15);
    // The face is that of the largest component.
    int axis = 0;
    d.cwiseAbs().maxCoeff(&axis);
    EXPECT_EQ(face, 2 * axis + (d[axis] > 0.0 ? 0 : 1));
  }
}

TEST(Box, Basics) {
  EXPECT_FALSE(Box().bounded());
  EXPECT_FALSE(Box().empty());
  const Box a = Box::around({0, 0, 0}, 1.0), b = Box::around({5, 0, 0}, 1.0);
  EXPECT_TRUE(a.intersected(b).empty());
  EXPECT_TRUE(a.contains({1, 1, 1}));
  EXPECT_NEAR(a.diagonal(), 2.0 * std::sqrt(3.0), 1e-15);
}

}  // namespace
}  // namespace caustic::geometry
