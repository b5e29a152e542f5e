// The 50-digit numbers of the references, for those of them that live in files of their own.
#pragma once

#include <array>
#include <boost/multiprecision/cpp_bin_float.hpp>

#include "tests/support/shape_zoo.h"

namespace caustic::test {

using Real = boost::multiprecision::number<boost::multiprecision::cpp_bin_float<50>,
                                           boost::multiprecision::et_off>;

struct RealImplicit {
  Real value;
  std::array<Real, 3> gradient;
};
/// g (or any multiple of it) and its gradient.
RealImplicit reference_implicit(const ShapeSpec& spec, const std::array<Real, 3>& x);

/// The same with 64 bits of mantissa, for what is asked often.
struct LongImplicit {
  long double value;
  std::array<long double, 3> gradient;
};
LongImplicit reference_implicit(const ShapeSpec& spec, const std::array<long double, 3>& x);

}  // namespace caustic::test
