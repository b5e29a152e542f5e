// Typed reading of a JSON document that notes every fault with its pointer instead of stopping at
// the first. Defaults are written into the document as they are taken, unknown members are faults:
// after a faultless reading the document is the canonical request.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "geometry/linear.h"
#include "service/api/problem.h"

namespace caustic::service {

/// The faults found so far.
class Faults {
 public:
  void add(const std::string& pointer, std::string detail);
  void not_supported(const std::string& pointer, const std::string& what);
  std::size_t count() const { return count_; }
  bool none() const { return count_ == 0; }
  /// Throws ProblemError (422) naming all of them.
  void throw_if_any() const;

 private:
  /// An answer names at most this many; a body of megabytes could hold a million.
  static constexpr std::size_t kMaxListed = 1000;
  std::vector<Fault> faults_;
  std::size_t count_ = 0;
};

/// Where a number may lie.
struct Range {
  double min, max;
  bool open_min = false, open_max = false;  ///< the end itself is out

  bool contains(double value) const;
  std::string text() const;  ///< "must be > 0 and <= 1"
};

/// Magnitudes that leave room for the fifth powers that tracing takes.
constexpr double kMaxMagnitude = 1e30;
constexpr Range kAnyNumber{-kMaxMagnitude, kMaxMagnitude};
constexpr Range kPositive{1e-30, kMaxMagnitude};
/// A direction this close to another (sine of the angle) leaves no plane between the two.
constexpr double kParallelSine = 1e-9;

/// A value and where it stands.
struct JsonPlace {
  nlohmann::json* value;
  std::string pointer;
};

/// Readers of single values. A wrong value is noted and a harmless one returned.
double read_number(const JsonPlace& place, const Range& range, Faults& faults);
int read_integer(const JsonPlace& place, int min, int max, Faults& faults);
std::string read_string(const JsonPlace& place, Faults& faults);
/// `count` numbers.
std::vector<double> read_numbers(const JsonPlace& place, std::size_t count, const Range& range,
                                 Faults& faults);

/// Reads the members of one object. Whatever was not asked for when it ends is an unknown key.
class ObjectReader {
 public:
  ObjectReader(JsonPlace place, Faults& faults);
  ~ObjectReader();
  ObjectReader(const ObjectReader&) = delete;
  ObjectReader& operator=(const ObjectReader&) = delete;

  Faults& faults() { return faults_; }
  const std::string& pointer() const { return place_.pointer; }
  std::string pointer_to(std::string_view key) const;

  /// The member, noted as missing if it is not there.
  std::optional<JsonPlace> member(const std::string& key);
  /// The member, or nothing.
  std::optional<JsonPlace> optional_member(const std::string& key);
  /// The member, set to `value` first if it is not there.
  JsonPlace member_or(const std::string& key, nlohmann::json value);

  double number(const std::string& key, const Range& range);
  double number_or(const std::string& key, const Range& range, double value);
  /// One of `words`; the fault names them all. Empty if it is none of them.
  std::string word(const std::string& key, const std::vector<std::string>& words);
  std::string word_or(const std::string& key, const std::vector<std::string>& words,
                      const std::string& value);
  bool boolean_or(const std::string& key, bool value);
  geometry::Vec3 vector(const std::string& key, const Range& range = kAnyNumber);
  /// A vector other than zero, made a unit vector.
  geometry::Direction direction(const std::string& key);
  geometry::Vec2 pair(const std::string& key, const Range& range);
  /// Elements of an array; empty, with its fault, if it is not one or longer than `most`.
  std::vector<JsonPlace> elements(const std::string& key, std::size_t most);

  /// Do not report members that this reader does not know.
  void ignore_the_rest() { ignore_unknown_ = true; }

 private:
  std::string word_at(const JsonPlace& place, const std::vector<std::string>& words);

  JsonPlace place_;
  Faults& faults_;
  std::set<std::string> known_;
  bool is_object_;
  bool ignore_unknown_ = false;
};

/// Elements of an array value, or a fault.
std::vector<JsonPlace> read_elements(const JsonPlace& place, std::size_t most, Faults& faults);

}  // namespace caustic::service
