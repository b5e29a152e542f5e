// What must hold of every answer. A check returns what is wrong, or nothing.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "solver/analysis.h"
#include "tests/stress/oracle.h"
#include "tests/stress/trial.h"

namespace caustic::stress {

struct Subject {
  const Trial& trial;
  const Oracle& oracle;
  std::uint64_t seed;
  int effort = 1;                      ///< multiplies how many places are looked at
  double until = geometry::kInfinity;  ///< CPU time of this thread: no further place after it
};
bool late(const Subject& subject);

using Finding = std::optional<std::string>;
using Check = Finding (*)(const Subject&);

struct NamedCheck {
  const char* name;
  Check run;
  int one_in;  ///< of so many scenes one is asked
  bool heavy;  ///< looks for paths anew, or traces again: a suite asks it of fewer
};
/// In the order in which a reader wants to see what failed.
const std::vector<NamedCheck>& checks();

// One file each but for the short ones.
Finding check_finite(const Subject&);     ///< no NaN in the answer, none in a file
Finding check_time(const Subject&);       ///< the request's own limit was kept
Finding check_vertices(const Subject&);   ///< q, E, parity and reflector point in 50 digits
Finding check_gradients(const Subject&);  ///< ∇E against differences in 50 digits
Finding check_chords(const Subject&);     ///< the true curve runs along the polyline
Finding check_once(const Subject&);       ///< no curve of a sheet lies on another
Finding check_seen(const Subject&);       ///< nothing is in the way inside of a curve
Finding check_ends(const Subject&);       ///< stepping past an end meets what it is named after
Finding check_rings(const Subject&);      ///< arcs of a total close head to tail
Finding check_meter(const Subject&);      ///< arcs and jumps against all paths, found anew
Finding check_inside(const Subject&);     ///< random places are inside where a meter reads more
Finding check_rays(const Subject&);    ///< random rays of the light find no curve that is missing
Finding check_moved(const Subject&);   ///< turned and shifted
Finding check_scaled(const Subject&);  ///< in another unit
Finding check_mirrored(const Subject&);
Finding check_permuted(const Subject&);  ///< surfaces in another order
Finding check_analysis(const Subject&);  ///< estimates hold for random readings

/// The last one's, of an analysis of the same scene.
Finding wrong_estimates(const Subject& s, const solver::Analysis& analysis);

// What checks share.

std::string name_of(const Trial& trial, std::size_t curve);
const Family& family_of(const Trial& trial, const solver::Curve& curve);
/// At most `count` of n indices, first and last among them.
std::vector<std::size_t> spread_over(std::size_t n, std::size_t count);
std::string text(const char* format, ...) __attribute__((format(printf, 1, 2)));

}  // namespace caustic::stress
