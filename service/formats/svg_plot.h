// The plane of a diagram: receiver coordinates to pixels, tick marks, colours of levels.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace caustic::service {

/// A place on the page, pixels, y down.
struct Pixel {
  double x, y;
};

/// Maps the receiver (u right, v up, centre 0) to a rectangle whose longer side is `kLongSide`.
class SvgPlot {
 public:
  static constexpr double kLongSide = 720, kLeft = 84, kTop = 56, kBottom = 64, kLegend = 190;

  explicit SvgPlot(const std::array<double, 2>& size);

  Pixel pixel(const std::array<double, 2>& uv) const;
  double width() const { return width_; }  ///< of the receiver on the page
  double height() const { return height_; }
  double page_width() const { return kLeft + width_ + kLegend; }
  double page_height(int legend_rows) const;
  bool contains(const Pixel& p, double margin) const;

 private:
  double scale_, width_, height_;
};

/// Round numbers (1, 2 or 5 times a power of ten apart) in [−half, half], six or so.
std::vector<double> ticks(double half);

/// Four significant digits, as one would write them.
std::string label_text(double value);
/// Pixels, to a hundredth.
std::string pixel_text(double value);

/// Cividis, readable by the colour-blind, from dark (0) to bright (1), short of the yellow that
/// drowns in white paper.
std::string level_color(double share);

}  // namespace caustic::service
