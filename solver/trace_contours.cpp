// Plan, explore, seed, trace, cut: the way from a system to its curves.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <sstream>
#include <thread>
#include <tuple>

#include "solver/contours.h"
#include "solver/corrector.h"
#include "solver/family_field.h"
#include "solver/trace_contour.h"
#include "solver/visible_pieces.h"

namespace caustic::solver {

namespace {

// Default chord tolerance and margin of Embree's boxes, as shares of the receiver and of the scene.
constexpr double kDefaultChordShare = 1e-4;
constexpr double kMarginShare = 1e-2;
// The corrector aims at this share of the tolerance, and at least at kResidual: positions have to be
// good even where irradiance may be coarse.
constexpr double kResidualShare = 0.1;
constexpr double kResidual = 1e-9;
// A level this near to a critical value is moved off it.
constexpr double kCriticalShare = 1e-9;
// Open curves shorter than this share of the chord tolerance are left out.
constexpr double kSpeckShare = 1e-2;
// Shares of the seed's cell: first step, and how near to the curve the corrector brings the seed.
constexpr double kFirstStepShare = 0.25;
constexpr double kSeedPosition = 1e-9;

// All curves of one level function on one field.
struct Task {
  const FamilyField* field;
  LevelFunction level;
  double irradiance;  // W/m², −1 for the caustic
  std::vector<Seed> seeds;
  std::vector<Trace> traces;
  std::size_t lost_seeds = 0;
};

// A point against the cubic through two vertices with their tangents.
struct Gap {
  Point foot;
  double off, sagitta;
};
std::optional<Gap> gap_to_cubic(const Trace& trace, std::size_t i, std::size_t j, const Point& x) {
  const Point &a = trace.vertices[i].x, &b = trace.vertices[j].x;
  const Vec3 chord = b - a;
  const double length = chord.norm(), w = chord.dot(x - a) / (length * length), v = 1.0 - w;
  if (!(w >= -1e-3 && w <= 1.0 + 1e-3)) return std::nullopt;
  const Vec3 bulge = (length * w * v * v) * (trace.tangents[i] - chord / length) -
                     (length * w * w * v) * (trace.tangents[j] - chord / length);
  const Point foot = a + w * chord + bulge;
  return Gap{foot, (x - foot).norm(), bulge.norm() + 1e-3 * length * w * v};
}

// Is a seed on a curve that has been traced? Surely within a twentieth of the sagitta from the cubic,
// since that is off by a fourth order only, and a curve that passes nearer does so elsewhere too; up
// to some sagittas the corrector tells, from the cubic's point next to the seed.
bool visited(const std::vector<Trace>& traces, const FieldPoint& seed, double fuzz,
             Evaluator& evaluate, const LevelFunction& level) {
  for (const Trace& trace : traces) {
    const auto& vertices = trace.vertices;
    const std::size_t n = vertices.size();
    std::size_t nearest = 0;
    double least = geometry::kInfinity;
    for (std::size_t i = 0; i < n; ++i) {
      const double d = (vertices[i].x - seed.x).squaredNorm();
      if (d < least) {
        least = d;
        nearest = i;
      }
    }
    if (least <= fuzz * fuzz) return true;
    for (const std::size_t begin : {(nearest + n - 1) % n, nearest}) {
      if (!trace.closed && begin == n - 1) continue;
      const auto gap = gap_to_cubic(trace, begin, (begin + 1) % n, seed.x);
      if (!gap || gap->off > 4.0 * gap->sagitta + fuzz) continue;
      if (gap->off <= 0.05 * gap->sagitta + fuzz) return true;
      const auto on_curve = correct(evaluate, level, gap->foot,
                                    {1e-12, geometry::kInfinity, 2.0 * gap->off});
      if (!on_curve) continue;
      const Vec3 apart = on_curve->x - seed.x, t = level.tangent(seed);
      if ((apart - t * t.dot(apart)).norm() <= 0.2 * gap->off + fuzz) return true;
    }
  }
  return false;
}

// The seed on its curve and inside the domain or on its boundary.
std::optional<FieldPoint> settle(const Seed& seed, Evaluator& evaluate, const FamilyField& field,
                                 const LevelFunction& level, double residual) {
  const CorrectorOptions options{residual, kSeedPosition * seed.reach, seed.reach};
  auto f = correct(evaluate, level, seed.at, options);
  if (!f) return std::nullopt;
  const auto worst = field.domain.worst(*f);
  const double slack = 100.0 * evaluate.map().rounding(f->x);
  if (worst.value <= slack) return f;
  // Found on the chord of a curved boundary: onto the boundary itself.
  f = correct_at_end(evaluate, level, field.domain, worst.boundary, f->x, options);
  const double steep = f ? field.domain.gradient(worst.boundary, *f).norm() : 0.0;
  if (!f || field.domain.worst(*f).value > slack * (1.0 + steep)) return std::nullopt;
  return f;
}

// Too short to be seen: what rounding leaves between two boundaries where all levels meet, or where
// visibility flickers along a silhouette.
bool speck(const Trace& trace, double chord) {
  double length = 0.0;
  for (std::size_t i = 1; i < trace.vertices.size(); ++i) {
    length += (trace.vertices[i].uv - trace.vertices[i - 1].uv).norm();
    if (length > kSpeckShare * chord) return false;
  }
  return !trace.closed;
}

void run(Task& task, Budget& budget, double chord, double residual) {
  Evaluator evaluate(task.field->map, budget);
  std::vector<Trace> whole;  // for telling visited seeds, before visibility cuts them
  for (const Seed& seed : task.seeds) {
    if (budget.exhausted()) break;
    // At a silhouette where a vanishes too all levels meet, and none can be followed.
    if (!seed.at.lit()) continue;
    const auto f = settle(seed, evaluate, *task.field, task.level, residual);
    if (!f) {
      ++task.lost_seeds;
      continue;
    }
    // The corrector leaves points no further off the curve than this.
    const double fuzz = 4.0 * kSeedPosition * seed.reach + 1e3 * evaluate.map().rounding(f->x);
    if (visited(whole, *f, fuzz, evaluate, task.level)) continue;
    const TraceOptions options{chord, residual, kFirstStepShare * seed.reach};
    Trace trace = trace_contour(evaluate, task.field->domain, task.level, *f, options);
    if (trace.vertices.size() < 2) continue;
    whole.push_back(trace);
    if (!task.field->visibility) {
      if (!speck(trace, chord)) task.traces.push_back(std::move(trace));
      continue;
    }
    for (Trace& piece : visible_pieces(std::move(trace), *task.field->visibility, evaluate,
                                       task.level, residual)) {
      if (!speck(piece, chord)) task.traces.push_back(std::move(piece));
    }
  }
}

void run_all(std::vector<Task>& tasks, const ContourRequest& request, Budget& budget, double chord,
             double residual) {
  std::atomic<std::size_t> next{0}, done{0};
  const auto work = [&](bool reports) {
    for (std::size_t i; (i = next++) < tasks.size();) {
      run(tasks[i], budget, chord, residual);
      ++done;
      if (reports && request.progress) request.progress(double(done) / double(tasks.size()));
    }
  };
  std::vector<std::thread> others;
  for (int i = 1; i < request.threads && tasks.size() > 1; ++i) others.emplace_back(work, false);
  work(true);
  for (std::thread& thread : others) thread.join();
}

// Brighter side on the left, seen with u right and v up; caustics from their smaller end.
void orient(Curve& curve, const geometry::ReceiverFrame& receiver) {
  auto& vertices = curve.vertices;
  bool reverse = false;
  if (curve.kind == CurveKind::isolux) {
    double left = 0.0;
    for (std::size_t i = 0; i + 1 < vertices.size(); ++i) {
      const Vec2 d = vertices[i + 1].uv - vertices[i].uv;
      const Vec3& g = vertices[i].gradient;
      const double scale = g.norm();
      if (scale > 0.0) left += (d.x() * receiver.v.dot(g) - d.y() * receiver.u.dot(g)) / scale;
    }
    reverse = left < 0.0;
  } else {
    const Vec2 &a = vertices.front().uv, &b = curve.closed ? vertices[1].uv : vertices.back().uv;
    reverse = std::tie(b.x(), b.y()) < std::tie(a.x(), a.y());
  }
  if (!reverse) return;
  std::reverse(vertices.begin(), vertices.end());
  std::reverse(curve.ends.begin(), curve.ends.end());
}

Curve finish(Trace trace, const Task& task, const geometry::ReceiverFrame& receiver) {
  Curve curve;
  curve.kind = task.level.is_caustic() ? CurveKind::caustic : CurveKind::isolux;
  curve.level = task.irradiance;
  curve.family_id = task.field->piece.family;
  curve.parity = task.level.k > 0.0 ? 1 : task.level.k < 0.0 ? -1 : 0;
  curve.closed = trace.closed;
  curve.ends = std::move(trace.ends);
  curve.vertices = std::move(trace.vertices);
  orient(curve, receiver);
  double length = 0.0;
  for (std::size_t i = 0; i < curve.vertices.size(); ++i) {
    CurveVertex& v = curve.vertices[i];
    if (i > 0) length += (v.p - curve.vertices[i - 1].p).norm();
    v.arc_length = length;
    // Against the level asked for, which a critical value may have moved.
    if (curve.kind == CurveKind::isolux) v.residual = std::abs(v.irradiance / curve.level - 1.0);
    curve.max_residual = std::max(curve.max_residual, v.residual);
  }
  if (curve.closed) length += (curve.vertices.front().p - curve.vertices.back().p).norm();
  curve.length = length;
  return curve;
}

Vec2 smallest_uv(const Curve& curve) {
  Vec2 least = curve.vertices.front().uv;
  for (const CurveVertex& v : curve.vertices) {
    if (std::tie(v.uv.x(), v.uv.y()) < std::tie(least.x(), least.y())) least = v.uv;
  }
  return least;
}

void sort_curves(std::vector<Curve>& curves) {
  using Key = std::tuple<int, double, int, double, double>;
  std::vector<std::pair<Key, std::size_t>> order;
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const Curve& c = curves[i];
    const Vec2 uv = smallest_uv(c);
    order.push_back({{static_cast<int>(c.kind), c.level, c.family_id, uv.x(), uv.y()}, i});
  }
  std::sort(order.begin(), order.end());
  std::vector<Curve> sorted;
  for (const auto& [key, i] : order) sorted.push_back(std::move(curves[i]));
  curves = std::move(sorted);
}

std::string number(double value) {
  std::ostringstream text;
  text.precision(6);
  text << value;
  return text.str();
}

class Run {
 public:
  Run(const OpticalSystem& system, const ContourRequest& request)
      : system_(system),
        request_(request),
        budget_(request.time_limit, request.vertex_limit, request.cancelled),
        chord_(request.chord_tolerance > 0.0 ? request.chord_tolerance
                                             : kDefaultChordShare * system.receiver().width()),
        residual_(std::min(kResidualShare * request.irradiance_tolerance, kResidual)) {}

