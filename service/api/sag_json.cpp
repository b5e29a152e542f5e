#include "service/api/sag_json.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "geometry/sag.h"

namespace caustic::service {
namespace {

using geometry::HeightGrid;
using geometry::Vec2;
using geometry::Vec3;
using geometry::XyPolynomial;
using nlohmann::json;

constexpr std::size_t kMaxTerms = 1000;
constexpr std::size_t kMaxSamples = 4096;  // each way

geometry::Mat3 read_axes(ObjectReader& shape, const geometry::Pose& pose) {
  const std::size_t faults_before = shape.faults().count();
  const Vec3 x = shape.direction("x_axis"), y = shape.direction("y_axis");
  const Vec3 z = x.cross(y);
  if (z.norm() < kParallelSine) {
    if (shape.faults().count() == faults_before)
      shape.faults().add(shape.pointer_to("y_axis"), "must not be parallel to x_axis");
    return geometry::Mat3::Identity();
  }
  geometry::Mat3 axes;
  axes.col(0) = x;
  axes.col(2) = z.normalized();
  axes.col(1) = axes.col(2).cross(x);
  return pose.rotation * axes;
}

// c is a length per unit^(i + j).
XyPolynomial read_xy_polynomial(ObjectReader& shape, double metres) {
  XyPolynomial f;
  for (const JsonPlace& place : shape.elements("terms", kMaxTerms)) {
    ObjectReader term(place, shape.faults());
    const auto exponent = [&](const char* key) {
      const auto member = term.member(key);
      return member ? read_integer(*member, 0, XyPolynomial::kMaxDegree, shape.faults()) : 0;
    };
    const int i = exponent("i"), j = exponent("j");
    const double c = term.number("c", kAnyNumber);
    if (i + j > XyPolynomial::kMaxDegree) {
      shape.faults().add(place.pointer,
                         "i + j must be at most " + std::to_string(XyPolynomial::kMaxDegree));
    } else {
      f.add(i, j, c * std::pow(metres, 1 - i - j));
    }
  }
  return f;
}

// Members of `coefficients` by the index of their polynomial, lengths.
XyPolynomial read_zernike(ObjectReader& shape, double metres) {
  const double norm_radius = metres * shape.number("norm_radius", kPositive);
  const auto place = shape.member("coefficients");
  if (!place) return XyPolynomial();
  ObjectReader coefficients(*place, shape.faults());
  coefficients.ignore_the_rest();
  std::vector<std::pair<int, double>> sum;
  if (place->value->is_object()) {
    for (const auto& [key, value] : place->value->items()) {
      int index = -1;
      const auto [end, error] = std::from_chars(key.data(), key.data() + key.size(), index);
      const bool is_index = error == std::errc() && std::to_string(index) == key && index >= 0 &&
                            index <= geometry::kMaxZernikeIndex;
      if (is_index) {
        sum.push_back({index, metres * coefficients.number(key, kAnyNumber)});
      } else {
        shape.faults().add(coefficients.pointer_to(key),
                           "not an index of Zernike's polynomials from 0 to " +
                               std::to_string(geometry::kMaxZernikeIndex));
      }
    }
  }
  return geometry::zernike(sum, norm_radius);
}

// Both ends of the samples' range.
Vec2 read_range(ObjectReader& shape, const char* key, double metres) {
  const std::size_t faults_before = shape.faults().count();
  const Vec2 range = shape.pair(key, kAnyNumber);
  if (shape.faults().count() == faults_before && !(range.x() < range.y()))
    shape.faults().add(shape.pointer_to(key), "must increase");
  return metres * range;
}

bool fits(const json& array) {
  return array.is_array() && array.size() >= std::size_t(geometry::kMinSamples) &&
         array.size() <= kMaxSamples;
}

// values[j][i] at the i-th x and the j-th y. A pointer is made for faults only: there may be a
// million samples.
HeightGrid read_heights(ObjectReader& shape, double metres) {
  const Vec2 x = read_range(shape, "x", metres), y = read_range(shape, "y", metres);
  HeightGrid grid{{x.x(), y.x()}, {x.y(), y.y()}, 0, 0, {}};
  const auto place = shape.member("values");
  if (!place) return grid;
  json& rows = *place->value;
  const std::string size =
      "from " + std::to_string(geometry::kMinSamples) + " to " + std::to_string(kMaxSamples);
  if (!fits(rows)) {
    shape.faults().add(place->pointer, "must be an array of " + size + " rows");
    return grid;
  }
  if (!fits(rows[0])) {
    shape.faults().add(place->pointer + "/0", "must be an array of " + size + " heights");
    return grid;
  }
  grid.ny = static_cast<int>(rows.size());
  grid.nx = static_cast<int>(rows[0].size());
  grid.values.reserve(rows.size() * rows[0].size());
  for (std::size_t j = 0; j < rows.size(); ++j) {
    const std::string pointer = place->pointer + '/' + std::to_string(j);
    if (!rows[j].is_array() || rows[j].size() != rows[0].size()) {
      shape.faults().add(pointer, "must have as many heights as the first row");
      continue;
    }
    for (std::size_t i = 0; i < rows[j].size(); ++i) {
      json& height = rows[j][i];
      const bool sound = height.is_number() && kAnyNumber.contains(height.get<double>());
      if (!sound)
        read_number({&height, pointer + '/' + std::to_string(i)}, kAnyNumber, shape.faults());
      grid.values.push_back(sound ? metres * height.get<double>() : 0.0);
    }
  }
  return grid;
}

}  // namespace

geometry::SurfacePtr read_sag(ObjectReader& shape, double metres, const geometry::Pose& pose) {
  const std::size_t faults_before = shape.faults().count();
  const auto sound = [&] { return shape.faults().count() == faults_before; };
  const Vec3 origin = pose.point(metres * shape.vector("origin"));
  const geometry::Mat3 axes = read_axes(shape, pose);
  const std::string kind = shape.word("kind", {"xy_polynomial", "zernike", "heights"});
  if (kind == "heights") {
    const HeightGrid grid = read_heights(shape, metres);
    return sound() ? geometry::make_sag(origin, axes, grid) : nullptr;
  }
  if (kind.empty()) {
    shape.ignore_the_rest();
    return nullptr;
  }
  const XyPolynomial f =
      kind == "zernike" ? read_zernike(shape, metres) : read_xy_polynomial(shape, metres);
  return sound() ? geometry::make_sag(origin, axes, f) : nullptr;
}

}  // namespace caustic::service
