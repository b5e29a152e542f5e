#include "solver/prover.h"

#include <algorithm>
#include <iterator>

#include "solver/certify_contours.h"

namespace caustic::solver {

namespace {

// The proof may take this share of the time; the rest is for tracing.
constexpr double kProofShare = 0.6;

}  // namespace

Prover::Prover(const OpticalSystem& system, const ContourRequest& request)
    : system_(system),
      request_(request),
      budget_(kProofShare * request.time_limit, request.vertex_limit, request.cancelled) {}

// False, and said so, if nothing can be proven of the family.
bool Prover::provable(const FamilyField& field, const std::string& name) {
  const std::string family = "the family by way of " + name;
  if (field.degenerate) {
    unproven_.push_back(family + ": it is degenerate");
  } else if (!EnclosedMap::encloses(field.map)) {
    unproven_.push_back(family + ": enclosures know families of one hop");
  } else {
    return true;
  }
  return false;
}

void Prover::add_undecided(int family, const UndecidedCell& cell,
                           const std::function<double(int)>& level_of) {
  Undecided undecided{family, {}, cell.corners};
  for (const int target : cell.targets) undecided.levels.push_back(level_of(target));
  std::sort(undecided.levels.begin(), undecided.levels.end());
  const auto end = std::unique(undecided.levels.begin(), undecided.levels.end());
  undecided.levels.erase(end, undecided.levels.end());
  undecided_.push_back(std::move(undecided));
}

void Prover::end(std::size_t cells, bool exhausted, const std::string& of) {
  cells_ += cells;
  if (exhausted) cut_short_.push_back(of);
}

void Prover::prove_sheets(const FamilyField& field, const std::string& name,
                          std::vector<ContourTask>& tasks) {
  if (!provable(field, name)) return give_up(field);
  std::vector<LevelFunction> targets;
  for (const ContourTask& task : tasks) targets.push_back(task.level);
  Evaluator evaluate(field.map, budget_);
  auto certificate = certify_contours(evaluate, field.domain, targets, {request_.cell_limit});
  for (Seed& seed : certificate.seeds) tasks[seed.target].seeds.push_back(std::move(seed));
  for (const UndecidedCell& cell : certificate.undecided) {
    add_undecided(field.piece.family, cell, [&](int i) { return tasks[i].irradiance; });
  }
  end(certificate.cells, certificate.exhausted, "the family by way of " + name);
}

void Prover::prove_total(const std::vector<ProvenFamily>& families,
                         const std::vector<double>& levels, bool direct) {
  bool all = !direct;
  if (direct) unproven_.push_back("the direct light: enclosures know families of one hop");
  for (const ProvenFamily& family : families) all &= provable(*family.field, family.name);
  if (!all) {
    for (const ProvenFamily& family : families) give_up(*family.field);
    return;
  }
  if (families.empty()) return;
  for (const ProvenFamily& family : families) fields_.push_back(family.field);
  total_ = certify_total(system_, fields_, levels, budget_, {request_.cell_limit});
  for (const auto& [field, cell] : total_->undecided_boundaries) {
    add_undecided(fields_[field]->piece.family, cell, [](int) { return -1.0; });
  }
  const auto& receiver = system_.receiver();
  for (const UndecidedPart& at : total_->undecided) {
    const Interval &u = at.part.u, &v = at.part.v;
    const UndecidedCell cell{{receiver.point({u.lo, v.lo}), receiver.point({u.hi, v.lo}),
                              receiver.point({u.hi, v.hi}), receiver.point({u.lo, v.hi})},
                             at.levels};
    add_undecided(-1, cell, [&](int i) { return levels[i]; });
  }
  end(total_->cells, total_->exhausted, "the total");
}

void Prover::add_caustic_of_total(const FamilyField& field, std::vector<ContourTask>& tasks) const {
  if (!total_ || tasks.empty()) return;
  const auto place = std::find(fields_.begin(), fields_.end(), &field) - fields_.begin();
  for (const Seed& seed : total_->boundaries[place]) {
    if (seed.target < 0) tasks.back().seeds.push_back(seed);
  }
}

std::vector<std::string> Prover::conclude(ContourResult& result) {
  result.cells += cells_;
  result.undecided_cells += undecided_.size() + found_undecided_;
  std::move(undecided_.begin(), undecided_.end(), std::back_inserter(result.undecided));
  std::move(unproven_.begin(), unproven_.end(), std::back_inserter(result.unproven));
  return std::move(cut_short_);
}

}  // namespace caustic::solver
