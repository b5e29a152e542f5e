// The question of `POST /v1/paths`: all paths of some families between two points, with
// derivatives, a prediction, and on request the proof that there are no more. Everything SI.
#pragma once

#include <atomic>
#include <optional>
#include <vector>

#include "solver/find_paths.h"
#include "solver/path_derivatives.h"

namespace caustic::solver {

struct PathsRequest {
  Point from, to;
  std::vector<Family> families;  ///< empty: those of at most `max_bounces` that light from `from` takes
  int max_bounces = 1;
  bool hessians = false;
  bool certify = false;
  std::optional<Vec3> shift;  ///< predict the path to `to` + shift
  double time_limit = 3600.0;  ///< s
  const std::atomic<bool>* cancelled = nullptr;
};

struct PathFound {
  int family_id;
  FamilyPath way;
  double optical_length;
  PathDerivatives derivatives;
  std::optional<PathPrediction> prediction;
};

struct PathsResult {
  std::vector<PathFound> paths;  ///< by family, then by the first hit's coordinates
  bool certified = false;        ///< proven to be all that Fermat's equations have
  std::size_t undecided = 0;     ///< cells or boxes that may hold more
  bool complete = true;          ///< false: out of time, or cancelled; families are missing
};

PathsResult paths_between(const OpticalSystem& system, const PathsRequest& request);

}  // namespace caustic::solver
