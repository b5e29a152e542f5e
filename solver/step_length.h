// How long a step of the predictor may be: for its error, which grows with the fifth power, and for
// what else limits it. Shared by curves of sheets and arcs of totals.
#pragma once

#include <algorithm>
#include <cmath>

namespace caustic::solver {

class StepLength {
 public:
  explicit StepLength(double first = 0.0) : length_(first) {}

  double now() const { return length_; }
  /// A step that could not be made; a shorter one is to be tried.
  void failed() { length_ *= kFailed; }
  /// A step with this error was made. `room` says how many times as long it could have been by its
  /// other limits. True if it stands; the next, or the same again if it does not, has a new length.
  bool judge(double error, double allowed, double room) {
    const double by_error = kSafety * std::pow(allowed / std::max(error, kLeastError), 0.2);
    const double factor = std::clamp(std::min(by_error, kSafety * room), kShorter, kLonger);
    const bool stands = error <= allowed && room >= 1.0;
    length_ *= stands ? factor : std::min(factor, kSafety);
    return stands;
  }

  /// Room for a turn, rad, and a motion, each with its limit.
  static double room(double turn, double most_turn, double motion, double most_motion) {
    return 1.0 / std::max({turn / most_turn, motion / most_motion, kMostRoomInverse});
  }

 private:
  // A length is at most this share of what its limits allow, lest it be tried in vain, and changes
  // by no more than these factors at once.
  static constexpr double kSafety = 0.9, kShorter = 0.2, kLonger = 3.0, kFailed = 0.25;
  static constexpr double kLeastError = 1e-300, kMostRoomInverse = 1e-3;  // no division by zero

  double length_;
};

}  // namespace caustic::solver
