#include "service/api/level_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace caustic::service {
namespace {

using solver::LevelRequest;

/// 1-2-5 numbers between min and max: three a decade.
bool too_many_one_two_five(const LevelRequest& levels) {
  return levels.spacing == LevelRequest::Spacing::one_two_five && levels.min && levels.max &&
         3.0 * std::log10(*levels.max / *levels.min) > static_cast<double>(kMaxLevels) - 3.0;
}

void read_level_rule(const JsonPlace& place, LevelRequest& out, Faults& faults) {
  ObjectReader levels(place, faults);
  out.count = read_integer(levels.member_or("count", 8.0), 1, kMaxLevels, faults);
  const std::string spacing = levels.word_or("spacing", {"log", "linear", "1-2-5"}, "log");
  if (spacing == "linear") out.spacing = LevelRequest::Spacing::linear;
  if (spacing == "1-2-5") out.spacing = LevelRequest::Spacing::one_two_five;
  const std::size_t faults_before = faults.count();
  if (const auto min = levels.optional_member("min"))
    out.min = read_number(*min, kPositive, faults);
  const auto max = levels.optional_member("max");
  if (!max) return;
  out.max = read_number(*max, kPositive, faults);
  if (faults.count() != faults_before) return;
  if (out.min && *out.min >= *out.max)
    faults.add(max->pointer, "must be greater than min");
  else if (too_many_one_two_five(out))
    faults.add(place.pointer, "more than " + std::to_string(kMaxLevels) + " levels");
}

}  // namespace

LevelRequest read_levels(ObjectReader& root) {
  Faults& faults = root.faults();
  LevelRequest out;
  const JsonPlace place = root.member_or("levels", nlohmann::json::object());
  if (place.value->is_object()) {
    read_level_rule(place, out, faults);
    return out;
  }
  if (!place.value->is_array()) {
    faults.add(place.pointer, "must be an array or an object");
    return out;
  }
  for (const JsonPlace& level : read_elements(place, kMaxLevels, faults))
    out.values.push_back(read_number(level, kPositive, faults));
  if (place.value->empty()) faults.add(place.pointer, "needs at least one level");
  return out;
}

}  // namespace caustic::service
