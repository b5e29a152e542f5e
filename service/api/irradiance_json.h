// `POST /v1/irradiance` and `isocaustic irradiance`: where to measure, and what was read there.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "service/api/units.h"
#include "solver/point_irradiance.h"

namespace caustic::service {

/// Points of one call: their answers are held in memory.
constexpr int kMaxPoints = 100'000;

struct IrradianceCall {
  solver::OpticalSystem system;
  std::vector<solver::Family> families;
  bool direct = false;
  std::vector<geometry::Vec2> points;  ///< receiver axes, m
  Units units;
};

/// Throws ProblemError: 400 if the text is not JSON, 422 naming every fault of what it says.
IrradianceCall read_irradiance_call(std::string_view body);

/// `readings` in the order of the call's points.
std::string irradiance_answer(const IrradianceCall& call,
                              const std::vector<solver::PointIrradiance>& readings);

}  // namespace caustic::service
