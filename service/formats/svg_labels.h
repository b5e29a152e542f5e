// Where the level is written on a curve: on straight, free stretches, upright, never over another
// label.
#pragma once

#include <vector>

#include "service/formats/svg_plot.h"

namespace caustic::service {

struct SvgLabel {
  Pixel at;
  double degrees;  ///< of the text, clockwise as SVG turns
};

/// Places labels one after another; remembers where there are some.
class SvgLabelPlacer {
 public:
  explicit SvgLabelPlacer(const SvgPlot& plot) : plot_(plot) {}

  /// Labels for a curve that runs through these pixels: none if it is too short or there is no
  /// room.
  std::vector<SvgLabel> place(const std::vector<Pixel>& line, double text_width);

 private:
  bool is_free(const Pixel& p, double text_width) const;

  const SvgPlot& plot_;
  std::vector<Pixel> taken_;
};

}  // namespace caustic::service
