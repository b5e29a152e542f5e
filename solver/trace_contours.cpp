// Plan, explore, seed, trace, cut: the way from a system to its curves.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <sstream>
#include <thread>

#include "solver/contour_task.h"
#include "solver/critical_points.h"
#include "solver/itineraries.h"
#include "solver/prover.h"
#include "solver/total_contours.h"

namespace caustic::solver {

namespace {

// Default chord tolerance, as a share of the receiver.
constexpr double kDefaultChordShare = 1e-4;
// What is further from a segment than this is not asked how far: a share of the scene, and in a
// hierarchy, where it would else be the more surfaces the smaller they are, of the surfaces' sizes.
constexpr double kMarginShare = 1e-2;
constexpr double kMarginSizes = 0.25;
// A total is traced no coarser: what lies within a chord of an arc could not be told from it, and
// closed arcs beside others would be lost.
constexpr double kCoarsestTotal = 2e-3;
// The corrector aims at this share of the tolerance, and at least at kResidual: positions have to
// be good even where irradiance may be coarse.
constexpr double kResidualShare = 0.1;
constexpr double kResidual = 1e-9;
// A level this near to a critical value is moved off it.
constexpr double kCriticalShare = 1e-9;

void run_all(std::vector<ContourTask>& tasks, const ContourRequest& request, Budget& budget,
             double chord, double residual) {
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

std::string number(double value) {
  std::ostringstream text;
  text.precision(6);
  text << value;
  return text.str();
}

double margin_for(const OpticalSystem& system, bool embree) {
  const double margin = kMarginShare * system.diameter();
  if (!embree) return margin;
  std::vector<double> sizes;
  for (const SystemSurface& surface : system.surfaces()) sizes.push_back(surface.region.diagonal());
  const auto middle = sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2);
  std::nth_element(sizes.begin(), middle, sizes.end());
  return std::min(margin, kMarginSizes * *middle);
}

class Run {
 public:
  Run(const OpticalSystem& system, const ContourRequest& request)
      : system_(system),
        request_(request),
        measure_(request.measure),
        budget_(request.time_limit, request.vertex_limit, request.cancelled),
        prover_(system, request),
        chord_(request.chord_tolerance > 0.0 ? request.chord_tolerance
                                             : kDefaultChordShare * system.receiver().width()),
        residual_(std::min(kResidualShare * request.irradiance_tolerance, kResidual)) {}

  ContourResult operator()() {
    const auto begin = std::chrono::steady_clock::now();
    list_families();
    explore();
    if (measure_ == Measure::total) {
      result_.unsupported = total_unsupported(fields_of_total());
      if (result_.unsupported && !request_.sheets_instead) return std::move(result_);
    }
    if (result_.unsupported) {
      warn("sheets_instead", "each sheet by itself: " + *result_.unsupported +
                                 " is not supported by this version" +
                                 (request_.direct ? "; the direct light is left out" : ""));
      measure_ = Measure::sheet;
      direct_.reset();
      result_.unsupported.reset();
    }
    result_.levels = request_.isolux ? levels() : std::vector<double>{};
    if (request_.certify && measure_ == Measure::total) prove_total();
    std::vector<ContourTask> tasks = make_tasks();
    run_all(tasks, request_, budget_, chord_, residual_);
    collect(tasks);
    if (measure_ == Measure::total)
      add_total();
    else if (request_.critical_points)
      add_critical_points();
    sort_curves(result_.curves);
    if (budget_.exhausted()) {
      result_.complete = false;
      warn("limit",
           "a limit of time or vertices cut the work short; curves are missing or end at "
           "\"limit\"");
    }
    conclude();
    result_.evaluations = budget_.evaluations() + prover_.evaluations();
    result_.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    result_.measure = measure_;
    return std::move(result_);
  }

 private:
  void list_families();
  void explore();
  void judge(const FamilyField& field);
  void drop_faint_families();
  std::string name_of(int family) const;
  std::vector<double> levels();
  std::vector<LevelFunction> targets_for(const FamilyField& field,
                                         std::vector<double>& irradiances);
  std::vector<ContourTask> make_tasks();
  void prove_total();
  void collect(std::vector<ContourTask>& tasks);
  void conclude();
  std::vector<const FamilyField*> fields_of_total() const;
  void warn_of_conditioning(double relative);
  void add_total();
  void add_critical_points();
  void warn(const std::string& code, const std::string& detail) {
    for (const Warning& w : result_.warnings) {
      if (w.code == code && w.detail == detail) return;
    }
    result_.warnings.push_back({code, detail});
  }
  void leave_unproven(const std::string& what) { result_.unproven.push_back(what); }
  void skip(const std::string& stage, const std::string& reason) {
    result_.skipped.push_back({stage, reason});
  }

