// Units of a request. Inside everything is SI; this is the one table that says otherwise.
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace caustic::service {

struct LengthUnit {
  const char* name;
  double metres;
};

constexpr std::array<LengthUnit, 5> kLengthUnits{
    {{"m", 1.0}, {"cm", 0.01}, {"mm", 0.001}, {"in", 0.0254}, {"ft", 0.3048}}};

struct Units {
  LengthUnit length = kLengthUnits[0];
  bool photometric = false;

  const char* quantity() const { return photometric ? "photometric" : "radiometric"; }
  /// Per square metre, whatever the unit of length.
  const char* irradiance() const { return photometric ? "lx" : "W/m2"; }
  const char* irradiance_name() const { return photometric ? "illuminance" : "irradiance"; }
};

}  // namespace caustic::service
