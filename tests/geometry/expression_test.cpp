// Expressions: what is read, what it computes, what is wrong with it.
#include <gtest/gtest.h>

#include <boost/multiprecision/cpp_bin_float.hpp>

#include "geometry/expression/field.h"
#include "geometry/expression/parse.h"
#include "tests/support/expression_oracle.h"
#include "tests/support/random.h"

namespace caustic::geometry {
namespace {

using test::Random;
using Real = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>,
                                           boost::multiprecision::et_off>;
using RealPoint = std::array<Real, 3>;

double value_of(const std::string& text, const Point& x = {2.0, 3.0, 5.0}) {
  const Expression e = read_expression(text, 1.0);
  EXPECT_EQ(e.fault, "") << text;
  return e.fault.empty() ? Field(e, 1.0).value(x) : 0.0;
}
std::string fault_of(const std::string& text) { return read_expression(text, 1.0).fault; }

TEST(Parse, FollowsTheRulesOfArithmetic) {
  const std::pair<const char*, double> cases[] = {
      {"1+2*3", 7.0},    {"(1+2)*3", 9.0},     {"2^3^2", 512.0}, {"-2^2", -4.0},
      {"(-2)^2", 4.0},   {"2^-1", 0.5},        {"7-4-2", 1.0},   {"16/4/2", 2.0},
      {"-x", -2.0},      {"--x", 2.0},         {"+x", 2.0},      {"2*-x", -4.0},
      {"x*y+z", 11.0},   {"x*(y+z)", 16.0},    {"-x^2", -4.0},   {"x^-2", 0.25},
      {"x^y", 8.0},      {"2^x^y", 256.0},     {"x^0", 1.0},     {"sqrt(x*8)", 4.0},
      {"abs(-z)", 5.0},  {"exp(0)", 1.0},      {"log(1)", 0.0},  {"sin(0)+cos(0)", 1.0},
      {"cos(pi)", -1.0}, {" x\t+\n y ", 5.0},  {"1e2", 100.0},   {".5", 0.5},
      {"1.5E+1", 15.0},  {"x^0.5*x^0.5", 2.0}, {"x^3", 8.0},     {"x*x*x", 8.0},
      {"x-x", 0.0},      {"x/x", 1.0},         {"(x+1)^2", 9.0}, {"x^1.5", 2.8284271247461903},
  };
  for (const auto& [text, value] : cases)
    EXPECT_NEAR(value_of(text), value, 1e-14 * std::abs(value) + 1e-15) << text;
}

TEST(Parse, SaysWhatIsWrongAndWhere) {
  const std::pair<const char*, const char*> cases[] = {
      {"", "unexpected end at column 1"},
      {"  ", "unexpected end at column 3"},
      {"x+", "unexpected end at column 3"},
      {"x y", "unexpected \"y\" at column 3"},
      {"2x", "unexpected \"x\" at column 2"},
      {"x)", "unexpected \")\" at column 2"},
      {"(x", "\"(\" is never closed at column 1"},
      {"sin(x", "\"(\" is never closed at column 4"},
      {"x**2", "unexpected \"*\" at column 3"},
      {"sin x", "\"sin\" needs \"(\" at column 5"},
      {"tan(x)", "unknown function \"tan\" (sqrt, sin, cos, exp, log, abs) at column 1"},
      {"1+w", "unknown name \"w\" (x, y, z, pi) at column 3"},
      {"x2", "unknown name \"x2\" (x, y, z, pi) at column 1"},
      {"1e999", "number out of range at column 1"},
      {"x+.", "unexpected \".\" at column 3"},
      {"x,y", "unexpected \",\" at column 2"},
      {"x = 1", "unexpected \"=\" at column 3"},
      {"x^10000", "exponent beyond 1000 at column 2"},
      {"\xc3\xa9", "unexpected character at column 1"},
  };
  for (const auto& [text, fault] : cases) EXPECT_EQ(fault_of(text), fault) << text;
  EXPECT_EQ(fault_of(std::string(5000, 'x')), "longer than 4096 characters at column 4097");
  EXPECT_NE(fault_of(std::string(100, '(') + "x" + std::string(100, ')')).find("nested deeper"),
            std::string::npos);
  EXPECT_NE(fault_of(std::string(4000, '-') + "x").find("nested deeper"), std::string::npos);
  std::string tower = "x";
  for (int i = 0; i < 1000; ++i) tower += "^x";
  EXPECT_NE(fault_of(tower).find("nested deeper"), std::string::npos);
}

TEST(Parse, TheLongestExpressionIsNoTrouble) {
  std::string sum = "x", product = "x", roots = "sqrt(x)";
  while (sum.size() + 4 < kMaxExpressionLength) sum += "+y*x";
  while (product.size() + 4 < kMaxExpressionLength) product += "*(y)";
  while (roots.size() + 10 < kMaxExpressionLength) roots += "*sqrt(x+y)";
  for (const std::string& text : {sum, product, roots}) {
    const Field field(read_expression(text, 1.0), 1.0);
    Vec3 gradient;
    Mat3 hessian;
    const double g = field.derivatives({0.5, 1.0, 2.0}, gradient, hessian);
    EXPECT_TRUE(std::isfinite(g) && gradient.allFinite() && hessian.allFinite());
    EXPECT_TRUE(field.third_derivative({0.5, 1.0, 2.0}, {1, 0, 0}, {0, 1, 0}).allFinite());
  }
}

// Random strings of what expressions are made of: a fault or a field, never more.
TEST(Parse, AnyTextEndsWell) {
  const char* pieces[] = {"x",    "y", "z",  "1",     "2.5",  "1e300", "-",    "+",    "*",  "/",
                          "^",    "(", ")",  "sqrt(", "sin(", "exp(",  "log(", "abs(", "^2", "^-3",
                          "^0.5", " ", "pi", "\0",    "\xff", "e",     ".",    "1000"};
  Random random(1);
  int sound = 0;
  for (int i = 0; i < 3000; ++i) {
    std::string text;
    for (int n = 1 + random.index(14); n > 0; --n) text += pieces[random.index(std::size(pieces))];
    const Expression e = read_expression(text, 1.0);
    if (!e.fault.empty()) continue;
    ++sound;
    const Field field(e, 1.0);
    Vec3 gradient;
    Mat3 hessian;
    field.derivatives(random.in_cube(2.0), gradient, hessian);
    SurfaceEnclosure enclosure;
    field.enclose(intervals(Box::around(random.in_cube(2.0), 0.5)), enclosure);
    EXPECT_FALSE(std::isinf(enclosure.g.lo) && enclosure.g.lo > 0.0);
  }
  EXPECT_GT(sound, 50);
}

// ---- Values and derivatives against differences in 50 digits
// -------------------------------------

const char* const kFields[] = {
    "x^2+y^2+z^2-1",
    "x^4+y^4+z^4-x^2-y^2-z^2",
    "(x^2+y^2+z^2+0.75)^2-4*(x^2+y^2)",
    "(sqrt(x^2+y^2)-1)^2+z^2-0.04",
    "z-0.1*sin(2*pi*x)",
    "x*y*z-0.1/(1+x^2)",
    "exp(-x^2-2*y^2)*cos(3*z)-log(3+x)",
    "x^7-3*y^5*z+abs(x-y)-z^-2",
    "(2+x)^2.5+(3+y)^(-0.3)-(1.5+z)^x",
    "sin(cos(x*y)+sqrt(2+sin(z)))/(2+exp(y*z))",
    "(x-y)^3*(x+y)^2-(2*x-3*z)^4/7",
    "1",
};

const Real kSmall("1e-9");

RealPoint moved(const Point& x, const Vec3& u, const Real& a, const Vec3& v, const Real& b) {
  return {Real(x[0]) + a * u[0] + b * v[0], Real(x[1]) + a * u[1] + b * v[1],
          Real(x[2]) + a * u[2] + b * v[2]};
}

// ∂²f/∂u∂v by differences.
template <class F>
Real second(const F& f, const Point& x, const Vec3& u, const Vec3& v, const Real& h) {
  return (f(moved(x, u, h, v, h)) - f(moved(x, u, h, v, -h)) - f(moved(x, u, -h, v, h)) +
          f(moved(x, u, -h, v, -h))) /
         (4 * h * h);
}

TEST(Field, DerivativesEqualDifferencesOfFiftyDigits) {
  Random random(2);
  for (const char* text : kFields) {
    const Field field(read_expression(text, 1.0), 1.0);
    const test::ExpressionOracle<Real> oracle(text);
    for (int i = 0; i < 5; ++i) {
      const Point x = random.in_cube(1.2);
      const Vec3 u = random.in_cube(1.0), v = random.in_cube(1.0);
      Vec3 gradient, same;
      Mat3 hessian;
      const double g = field.derivatives(x, gradient, hessian);
      const Vec3 third = field.third_derivative(x, u, v);
      const double size = 10.0 + gradient.norm() + hessian.norm() + third.norm();
      EXPECT_EQ(field.value(x), g) << text;
      EXPECT_EQ(field.value_gradient(x, same), g) << text;
      EXPECT_EQ(same, gradient) << text;
      for (int k = 0; k < 3; ++k) {
        const std::array<double, 3> along{g, gradient[k], hessian(k, k)};
        EXPECT_EQ(field.along_axis(x, k), along) << text;
      }
      const RealPoint X = moved(x, u, 0, v, 0);
      EXPECT_NEAR(static_cast<double>(oracle(X)), g, 1e-14 * size) << text;
      for (int a = 0; a < 3; ++a) {
        EXPECT_NEAR(static_cast<double>(oracle.partial(X, a, kSmall)), gradient[a], 2e-14 * size)
            << text;
        for (int b = 0; b < 3; ++b) {
          const Real exact = second(oracle, x, Vec3::Unit(a), Vec3::Unit(b), kSmall);
          EXPECT_NEAR(static_cast<double>(exact), hessian(a, b), 2e-14 * size) << text;
        }
        const auto slope = [&](const RealPoint& p) { return oracle.partial(p, a, kSmall); };
        EXPECT_NEAR(static_cast<double>(second(slope, x, u, v, kSmall)), third[a], 1e-13 * size)
            << text;
      }
    }
  }
}

TEST(Field, ScalesAndUnits) {
  // 2.5 × the expression, in millimetres.
  const Field field(read_expression("x^2+3*y*z-40", 0.001), 2.5);
  EXPECT_NEAR(field.value({0.005, 0.002, 0.004}), 2.5 * (25.0 + 24.0 - 40.0), 1e-12);
  Vec3 gradient;
  field.value_gradient({0.005, 0.002, 0.004}, gradient);
  EXPECT_NEAR(gradient.x(), 2.5 * 10.0 / 0.001, 1e-9);
}

TEST(Field, KnowsItsDegree) {
  const auto quartic = [](const char* t) { return Field(read_expression(t, 1.0), 1.0).quartic(); };
  EXPECT_TRUE(quartic("x^4+y*z-(x*y)^2"));
  EXPECT_TRUE(quartic("x/2+sqrt(2)"));
  EXPECT_FALSE(quartic("x^5"));
  EXPECT_FALSE(quartic("1/x"));
  EXPECT_FALSE(quartic("sqrt(x)"));
  EXPECT_TRUE(Field(read_expression("x*y+z^2", 1.0), 1.0).third_derivative_vanishes());
  EXPECT_FALSE(Field(read_expression("x*y*z", 1.0), 1.0).third_derivative_vanishes());
}

TEST(Field, TheSameAlongARay) {
  Random random(3);
  for (const char* text : kFields) {
    const Field field(read_expression(text, 1.0), 0.7);
    const Ray ray{random.in_cube(0.5), random.in_cube(0.5)};
    const double t = random.uniform(-0.5, 0.5), size = 1e-12;
    std::array<double, 4> out;
    field.along(ray, t, 3, out.data());
    Vec3 gradient;
    Mat3 hessian;
    const Vec3& d = ray.direction;
    EXPECT_NEAR(out[0], field.derivatives(ray.at(t), gradient, hessian), size);
    EXPECT_NEAR(out[1], gradient.dot(d), size);
    EXPECT_NEAR(out[2], d.dot(hessian * d), 10.0 * size);
    EXPECT_NEAR(out[3], field.third_derivative(ray.at(t), d, d).dot(d), 100.0 * size);
    if (field.quartic()) {
      EXPECT_NEAR(field.polynomial(ray)(t), out[0], size) << text;
    }
  }
}

TEST(Field, EnclosuresHoldTheExactValues) {
  Random random(4);
  for (const char* text : kFields) {
    const Field field(read_expression(text, 1.0), 1.0);
    const test::ExpressionOracle<Real> oracle(text);
    for (int i = 0; i < 40; ++i) {
      const double half = random.log_uniform(1e-9, 1.0);
      const Point middle = random.in_cube(1.0);
      SurfaceEnclosure e;
      Interval g;
      IntervalVec3 slope;
      const IntervalVec3 box = intervals(Box::around(middle, half));
      const bool defined = field.enclose(box, e);
      field.enclose(box, g, slope);
      // Which sums are one step with their products differs between programs, and with it the last
      // bit.
      const auto same = [](double a, double b) {
        return a == b || std::abs(a - b) < 1e-13 * (1.0 + std::abs(a));
      };
      EXPECT_TRUE(same(g.lo, e.g.lo)) << g.lo << " " << e.g.lo;
      EXPECT_TRUE(same(slope[1].hi, e.gradient[1].hi)) << slope[1].hi << " " << e.gradient[1].hi;
      for (int k = 0; k < 4; ++k) {
        const Point x = middle + random.in_cube(half);
        const Real exact = oracle(moved(x, x, 0, x, 0));
        if (exact != exact) {
          EXPECT_FALSE(defined) << text;
          continue;
        }
        EXPECT_TRUE(Real(e.g.lo) <= exact && exact <= Real(e.g.hi))
            << text << " " << e.g.lo << " " << e.g.hi << " " << exact;
        Vec3 gradient;
        Mat3 hessian;
        field.derivatives(x, gradient, hessian);
        const double slack = 1e-13 * (10.0 + gradient.norm() + hessian.norm());
        for (int a = 0; a < 3; ++a) {
          EXPECT_TRUE(
              Interval(e.gradient[a].lo - slack, e.gradient[a].hi + slack).contains(gradient[a]))
              << text;
        }
        for (int a = 0; a < 6; ++a) {
          const auto [row, column] = kPackedIndices[a];
          EXPECT_TRUE(Interval(e.hessian[a].lo - slack, e.hessian[a].hi + slack)
                          .contains(hessian(row, column)))
              << text;
        }
      }
    }
  }
}

TEST(Field, KinksAndEndsOfDomains) {
  const auto enclose = [](const char* text, double lo, double hi, SurfaceEnclosure& e) {
    return Field(read_expression(text, 1.0), 1.0).enclose({Interval(lo, hi), 0.0, 0.0}, e);
  };
  SurfaceEnclosure e;
  EXPECT_TRUE(enclose("abs(x)", -1.0, 2.0, e));
  EXPECT_TRUE(e.gradient[0].contains(Interval(-1.0, 1.0)));
  EXPECT_EQ(e.hessian[0].hi, kInfinity);  // the slope jumps
  EXPECT_TRUE(enclose("abs(x)", 1.0, 2.0, e));
  EXPECT_EQ(e.hessian[0].hi, 0.0);
  for (const char* text : {"sqrt(x)", "log(x)", "1/x", "x^0.5", "x^1.5", "x^(-0.5)", "x^y"}) {
    EXPECT_FALSE(enclose(text, -1.0, 1.0, e)) << text;
    EXPECT_TRUE(enclose(text, 0.5, 1.0, e)) << text;
  }
  EXPECT_FALSE(enclose("sqrt(x)", -2.0, -1.0, e));
  EXPECT_TRUE(e.g.empty());
  EXPECT_TRUE(std::isnan(value_of("sqrt(-x)")));
  EXPECT_TRUE(std::isnan(value_of("1/(x-x)")));
  EXPECT_TRUE(std::isnan(value_of("0*log(-1)")));
}

}  // namespace
}  // namespace caustic::geometry
