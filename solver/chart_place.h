// A place of a chart on a grid of integers, fine enough for what is far smaller than the chart.
#pragma once

#include <cstddef>
#include <cstdint>

namespace caustic::solver {

/// So many halvings of a cell of the base leave a grid cell.
constexpr int kChartDepth = 44;

struct ChartPlace {
  int chart;
  std::int64_t i, j;
  bool operator==(const ChartPlace&) const = default;
};

struct ChartPlaceHash {
  std::size_t operator()(const ChartPlace& p) const {
    // Two odd numbers without pattern; the shift brings the upper bits down, where cells differ.
    const auto mixed = (static_cast<std::uint64_t>(p.i) * 0x9E3779B97F4A7C15u) ^
                       (static_cast<std::uint64_t>(p.j) * 0xC2B2AE3D27D4EB4Fu) ^
                       static_cast<std::uint64_t>(p.chart);
    return static_cast<std::size_t>(mixed ^ (mixed >> 32));
  }
};

}  // namespace caustic::solver
