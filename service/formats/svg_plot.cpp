#include "service/formats/svg_plot.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace caustic::service {
namespace {

/// Eighths of matplotlib's cividis.
constexpr double kCividis[9][3] = {{0, 34, 78},     {18, 53, 112},   {59, 73, 108},
                                   {87, 93, 109},   {112, 113, 115}, {138, 134, 120},
                                   {165, 156, 116}, {195, 179, 105}, {225, 204, 85}};

std::string chars(double value, std::chars_format format, int precision) {
  char buffer[64];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, format, precision).ptr;
  return {buffer, end};
}

}  // namespace

SvgPlot::SvgPlot(const std::array<double, 2>& size)
    : scale_(kLongSide / std::max(size[0], size[1])),
      width_(scale_ * size[0]),
      height_(scale_ * size[1]) {}

Pixel SvgPlot::pixel(const std::array<double, 2>& uv) const {
  return {kLeft + 0.5 * width_ + scale_ * uv[0], kTop + 0.5 * height_ - scale_ * uv[1]};
}

double SvgPlot::page_height(int legend_rows) const {
  return std::max(kTop + height_ + kBottom, kTop + 22.0 * (legend_rows + 3));
}

bool SvgPlot::contains(const Pixel& p, double margin) const {
  return p.x > kLeft + margin && p.x < kLeft + width_ - margin && p.y > kTop + margin &&
         p.y < kTop + height_ - margin;
}

std::vector<double> ticks(double half) {
  const double rough = half / 3.0;
  const double decade = std::pow(10.0, std::floor(std::log10(rough)));
  const double step = decade * (rough < 2 * decade ? 1 : rough < 5 * decade ? 2 : 5);
  std::vector<double> out;
  const int most = static_cast<int>(std::floor(half / step * (1 + 1e-12)));
  for (int i = -most; i <= most; ++i) out.push_back(i * step);
  return out;
}

std::string label_text(double value) {
  const double size = std::abs(value);
  if (size != 0 && (size < 1e-4 || size >= 1e6)) return chars(value, std::chars_format::general, 4);
  // Plain digits: 0.0005 reads better than 5e-04.
  const int digits =
      size == 0 ? 0 : std::max(0, 3 - static_cast<int>(std::floor(std::log10(size))));
  std::string text = chars(value, std::chars_format::fixed, digits);
  if (text.find('.') == std::string::npos) return text;
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

std::string pixel_text(double value) {
  std::string text = chars(value, std::chars_format::fixed, 2);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

std::string level_color(double share) {
  const double at = 8.0 * std::clamp(share, 0.0, 1.0);
  const int i = std::min(7, static_cast<int>(at));
  std::string out = "#";
  for (int c = 0; c < 3; ++c) {
    const double mixed = kCividis[i][c] + (at - i) * (kCividis[i + 1][c] - kCividis[i][c]);
    const int value = static_cast<int>(std::lround(mixed));
    out += "0123456789abcdef"[value >> 4];
    out += "0123456789abcdef"[value & 15];
  }
  return out;
}

}  // namespace caustic::service
