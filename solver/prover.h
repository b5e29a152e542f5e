// The proof that a request may ask for: what it finds goes to the tracers as seeds, what it could
// not show to the answer.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "solver/certify_total.h"
#include "solver/contour_task.h"
#include "solver/contours.h"

namespace caustic::solver {

struct ProvenFamily {
  const FamilyField* field;
  std::string name;
};

class Prover {
 public:
  /// Both must outlive it. It has a share of the request's time for itself.
  Prover(const OpticalSystem& system, const ContourRequest& request);

  /// Adds seeds on every component of the tasks' levels, after those that exploration has found:
  /// curves that have been traced from these are not traced again.
  void prove_sheets(const FamilyField& field, const std::string& name,
                    std::vector<ContourTask>& tasks);
  /// Of all fields of the total, in its order (S77)–(S79).
  void prove_total(const std::vector<ProvenFamily>& families, const std::vector<double>& levels,
                   bool direct);
  /// Null if there was none.
  const TotalCertificate* total() const { return total_ ? &*total_ : nullptr; }
  /// If there was one, adds its seeds on the field's caustic to the last task, which traces it.
  void add_caustic_of_total(const FamilyField& field, std::vector<ContourTask>& tasks) const;

  /// Writes down cells, undecided ones and what is unproven. Returns of what the proof was cut
  /// short.
  std::vector<std::string> conclude(ContourResult& result);
  std::uint64_t evaluations() const { return budget_.evaluations(); }

 private:
  bool provable(const FamilyField& field, const std::string& name);
  void give_up(const FamilyField& field) { found_undecided_ += field.exploration.unresolved; }
  void add_undecided(int family, const UndecidedCell& cell,
                     const std::function<double(int)>& level_of);
  void end(std::size_t cells, bool exhausted, const std::string& of);

  const OpticalSystem& system_;
  const ContourRequest& request_;
  Budget budget_;
  std::optional<TotalCertificate> total_;
  std::vector<const FamilyField*> fields_;  // of the total
  std::vector<Undecided> undecided_;
  std::size_t cells_ = 0,
              found_undecided_ = 0;  // the latter by exploration, where nothing is proven
  std::vector<std::string> unproven_, cut_short_;
};

}  // namespace caustic::solver
