// The main question and its answer: isolux curves and caustics of every family, sheet by sheet.
// Everything SI; the service converts.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "geometry/linear.h"
#include "solver/optical_system.h"

namespace caustic::solver {

using geometry::Point;
using geometry::Vec2;
using geometry::Vec3;

/// Which levels: the given ones, or `count` between min and max. Where min or max is missing it is
/// the 5th or 95th percentile, by receiver area, of E on a subdivision that depends on the scene
/// alone.
struct LevelRequest {
  enum class Spacing { log, linear, one_two_five };
  std::vector<double> values;  ///< W/m², > 0; if not empty nothing else counts
  int count = 8;               ///< both ends included; one_two_five ignores it
  Spacing spacing = Spacing::log;
  std::optional<double> min, max;
};

/// Each sheet of each family by itself, or what a meter reads: their sum.
enum class Measure : std::uint8_t { sheet, total };

class TotalObserver;  // total_contours.h

struct ContourRequest {
  /// Families by surface index, each at most kMaxHops long; empty means those of at most
  /// `max_bounces` that occur, and of these only what brings at least `min_flux_share` of all flux
  /// is traced.
  std::vector<std::vector<int>> families;
  int max_bounces = 1;
  double min_flux_share = 1e-6;
  LevelRequest levels;
  Measure measure = Measure::sheet;
  bool direct = false;          ///< add the light that comes straight from the source to the total
  bool sheets_instead = false;  ///< trace sheets, with a warning, where totals are not supported
  bool isolux = true;
  bool caustic = true;
  bool boundaries = false;             ///< of sheets; with the total only
  bool critical_points = false;        ///< of what is measured
  bool regions = false;                ///< between boundaries; with the total only
  double irradiance_tolerance = 1e-9;  ///< |E/level − 1| at every vertex
  double chord_tolerance = 0.0;        ///< m on the receiver; 0 means 1e-4 × its larger side
  double time_limit = 5.0;             ///< s
  std::size_t vertex_limit = 500000;
  /// Prove that no component is missed, or name the cells in which one could be (S70)–(S79).
  bool certify = false;
  std::size_t cell_limit = 200000;  ///< of the proof, for each family and side
  int threads = 1;                  ///< the result does not depend on it

  /// Called now and then with the share done, 0…1, from the calling thread's pool.
  std::function<void(double)> progress;
  const std::atomic<bool>* cancelled = nullptr;
  /// Looks on while a total is traced; may be null.
  TotalObserver* observer = nullptr;
  /// Stages to run although a scene does not need them, of `skippable_stages()`; for measuring.
  std::set<std::string> no_skip;
};

enum class CurveKind : std::uint8_t {
  isolux = 0,
  caustic = 1,
  jump = 2,
  receiver_edge = 3,
  boundary = 4  ///< across which the number of sheets changes, with the totals on both sides
};

enum class Ending : std::uint8_t {
  silhouette,
  aperture,
  shadow,
  occlusion,
  total_internal_reflection,
  receiver_edge,
  limit,
  node  ///< of totals: another arc goes on there
};

/// Across what the total jumps, as numbered in the contract (api.md).
enum class BoundaryKind : std::uint8_t {
  none,
  caustic,
  shadow,
  occlusion,
  aperture,
  silhouette,
  total_internal_reflection,
  receiver
};

struct CurveVertex {
  Vec2 uv;            ///< receiver axes, m
  Point p;            ///< on the receiver, world, m
  Point x;            ///< first hit on the reflector, world, m
  double irradiance;  ///< W/m²; −1 on caustics
  double residual;    ///< |E/level − 1|; caustics: |a|/(|∇q1||∇q2|)
  Vec3 gradient;      ///< ∇E in world axes, W/m³; 0 on caustics
  double arc_length;  ///< from the first vertex, along the polyline on the receiver, m
  /// Totals on both sides of a jump, W/m², −1 where unbounded; elsewhere both as `irradiance`.
  double dark = 0.0, bright = 0.0;
};

struct Curve {
  CurveKind kind = CurveKind::isolux;
  double level = -1.0;  ///< W/m²; −1 for caustics
  int family_id = 0;
  int parity = 0;            ///< sign of a on finite levels; 0 on caustics
  bool closed = false;       ///< closed curves do not repeat their first vertex here
  std::vector<Ending> ends;  ///< two if open, none if closed
  std::vector<CurveVertex> vertices;
  double length = 0.0;  ///< of the polyline on the receiver, the closing segment included, m
  double max_residual = 0.0;
  /// Of totals: the edges of {E_total ≥ level}, head to tail with the brighter side on the left.
  BoundaryKind boundary = BoundaryKind::none;  ///< what a jump runs along
  int ring_id = -1, ring_order = -1;
};

enum class CriticalType : std::uint8_t { minimum, maximum, saddle };

/// Where the gradient of what is measured vanishes, inside of a face.
struct CriticalPlace {
  Vec2 uv;   ///< receiver axes, m
  Point x;   ///< first hit on the reflector, of the brightest sheet, world, m
  double E;  ///< W/m²
  CriticalType type;
  int family_id;  ///< −1 for the total
};

/// A face between boundaries.
struct Region {
  Vec2 uv_inside;  ///< a place well inside, receiver axes, m
  int branches;    ///< sheets that arrive everywhere in it
};

struct FamilyReport {
  int id;
  std::vector<int> surfaces;
  double flux;  ///< W that this family brings to the receiver
};

struct Skipped {
  std::string stage, reason;
};

struct Warning {
  std::string code, detail;
};

/// A cell of the first surface, or of the receiver, of which it could not be proven what curves are
/// in it.
struct Undecided {
  int family_id;                 ///< −1: a cell of the receiver, of the total
  std::vector<double> levels;    ///< W/m²; −1 for the caustic
  std::array<Point, 4> corners;  ///< in order around the cell
};

struct ContourResult {
  bool complete = true;  ///< false if a limit cut the work short
  std::vector<FamilyReport> families;
  std::vector<double> levels;  ///< resolved, ascending
  Measure measure = Measure::sheet;
  std::vector<Curve> curves;                   ///< by kind, level, family, then smallest (u, v)
  std::vector<CriticalPlace> critical_points;  ///< by family, then (u, v); if asked for
  std::vector<Region> regions;                 ///< if asked for
  bool certified = false;
  std::size_t undecided_cells = 0;
  std::size_t cells = 0;              ///< that the proof looked at
  std::vector<Undecided> undecided;   ///< of the proof, if one was asked for
  std::vector<std::string> unproven;  ///< what else was not proven
  std::vector<Skipped> skipped;
  std::uint64_t evaluations = 0;
  double seconds = 0.0;
  std::vector<Warning> warnings;
  std::optional<std::string>
      unsupported;  ///< what of the request this version lacks; no curves then
};

/// Every numerical outcome is a value: degenerate scenes answer with warnings, limits with
/// `complete == false`. Never throws for what a valid system contains.
ContourResult trace_contours(const OpticalSystem& system, const ContourRequest& request);

/// Words of the contract (api.md) for the enumerations above.
const char* to_string(CurveKind kind);
const char* to_string(Ending ending);
const char* to_string(CriticalType type);

}  // namespace caustic::solver
