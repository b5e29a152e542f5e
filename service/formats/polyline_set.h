// Traced curves as every file format needs them: in the user's length unit, with their labels. What
// a result record holds; knows neither JSON nor files nor the engine.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace caustic::service {

/// Plain doubles, so that a record is read and written as one block.
struct PolylineVertex {
  std::array<double, 3> position;  ///< world
  std::array<double, 2> uv;        ///< receiver axes
  double irradiance;               ///< per square metre; −1 on caustics
  double residual;
  std::array<double, 3> gradient;  ///< world, per length unit
  double arc_length;
  std::array<double, 3> reflector_point;
  double dark, bright;  ///< irradiance on both sides of a jump, −1 where unbounded
};
static_assert(sizeof(PolylineVertex) == 16 * sizeof(double));

enum class PolylineKind : std::int32_t {
  isolux = 0,
  caustic = 1,
  jump = 2,
  receiver_edge = 3,
  boundary = 4
};

struct Polyline {
  PolylineKind kind = PolylineKind::isolux;
  std::int32_t closed = 0;  ///< the last vertex joins the first, which is not repeated here
  std::int32_t family_id = 0;
  std::int32_t parity = 0;
  /// Of totals: what a jump runs along (as numbered in the contract), and its place in a ring.
  std::int32_t boundary = 0, ring_id = -1, ring_order = -1;
  std::int32_t unused = 0;  ///< no gap in the record
  double level = 0.0;       ///< −1 for caustics and boundaries
  double length = 0.0;
  std::uint64_t first = 0, count = 0;  ///< its vertices in the set

  /// Vertices of a file: a closed curve comes back to its first.
  std::uint64_t file_vertices() const { return count + (closed ? 1 : 0); }
  bool is_caustic() const { return kind == PolylineKind::caustic; }
  bool is_boundary() const { return kind == PolylineKind::boundary; }
  bool has_level() const { return !is_caustic() && !is_boundary(); }
  bool is_jump() const { return kind == PolylineKind::jump || kind == PolylineKind::receiver_edge; }
};

struct PolylineSet {
  std::vector<Polyline> curves;  ///< curve_id is the index
  std::vector<PolylineVertex> vertices;
  std::array<double, 2> receiver_size{};  ///< along u, v
  bool total = false;                     ///< curves of the total irradiance

  std::string length_unit, irradiance_unit, quantity;
  std::string scene_json, units_json, engine_version, request_sha256;

  /// Vertex i of a curve's file; i = count is the first again.
  const PolylineVertex& vertex(const Polyline& curve, std::uint64_t i) const {
    return vertices[curve.first + (i == curve.count ? 0 : i)];
  }
};

/// The words of JSON, GeoJSON and CSV.
inline const char* word(PolylineKind kind) {
  constexpr const char* kWords[] = {"isolux", "caustic", "jump", "receiver_edge", "boundary"};
  return kWords[static_cast<int>(kind)];
}

}  // namespace caustic::service
