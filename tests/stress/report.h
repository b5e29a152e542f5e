// What a run has found, added up, and as the tables of README.md.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace caustic::stress {

/// Of one scene, as a child says it: done, seconds, evaluations, vertices, complete, warned,
/// undecided, codes, refused, asked [check, seconds], findings [check, text].
class Report {
 public:
  /// `request` of a scene that failed is printed, and kept in `folder` if that is not empty.
  Report(std::ostream& out, std::string folder) : out_(out), folder_(std::move(folder)) {}

  void add(std::uint64_t k, const nlohmann::json& outcome, const nlohmann::json& request);
  /// A check that takes too long is nobody's failure; all else is.
  void died(std::uint64_t k, const std::string& why, const nlohmann::json& request);
  void print() const;
  /// Scenes in which something failed that no warning announced.
  int failed() const { return failed_; }

 private:
  struct Slow {
    double seconds;
    std::uint64_t k, evaluations;
    std::string what;
  };
  struct Count {
    int asked = 0, failed = 0, warned = 0;
    double seconds = 0.0;
  };

  void keep(std::uint64_t k, const std::string& check, const std::string& text, bool warned,
            const nlohmann::json& request);

  std::ostream& out_;
  std::string folder_;
  int scenes_ = 0, refused_ = 0, unchecked_ = 0, empty_ = 0, incomplete_ = 0, warned_ = 0,
      failed_ = 0;
  double seconds_ = 0.0;
  std::uint64_t evaluations_ = 0, vertices_ = 0;
  std::map<std::string, Count> checks_;
  std::map<std::string, int> codes_;
  std::vector<Slow> slow_;
};

}  // namespace caustic::stress
