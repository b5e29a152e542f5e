#include "solver/rectangle_totals.h"

namespace caustic::solver {

void PossibleTotal::add(const FieldSheet& sheet) {
  sheets.push_back(&sheet);
  E += sheet.over.E;
  slope[0] += sheet.over.E_u;
  slope[1] += sheet.over.E_v;
}

// (S78): of each sheet from there, of one or of two.
void PossibleTotal::add(const NearCaustic& next, unsigned bit) {
  near |= bit;
  E = {(E + next.least).lo, geometry::kInfinity};
  for (std::size_t c = 0; c < 2; ++c) {
    const Interval steep(next.steep[c].least, geometry::kInfinity);
    slope[c] += next.steep[c].sign > 0   ? steep
                : next.steep[c].sign < 0 ? -steep
                                         : Interval::whole();
  }
}

Axes PossibleTotal::monotone() const {
  return static_cast<Axes>((slope[0].contains_zero() ? kNoAxis : kAlongU) |
                           (slope[1].contains_zero() ? kNoAxis : kAlongV));
}

}  // namespace caustic::solver