  ContourResult operator()() {
    const auto begin = std::chrono::steady_clock::now();
    list_families();
    explore();
    result_.levels = request_.isolux ? levels() : std::vector<double>{};
    std::vector<Task> tasks = make_tasks();
    run_all(tasks, request_, budget_, chord_, residual_);
    collect(tasks);
    if (budget_.exhausted()) {
      result_.complete = false;
      warn("limit", "a limit of time or vertices cut the work short; curves are missing or end at "
                    "\"limit\"");
    }
    result_.evaluations = budget_.evaluations();
    result_.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return std::move(result_);
  }

 private:
  void list_families();
  void explore();
  void judge(const FamilyField& field, const std::string& name);
  std::vector<double> levels();
  std::vector<LevelFunction> targets_for(const FamilyField& field, std::vector<double>& irradiances);
  std::vector<Task> make_tasks();
  void collect(std::vector<Task>& tasks);
  void warn(const std::string& code, const std::string& detail) {
    for (const Warning& w : result_.warnings) {
      if (w.code == code && w.detail == detail) return;
    }
    result_.warnings.push_back({code, detail});
  }
  void skip(const std::string& stage, const std::string& reason) {
    result_.skipped.push_back({stage, reason});
  }

  const OpticalSystem& system_;
  const ContourRequest& request_;
  Budget budget_;
  double chord_, residual_;
  ContourResult result_;
  std::unique_ptr<geometry::EmbreeScene> embree_;
  std::vector<std::unique_ptr<FamilyField>> fields_;
  std::size_t empty_levels_ = 0;
};

void Run::list_families() {
  std::vector<std::vector<int>> families = request_.families;
  if (families.empty()) {
    for (int i = 0; i < static_cast<int>(system_.surfaces().size()); ++i) {
      if (system_.surfaces()[i].optics.kind == Optics::Kind::mirror) families.push_back({i});
    }
  }
  for (int id = 0; id < static_cast<int>(families.size()); ++id) {
    result_.families.push_back({id, families[id], 0.0});
  }
}

void Run::explore() {
  std::vector<std::vector<int>> families;
  for (const FamilyReport& family : result_.families) families.push_back(family.surfaces);
  const Plan plan = make_plan(system_, families, request_.no_skip);
  result_.skipped = plan.skipped;
  const double margin = kMarginShare * system_.diameter();
  if (plan.embree) {
    std::vector<geometry::Box> boxes;
    for (const SystemSurface& surface : system_.surfaces()) boxes.push_back(surface.region);
    embree_ = std::make_unique<geometry::EmbreeScene>(boxes, margin);
  }
  std::size_t discarded = 0, kept = 0;
  for (const PlannedPiece& piece : plan.pieces) {
    fields_.push_back(std::make_unique<FamilyField>(system_, piece, embree_.get(), margin));
    FamilyField& field = *fields_.back();
    field.explore(budget_);
    discarded += field.exploration.discarded;
    kept += field.exploration.cells.size();
    result_.families[piece.family].flux += field.flux;
    result_.undecided_cells += field.exploration.unresolved;
    judge(field, system_.surfaces()[piece.surface].name);
  }
  if (discarded > 0) {
    skip("unseen_cells", std::to_string(discarded) + " of " + std::to_string(discarded + kept) +
                             " cells of the mirrors send nothing to the receiver");
  }
  for (const FamilyReport& family : result_.families) {
    if (family.flux > 0.0 || budget_.exhausted()) continue;
    const auto& name = system_.surfaces()[family.surfaces.front()].name;
    warn("unlit_family", "no light reaches the receiver by way of \"" + name + "\"");
  }
}

void Run::judge(const FamilyField& field, const std::string& name) {
  if (field.degenerate) {
    warn("degenerate_family", "all light of \"" + name + "\" that reaches the receiver passes "
                              "through one point or line of it: its irradiance is unbounded there "
                              "and zero elsewhere, so it has no curves");
  } else if (field.uniform && !field.empty()) {
    warn("uniform_irradiance", "the irradiance by \"" + name + "\" is constant, " +
                                   number(1.0 / std::abs(field.phi_max)) +
                                   " W/m²: it has no level curves");
  }
}

std::vector<double> Run::levels() {
  std::vector<WeightedIrradiance> samples;
  for (const auto& field : fields_) {
    if (field->degenerate) continue;
    samples.insert(samples.end(), field->samples.begin(), field->samples.end());
  }
  std::vector<double> levels = resolve_levels(request_.levels, samples);
  if (levels.empty()) {
    warn("no_levels", samples.empty() ? "no light on the receiver to choose levels from"
                                      : "no level lies between the given min or max and the 5th or "
                                        "95th percentile that takes the other's place");
  }
  return levels;
}

// Ascending k for all levels and both parities, and the caustic.
std::vector<LevelFunction> Run::targets_for(const FamilyField& field,
                                            std::vector<double>& irradiances) {
  std::vector<std::pair<double, double>> ks;
  for (const double level : result_.levels) {
    bool met = false;
    for (const int parity : {-1, 1}) {
      LevelFunction f = LevelFunction::isolux(level, parity);
      for (const CriticalPoint& c : field.critical) {
        if (std::abs(c.field.inverse_irradiance() / f.k - 1.0) > kCriticalShare) continue;
        f.k *= 1.0 + 0.5 * request_.irradiance_tolerance;
        warn("critical_level", "level " + number(level) + " is a critical value of the irradiance; " +
                                   "the curves are those just below it");
        break;
      }
      met |= f.k > field.phi_min && f.k < field.phi_max;
      ks.push_back({f.k, level});
    }
    empty_levels_ += !met;
  }
  if (request_.caustic) ks.push_back({0.0, -1.0});
  std::sort(ks.begin(), ks.end());
  std::vector<LevelFunction> targets;
  for (const auto& [k, level] : ks) {
    targets.push_back({k});
    irradiances.push_back(level);
  }
  return targets;
}

std::vector<Task> Run::make_tasks() {
  std::vector<Task> tasks;
  for (const auto& field : fields_) {
    if (field->degenerate || field->uniform || field->empty()) continue;
    std::vector<double> irradiances;
    const auto targets = targets_for(*field, irradiances);
    std::vector<Task> own;
    for (std::size_t i = 0; i < targets.size(); ++i) {
      own.push_back({field.get(), targets[i], irradiances[i], {}, {}, 0});
    }
    Evaluator evaluate(field->map, budget_);
    for (Seed& seed : find_seeds(evaluate, field->exploration, field->critical, targets)) {
      own[seed.target].seeds.push_back(std::move(seed));
    }
    std::copy_if(std::make_move_iterator(own.begin()), std::make_move_iterator(own.end()),
                 std::back_inserter(tasks), [](const Task& task) { return !task.seeds.empty(); });
  }
  if (empty_levels_ > 0) {
    skip("empty_levels", std::to_string(empty_levels_) +
                             " levels lie outside the range of a family's irradiance");
  }
  return tasks;
}

void Run::collect(std::vector<Task>& tasks) {
  double conditioning = 0.0;
  std::size_t lost = 0, levels_with_lost = 0;
  for (Task& task : tasks) {
    lost += task.lost_seeds;
    levels_with_lost += task.lost_seeds > 0;
    for (Trace& trace : task.traces) {
      if (!task.level.is_caustic()) conditioning = std::max(conditioning, trace.conditioning);
      if (trace.clipped) {
        warn("clipped", "a curve ends where an unbounded surface is cut off, 500 scene diameters "
                        "from its middle");
      }
      if (trace.stalled) warn("stalled", "a curve could not be followed further and ends at \"limit\"");
      result_.curves.push_back(finish(std::move(trace), task, system_.receiver()));
    }
  }
  sort_curves(result_.curves);
  if (lost > 0 && !budget_.exhausted()) {
    result_.undecided_cells += lost;
    warn("unresolved", "in " + std::to_string(lost) + " cells curves of " +
                           std::to_string(levels_with_lost) +
                           " levels could not be settled: they lie within rounding of the caustic or "
                           "of a point where all levels meet");
  }
  if (conditioning > request_.irradiance_tolerance) {
    warn("conditioning", "rounding of the reflector point alone moves the irradiance by up to " +
                             number(conditioning) + " (relative); that takes the tolerance's place");
  }
}

}  // namespace

ContourResult trace_contours(const OpticalSystem& system, const ContourRequest& request) {
  return Run(system, request)();
}

const char* to_string(CurveKind kind) {
  return kind == CurveKind::isolux ? "isolux" : "caustic";
}

const char* to_string(Ending ending) {
  switch (ending) {
    case Ending::silhouette: return "silhouette";
    case Ending::aperture: return "aperture";
    case Ending::shadow: return "shadow";
    case Ending::occlusion: return "occlusion";
    case Ending::receiver_edge: return "receiver_edge";
    case Ending::limit: return "limit";
  }
  return "limit";
}

}  // namespace caustic::solver
