#include "service/api/json_reader.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "service/api/json_text.h"

namespace caustic::service {
namespace {

using nlohmann::json;

/// One step of an RFC 6901 pointer.
std::string escaped(std::string_view key) {
  std::string out;
  for (char c : key) {
    if (c == '~')
      out += "~0";
    else if (c == '/')
      out += "~1";
    else
      out += c;
  }
  return out;
}

std::string number_text(double value) {
  std::string out;
  append_number(out, value);
  return out;
}

std::string list_of(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : ", ") + word;
  return out;
}

}  // namespace

void Faults::add(const std::string& pointer, std::string detail) {
  if (++count_ <= kMaxListed) faults_.push_back({pointer, std::move(detail)});
}

void Faults::not_supported(const std::string& pointer, const std::string& what) {
  add(pointer, what + ": not supported by this version");
}

void Faults::throw_if_any() const {
  if (none()) return;
  std::string detail = std::to_string(count_) + (count_ == 1 ? " fault" : " faults");
  if (count_ > kMaxListed) detail += ", the first " + std::to_string(kMaxListed) + " are listed";
  throw ProblemError(make_problem(422, detail + " in the request", faults_));
}

bool Range::contains(double value) const {
  return (open_min ? value > min : value >= min) && (open_max ? value < max : value <= max);
}

std::string Range::text() const {
  return std::string("must be ") + (open_min ? "> " : ">= ") + number_text(min) + " and " +
         (open_max ? "< " : "<= ") + number_text(max);
}

double read_number(const JsonPlace& place, const Range& range, Faults& faults) {
  const double harmless = range.contains(1.0) ? 1.0 : 0.5 * (range.min + range.max);
  if (!place.value->is_number()) {
    faults.add(place.pointer, "must be a number");
    return harmless;
  }
  const double value = place.value->get<double>();
  if (range.contains(value)) return value;
  const bool sign_only = range.min == kPositive.min && value <= 0.0;
  faults.add(place.pointer, sign_only ? "must be > 0" : range.text());
  return harmless;
}

int read_integer(const JsonPlace& place, int min, int max, Faults& faults) {
  const double value =
      read_number(place, {static_cast<double>(min), static_cast<double>(max)}, faults);
  if (value == std::floor(value)) return static_cast<int>(value);
  faults.add(place.pointer, "must be a whole number");
  return min;
}

std::string read_string(const JsonPlace& place, Faults& faults) {
  if (place.value->is_string()) return place.value->get<std::string>();
  faults.add(place.pointer, "must be a string");
  return {};
}

std::vector<double> read_numbers(const JsonPlace& place, std::size_t count, const Range& range,
                                 Faults& faults) {
  std::vector<double> out(count, 1.0);
  if (!place.value->is_array() || place.value->size() != count) {
    faults.add(place.pointer, "must be an array of " + std::to_string(count) + " numbers");
    return out;
  }
  for (std::size_t i = 0; i < count; ++i)
    out[i] =
        read_number({&(*place.value)[i], place.pointer + '/' + std::to_string(i)}, range, faults);
  return out;
}

std::vector<JsonPlace> read_elements(const JsonPlace& place, std::size_t most, Faults& faults) {
  std::vector<JsonPlace> out;
  if (!place.value->is_array()) {
    faults.add(place.pointer, "must be an array");
  } else if (place.value->size() > most) {
    faults.add(place.pointer, "more than " + std::to_string(most) + " elements");
  } else {
    for (std::size_t i = 0; i < place.value->size(); ++i)
      out.push_back({&(*place.value)[i], place.pointer + '/' + std::to_string(i)});
  }
  return out;
}

ObjectReader::ObjectReader(JsonPlace place, Faults& faults)
    : place_(std::move(place)), faults_(faults), is_object_(place_.value->is_object()) {
  if (!is_object_) faults_.add(place_.pointer, "must be an object");
}

ObjectReader::~ObjectReader() {
  if (!is_object_ || ignore_unknown_) return;
  for (const auto& [key, value] : place_.value->items())
    if (!known_.contains(key)) faults_.add(pointer_to(key), "unknown key");
}

std::string ObjectReader::pointer_to(std::string_view key) const {
  return place_.pointer + '/' + escaped(key);
}

std::optional<JsonPlace> ObjectReader::optional_member(const std::string& key) {
  known_.insert(key);
  if (!is_object_) return std::nullopt;
  const auto member = place_.value->find(key);
  if (member == place_.value->end()) return std::nullopt;
  return JsonPlace{&*member, pointer_to(key)};
}

std::optional<JsonPlace> ObjectReader::member(const std::string& key) {
  auto place = optional_member(key);
  if (!place && is_object_) faults_.add(pointer_to(key), "missing");
  return place;
}

JsonPlace ObjectReader::member_or(const std::string& key, json value) {
  if (auto place = optional_member(key)) return *place;
  static thread_local json nowhere;  // an object that is none has been reported already
  json& slot = is_object_ ? (*place_.value)[key] : nowhere;
  slot = std::move(value);
  return {&slot, pointer_to(key)};
}

double ObjectReader::number(const std::string& key, const Range& range) {
  const auto place = member(key);
  return place ? read_number(*place, range, faults_) : 1.0;
}

double ObjectReader::number_or(const std::string& key, const Range& range, double value) {
  return read_number(member_or(key, value), range, faults_);
}

std::string ObjectReader::word_at(const JsonPlace& place, const std::vector<std::string>& words) {
  if (place.value->is_string()) {
    const auto found = std::find(words.begin(), words.end(), place.value->get<std::string>());
    if (found != words.end()) return *found;
  }
  faults_.add(place.pointer, "must be one of: " + list_of(words));
  return {};
}

std::string ObjectReader::word(const std::string& key, const std::vector<std::string>& words) {
  const auto place = member(key);
  return place ? word_at(*place, words) : std::string();
}

std::string ObjectReader::word_or(const std::string& key, const std::vector<std::string>& words,
                                  const std::string& value) {
  return word_at(member_or(key, value), words);
}

bool ObjectReader::boolean_or(const std::string& key, bool value) {
  const JsonPlace place = member_or(key, value);
  if (place.value->is_boolean()) return place.value->get<bool>();
  faults_.add(place.pointer, "must be true or false");
  return value;
}

geometry::Vec3 ObjectReader::vector(const std::string& key, const Range& range) {
  const auto place = member(key);
  if (!place) return geometry::Vec3::Ones();
  const auto values = read_numbers(*place, 3, range, faults_);
  return {values[0], values[1], values[2]};
}

geometry::Direction ObjectReader::direction(const std::string& key) {
  const geometry::Vec3 value = vector(key);
  const double largest =
      value.cwiseAbs().maxCoeff();  // scaled first: a tiny vector has a direction
  if (largest > 0.0) return (value / largest).normalized();
  faults_.add(pointer_to(key), "must not be the zero vector");
  return geometry::Direction::UnitZ();
}

geometry::Vec2 ObjectReader::pair(const std::string& key, const Range& range) {
  const auto place = member(key);
  if (!place) return geometry::Vec2::Ones();
  const auto values = read_numbers(*place, 2, range, faults_);
  return {values[0], values[1]};
}

std::vector<JsonPlace> ObjectReader::elements(const std::string& key, std::size_t most) {
  const auto place = member(key);
  return place ? read_elements(*place, most, faults_) : std::vector<JsonPlace>();
}

}  // namespace caustic::service
