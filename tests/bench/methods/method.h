// A method that draws level curves, and what it draws. Each is a small program of its own kind;
// they share the scene, the irradiance and the judge, nothing else.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "solver/contours.h"
#include "tests/bench/methods/scene.h"
#include "tests/support/curve_distance.h"

namespace caustic::bench {

struct Drawing {
  std::vector<std::vector<test::Line>> levels;  ///< of each level of the scene, receiver axes, m
  std::uint64_t evaluations = 0;  ///< of the map x ↦ q, readings of the meter, photons
  std::string remark;             ///< what went wrong
};

struct Method {
  std::string name;
  /// What it draws: curves of each sheet, or edges of what a meter reads.
  solver::Measure measure;
  /// What it can be told, from coarse to fine: a chord or a step in widths of the window, points of
  /// a grid along a side, photons.
  std::vector<double> settings;
  std::function<Drawing(const Scene&, double setting)> draw;
  /// Scenes of its own kind; all if null.
  std::function<bool(const Scene&)> suits = nullptr;
  /// Empty if it can run here, else why not.
  std::string missing = {};
};

std::vector<Method> our_methods();
std::vector<Method> grid_methods();
std::vector<Method> chen_methods();
std::vector<Method> photon_methods();
std::vector<Method> povray_methods();

}  // namespace caustic::bench
