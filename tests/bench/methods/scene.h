// The scenes on which methods are compared: examples of the service, which are the public cases.
#pragma once

#include <string>
#include <vector>

#include "solver/optical_system.h"

namespace caustic::bench {

/// A place of one sheet's level curve, from which a method may start that finds none itself.
struct Seed {
  std::size_t level;
  geometry::Point x;  ///< first hit
};

struct Scene {
  std::string name, example;
  solver::OpticalSystem system;
  std::vector<double> levels;  ///< W/m²
  std::vector<Seed> seeds;     ///< one on each curve of each sheet
  double truth_chord;          ///< to which true curves are drawn, in widths of the window
  bool one_sheet;              ///< nowhere in the window does light arrive by two ways, or none

  double width() const { return system.receiver().width(); }
};

const std::vector<std::string>& scene_names();
Scene make_scene(const std::string& name);

}  // namespace caustic::bench
