#include "tests/stress/report.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <ostream>

namespace caustic::stress {
namespace {

using nlohmann::json;

/// Whatever an answer warns of, it ends in time and is made of numbers. Cells that it counts as
/// undecided may hide a curve that is missing, but do not make one wrong that is there.
bool is_excused(const json& outcome, const std::string& check) {
  if (check == "finite" || check == "time") return false;
  if (outcome["warned"]) return true;
  constexpr const char* kOfWhatIsMissing[] = {"inside", "rays",     "moved",
                                              "scaled", "mirrored", "permuted"};
  return outcome["undecided"] > 0 &&
         std::find(std::begin(kOfWhatIsMissing), std::end(kOfWhatIsMissing), check) !=
             std::end(kOfWhatIsMissing);
}

std::string shapes_of(const json& request) {
  std::string out;
  if (!request.contains("scene")) return out;
  for (const json& surface : request["scene"]["surfaces"])
    out += (out.empty() ? "" : ", ") + surface["shape"]["type"].get<std::string>();
  return out + (request.value("measure", "") == "total" ? "; total" : "; sheet") +
         (request.value("certify", false) ? ", certify" : "");
}

}  // namespace

void Report::keep(std::uint64_t k, const std::string& check, const std::string& text, bool warned,
                  const json& request) {
  out_ << (warned ? "warned  " : "FAILED  ") << k << ' ' << check << ": " << text << '\n';
  if (!warned) out_ << "        " << request.dump() << '\n';
  out_.flush();
  if (folder_.empty()) return;
  std::ofstream file(folder_ + '/' + check + (warned ? "-warned-" : "-") + std::to_string(k) +
                     ".json");
  file << request.dump(1) << '\n';
}

void Report::add(std::uint64_t k, const json& o, const json& request) {
  ++scenes_;
  if (o.contains("refused")) {
    ++refused_;
    if (!folder_.empty())
      std::ofstream(folder_ + "/refused-" + std::to_string(k) + ".json")
          << request.dump(1) << o["refused"];
    return;
  }
  const bool warned = o["warned"];
  const double seconds = o["seconds"];
  const std::uint64_t evaluations = o["evaluations"], vertices = o["vertices"];
  empty_ += vertices == 0;
  incomplete_ += !o["complete"].get<bool>();
  warned_ += warned;
  seconds_ += seconds;
  evaluations_ += evaluations;
  vertices_ += vertices;
  for (const std::string code : o["codes"]) ++codes_[code];
  for (const json& asked : o["asked"]) {
    Count& count = checks_[asked[0]];
    ++count.asked;
    count.seconds += asked[1].get<double>();
  }
  bool bad = false;
  for (const json& finding : o["findings"]) {
    const std::string check = finding[0];
    const bool excused = is_excused(o, check);
    keep(k, check, finding[1], excused, request);
    ++(excused ? checks_[check].warned : checks_[check].failed);
    bad = bad || !excused;
  }
  failed_ += bad;
  slow_.push_back({seconds, k, evaluations, shapes_of(request)});
  std::sort(slow_.begin(), slow_.end(),
            [](const Slow& a, const Slow& b) { return a.seconds > b.seconds; });
  if (slow_.size() > 20) slow_.pop_back();
}

void Report::died(std::uint64_t k, const std::string& why, const json& request) {
  ++scenes_;
  if (why == "out of time, while checked") {
    ++unchecked_;
    return keep(k, "unchecked", why, true, request);
  }
  ++failed_;
  auto& count = checks_["survives"];
  ++count.failed;
  keep(k, "survives", why, false, request);
}

void Report::print() const {
  char line[200];
  const auto put = [&](const char* format, auto... values) {
    std::snprintf(line, sizeof line, format, values...);
    out_ << line;
  };
  out_ << "\n| scenes | refused | checks out of time | without light | warned | cut by a limit | "
          "failed | CPU s | evaluations | vertices |\n"
          "|---|---|---|---|---|---|---|---|---|---|\n";
  put("| %d | %d | %d | %d | %d | %d | %d | %.0f | %.3g | %.3g |\n", scenes_, refused_, unchecked_,
      empty_, warned_, incomplete_, failed_, seconds_, static_cast<double>(evaluations_),
      static_cast<double>(vertices_));
  out_ << "\n| check | asked | failed | failed, and the answer warns | CPU s "
          "|\n|---|---|---|---|---|\n";
  for (const auto& [name, count] : checks_)
    put("| %s | %d | %d | %d | %.0f |\n", name.c_str(), count.asked, count.failed, count.warned,
        count.seconds);
  out_ << "\n| warning | scenes |\n|---|---|\n";
  for (const auto& [code, count] : codes_) put("| %s | %d |\n", code.c_str(), count);
  out_ << "\n| slowest | CPU s | evaluations | what |\n|---|---|---|---|\n";
  for (const Slow& s : slow_) {
    put("| %lu | %.2f | %lu | ", static_cast<unsigned long>(s.k), s.seconds,
        static_cast<unsigned long>(s.evaluations));
    out_ << s.what << " |\n";
  }
}

}  // namespace caustic::stress
