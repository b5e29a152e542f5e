#include "solver/paths_between.h"

#include "solver/itineraries.h"

#include "solver/certify_paths.h"

namespace caustic::solver {

namespace {

// Proven roots and those of the search nearer than this share of the scene are the same.
constexpr double kSamePath = 1e-8;

bool contains(const std::vector<FamilyPath>& paths, const FamilyPath& one, double scale) {
  for (const FamilyPath& other : paths) {
    double distance = 0.0;
    for (std::size_t i = 0; i < one.path.hops(); ++i) {
      distance = std::max(distance, (one.path.x[i] - other.path.x[i]).norm());
    }
    if (distance <= kSamePath * scale) return true;
  }
  return false;
}

// Proven roots that apertures and visibility let through. Where something stays undecided, what the
// search finds is added: a path that is known is not left out because it is not proven.
std::vector<FamilyPath> certified_paths(const OpticalSystem& system, const Family& family,
                                        PathFinder& finder, const PathsRequest& request,
                                        Budget& budget, PathsResult& result) {
  std::vector<geometry::Box> regions;
  for (const int surface : family) regions.push_back(system.surfaces()[surface].region);
  const auto proven = certify_paths(finder.tracer().surfaces(), regions, finder.tracer().light(),
                                    request.to, system.diameter(), {.budget = &budget});
  result.undecided += proven.undecided;
  std::vector<FamilyPath> paths;
  for (const auto& root : proven.roots) {
    const PolishResult sharp =
        polish(finder.tracer().chain(root), {request.from, request.to, root, {}});
    if (auto path = finder.admit(sharp.converged ? sharp.path.x : root, request.to)) {
      paths.push_back(*std::move(path));
    }
  }
  if (proven.undecided > 0) {
    for (FamilyPath& path : finder.to(request.to).paths) {
      if (!contains(paths, path, system.diameter())) paths.push_back(std::move(path));
    }
  }
  sort_paths(paths);
  return paths;
}

}  // namespace

PathsResult paths_between(const OpticalSystem& system, const PathsRequest& request) {
  PathsResult result;
  Budget budget(request.time_limit, 0, request.cancelled);
  auto families = request.families;
  if (families.empty()) {
    families = families_up_to(system.with_light(PointLight{request.from, 1.0}), request.max_bounces,
                              Arrival::anywhere);
  }
  for (int id = 0; id < static_cast<int>(families.size()) && !budget.out_of_time(); ++id) {
    PathFinder finder(system, families[id], PointLight{request.from, 1.0});
    std::vector<FamilyPath> paths;
    if (request.certify) {
      paths = certified_paths(system, families[id], finder, request, budget, result);
    } else {
      auto answer = finder.to(request.to);
      paths = std::move(answer.paths);
      result.undecided += answer.undecided;
    }
    for (FamilyPath& way : paths) {
      PathFound found{id, std::move(way), 0.0, {}, {}};
      const auto& chain = found.way.chain;
      auto& path = found.way.path;
      // The search has made the ray meet `to`; Fermat's system ties the points together to the last
      // digit.
      PolishResult sharp = polish(chain, path);
      if (sharp.converged) path = std::move(sharp.path);
      fit_multipliers(chain, path);
      found.optical_length = optical_length(chain, path);
      found.derivatives =
          path_derivatives(chain, path, request.hessians || request.shift.has_value());
      if (request.shift && found.derivatives.finite) {
        found.prediction = perturb(chain, path, found.derivatives, *request.shift);
      }
      result.paths.push_back(std::move(found));
    }
  }
  result.complete = !budget.out_of_time();
  result.certified = result.complete && request.certify && result.undecided == 0;
  return result;
}

}  // namespace caustic::solver