  const OpticalSystem& system_;
  const ContourRequest& request_;
  Measure measure_;
  Budget budget_;
  Prover prover_;
  double chord_, residual_;
  ContourResult result_;
  std::unique_ptr<geometry::EmbreeScene> embree_;
  std::vector<std::unique_ptr<FamilyField>> fields_;
  std::unique_ptr<FamilyField> direct_;  // where it is part of the total
  std::size_t empty_levels_ = 0;
};

void Run::list_families() {
  std::vector<std::vector<int>> families = request_.families;
  if (families.empty())
    families = families_up_to(system_, request_.max_bounces, Arrival::in_window,
                              [this] { return budget_.out_of_time(); });
  for (int id = 0; id < static_cast<int>(families.size()); ++id) {
    result_.families.push_back({id, families[id], 0.0});
  }
}

void Run::explore() {
  std::vector<std::vector<int>> families;
  for (const FamilyReport& family : result_.families) families.push_back(family.surfaces);
  const bool direct = request_.direct && measure_ == Measure::total;
  const Plan plan = make_plan(system_, families, direct, request_.no_skip,
                              [this] { return budget_.out_of_time(); });
  result_.skipped = plan.skipped;
  const double margin = margin_for(system_, plan.embree);
  if (plan.embree) {
    std::vector<geometry::Box> boxes;
    for (const SystemSurface& surface : system_.surfaces()) boxes.push_back(surface.region);
    embree_ = std::make_unique<geometry::EmbreeScene>(boxes, margin);
  }
  std::size_t discarded = 0, kept = 0, hidden = 0;
  std::vector<std::size_t> unresolved(families.size());
  std::vector<bool> seen(families.size());
  for (const PlannedPiece& piece : plan.pieces) {
    fields_.push_back(std::make_unique<FamilyField>(system_, piece, embree_.get(), margin));
    FamilyField& field = *fields_.back();
    field.explore(budget_);
    discarded += field.exploration.discarded;
    kept += field.exploration.cells.size();
    result_.families[piece.family].flux += field.flux;
    unresolved[piece.family] += field.exploration.unresolved;
    if (!field.empty()) seen[piece.family] = true;
    // What exploration gave up a proof decides, or gives up itself.
    if (!request_.certify) result_.undecided_cells += field.exploration.unresolved;
    hidden += field.hidden_whole && !field.piece.needless.hidden_family;
    judge(field);
  }
  drop_faint_families();
  if (plan.direct) {
    direct_ = std::make_unique<FamilyField>(system_, *plan.direct, embree_.get(), margin);
    direct_->explore(budget_);
    result_.undecided_cells += direct_->exploration.unresolved;
  }
  if (hidden > 0) {
    skip("hidden_family", std::to_string(hidden) + (hidden == 1 ? " family" : " families") +
                              " of which nothing shows");
  }
  if (discarded > 0 && !request_.no_skip.count("unseen_cells")) {
    skip("unseen_cells", std::to_string(discarded) + " of " + std::to_string(discarded + kept) +
                             " cells of the mirrors send nothing to the receiver");
  }
  std::size_t unlit = 0;
  for (const FamilyReport& family : result_.families) {
    if (family.flux > 0.0 || budget_.exhausted()) continue;
    const bool several = family.surfaces.size() > 1;
    if (const std::size_t cells = unresolved[family.id]) {
      warn("unresolved", "in " + std::to_string(cells) + (cells == 1 ? " cell" : " cells") +
                             " of the first surface light by way of " + name_of(family.id) +
                             " was neither found nor shown to be none");
    }
    if (seen[family.id]) {
      warn("unresolved", "light by way of " + name_of(family.id) +
                             " was only found in gaps between samples, which count as dark in its "
                             "flux and in the choice of levels");
      continue;
    }
    // Where more bounces are asked for surfaces by themselves are looked at without being expected.
    if (!several && request_.families.empty() && request_.max_bounces > 1) {
      ++unlit;
      continue;
    }
    warn("unlit_family", "no light was found that reaches the receiver by way of " +
                             name_of(family.id) +
                             (several ? "; from small parts of its first surface some may" : ""));
  }
  if (unlit > 0) {
    skip("family", "by way of " + std::to_string(unlit) +
                       (unlit == 1 ? " surface alone no light" : " surfaces alone no light") +
                       " was found that reaches the receiver");
  }
}

// Families that were not asked for by name and bring next to nothing.
void Run::drop_faint_families() {
  if (!request_.families.empty() || request_.no_skip.count("family")) return;
  double total = 0.0;
  for (const FamilyReport& family : result_.families) total += family.flux;
  for (const FamilyReport& family : result_.families) {
    if (!(family.flux > 0.0 && family.flux < request_.min_flux_share * total)) continue;
    std::erase_if(fields_, [&](const auto& field) { return field->piece.family == family.id; });
    skip("family", "by way of " + name_of(family.id) + " comes " + number(family.flux / total) +
                       " of the flux, less than min_flux_share");
  }
}

std::string Run::name_of(int family) const {
  std::string names;
  for (const int surface : result_.families[family].surfaces) {
    if (!names.empty()) names += ", ";
    names += '"' + system_.surfaces()[surface].name + '"';
  }
  return names;
}

void Run::judge(const FamilyField& field) {
  const std::string name = name_of(field.piece.family);
  if (field.degenerate) {
    warn("degenerate_family",
         "all light by way of " + name +
             " that reaches the receiver passes "
             "through one point or line of it: its irradiance is unbounded there "
             "and zero elsewhere, so it has no curves");
  } else if (field.uniform && !field.empty()) {
    warn("uniform_irradiance", "the irradiance by way of " + name + " is constant, " +
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
  if (direct_) samples.insert(samples.end(), direct_->samples.begin(), direct_->samples.end());
  std::vector<double> levels = resolve_levels(request_.levels, samples);
  if (levels.empty()) {
    const bool chosen = !request_.levels.min && !request_.levels.max;
    warn("no_levels", samples.empty() ? "no light on the receiver to choose levels from"
                      : chosen ? "the irradiance is constant on nine tenths of the receiver's "
                                 "light: no level lies between its percentiles"
                               : "no level lies between the given min or max and the 5th or "
                                 "95th percentile that takes the other's place");
  }
  return levels;
}

// Ascending k for all levels and both parities, and the caustic.
std::vector<LevelFunction> Run::targets_for(const FamilyField& field,
                                            std::vector<double>& irradiances) {
  std::vector<std::pair<double, double>> ks;
  std::vector<double> levels = result_.levels;
  if (measure_ == Measure::total) levels = {};
  for (const double level : levels) {
    bool met = false;
    for (const int parity : {-1, 1}) {
      LevelFunction f = LevelFunction::isolux(level, parity);
      for (const CriticalPoint& c : field.critical) {
        if (std::abs(c.field.inverse_irradiance() / f.k - 1.0) > kCriticalShare) continue;
        f.k *= 1.0 + 0.5 * request_.irradiance_tolerance;
        warn("critical_level", "level " + number(level) +
                                   " is a critical value of the irradiance; " +
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

std::vector<ContourTask> Run::make_tasks() {
  std::vector<ContourTask> tasks;
  for (const auto& field : fields_) {
    const bool curves_seen = !field->degenerate && !field->uniform && !field->empty();
    if (!curves_seen && !request_.certify) continue;
    std::vector<double> irradiances;
    const auto targets = targets_for(*field, irradiances);
    std::vector<ContourTask> own;
    for (std::size_t i = 0; i < targets.size(); ++i) {
      own.push_back({field.get(), targets[i], irradiances[i], {}, true, {}, 0});
    }
    if (curves_seen) {
      Evaluator evaluate(field->map, budget_);
      for (Seed& seed : find_seeds(evaluate, field->exploration, field->critical, targets)) {
        own[seed.target].seeds.push_back(std::move(seed));
      }
    }
    if (request_.certify && measure_ == Measure::sheet)
      prover_.prove_sheets(*field, name_of(field->piece.family), own);
    prover_.add_caustic_of_total(*field, own);
    std::copy_if(std::make_move_iterator(own.begin()), std::make_move_iterator(own.end()),
                 std::back_inserter(tasks),
                 [](const ContourTask& task) { return !task.seeds.empty(); });
  }
  if (empty_levels_ > 0) {
    skip("empty_levels",
         std::to_string(empty_levels_) + " levels lie outside the range of a family's irradiance");
  }
  return tasks;
}

void Run::prove_total() {
  std::vector<ProvenFamily> families;
  for (const auto& field : fields_) families.push_back({field.get(), name_of(field->piece.family)});
  prover_.prove_total(families, result_.levels, direct_ != nullptr);
}

// What the answer may claim.
void Run::conclude() {
  if (request_.families.empty() && request_.max_bounces > 1)
    leave_unproven("families of several hops are sought with some thousand rays from each surface");
  if (!request_.certify) {
    const bool several =
        std::any_of(result_.families.begin(), result_.families.end(),
                    [](const FamilyReport& family) { return family.surfaces.size() > 1; });
    if (several)
      leave_unproven(
          "light by way of several surfaces from parts of the first one that are small "
          "against its subdivision may be missing");
    return leave_unproven(
        "closed curves so small that neither the subdivision's edges nor critical points show them "
        "may be missing; \"certify\": true finds them, or names the cells in which they may be");
  }
  for (const std::string& of : prover_.conclude(result_)) {
    if (budget_.exhausted()) break;
    result_.complete = false;
    warn("limit", "a limit of cells or time cut the proof of " + of + " short");
  }
  const bool stalled = std::any_of(result_.warnings.begin(), result_.warnings.end(),
                                   [](const Warning& w) { return w.code == "stalled"; });
  if (stalled) leave_unproven("curves that could not be followed to their ends");
  result_.certified = result_.complete && result_.undecided_cells == 0 && result_.unproven.empty();
}

void Run::collect(std::vector<ContourTask>& tasks) {
  double conditioning = 0.0;
  std::size_t lost = 0, levels_with_lost = 0;
  for (ContourTask& task : tasks) {
    lost += task.lost_seeds;
    levels_with_lost += task.lost_seeds > 0;
    for (Trace& trace : task.traces) {
      if (!task.level.is_caustic()) conditioning = std::max(conditioning, trace.conditioning);
      if (trace.clipped) {
        warn("clipped",
             "a curve ends where an unbounded surface is cut off, 500 scene diameters "
             "from its middle");
      }
      if (trace.stalled)
        warn("stalled", "a curve could not be followed further and ends at \"limit\"");
      result_.curves.push_back(finish(std::move(trace), task, system_.receiver()));
    }
  }
  if (lost > 0 && !budget_.exhausted()) {
    result_.undecided_cells += lost;
    warn("unresolved",
         "in " + std::to_string(lost) + " cells curves of " + std::to_string(levels_with_lost) +
             " levels could not be settled: they lie within rounding of the caustic or "
             "of a point where all levels meet");
  }
  if (conditioning > request_.irradiance_tolerance) warn_of_conditioning(conditioning);
}

void Run::warn_of_conditioning(double relative) {
  warn("conditioning", "rounding of the reflector point alone moves the irradiance by up to " +
                           number(relative) + " (relative); that takes the tolerance's place");
}

std::vector<const FamilyField*> Run::fields_of_total() const {
  std::vector<const FamilyField*> fields;
  for (const auto& field : fields_) {
    if (!field->degenerate && (prover_.total() || !field->empty())) fields.push_back(field.get());
  }
  if (direct_ && !direct_->empty()) fields.push_back(direct_.get());
  return fields;
}

void Run::add_critical_points() {
  SheetCarrier carrier(system_, fields_of_total(), budget_);
  result_.critical_points = critical_points_of_sheets(carrier);
}

void Run::add_total() {
  const auto fields = fields_of_total();
  const TotalExtras extras{request_.boundaries, request_.critical_points, request_.regions};
  const bool wanted = !result_.levels.empty() || extras.any() || request_.observer;
  if (fields.empty() || !wanted) return;
  const double chord = std::min(chord_, kCoarsestTotal * system_.receiver().width());
  TotalContours total = trace_total(system_, fields, result_.levels, chord, residual_, extras,
                                    budget_, request_.observer, prover_.total());
  // Ends lie on boundaries, where a total may be as steep as one likes.
  double conditioning = 0.0;
  for (const Curve& curve : total.curves) {
    for (std::size_t i = 1; i + 1 < curve.vertices.size(); ++i)
      conditioning = std::max(conditioning, curve.vertices[i].residual);
  }
  if (conditioning > request_.irradiance_tolerance) warn_of_conditioning(conditioning);
  result_.critical_points = std::move(total.critical_points);
  result_.regions = std::move(total.regions);
  std::move(total.curves.begin(), total.curves.end(), std::back_inserter(result_.curves));
  std::move(total.boundaries.begin(), total.boundaries.end(), std::back_inserter(result_.curves));
  if (total.unresolved > 0 && !budget_.exhausted()) {
    result_.undecided_cells += total.unresolved;
    warn("unresolved", "of the total irradiance " + std::to_string(total.unresolved) +
                           " places could not be settled: regions there may not close");
  }
}

}  // namespace

ContourResult trace_contours(const OpticalSystem& system, const ContourRequest& request) {
  return Run(system, request)();
}

}  // namespace caustic::solver
