// Third derivatives from a frame of their own to the world.
#pragma once

#include "geometry/enclosure.h"

namespace caustic::geometry {

/// Σ m_ai m_bj m_ck T_ijk, the columns of m being the axes of the frame.
inline IntervalSym333 rotated(const IntervalSym333& T, const Mat3& m) {
  IntervalSym333 out;
  for (int a = 0; a < 3; ++a) {
    for (int b = a; b < 3; ++b) {
      for (int c = b; c < 3; ++c) {
        Interval sum(0.0);
        for (int n = 0; n < 27; ++n) {
          const int i = n / 9, j = n / 3 % 3, k = n % 3;
          const double share = m(a, i) * m(b, j) * m(c, k);
          if (share != 0.0) sum += share * T[packed_index(i, j, k)];
        }
        out[packed_index(a, b, c)] = sum;
      }
    }
  }
  return out;
}

}  // namespace caustic::geometry
