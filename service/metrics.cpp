#include "service/metrics.h"

#include <algorithm>
#include <sstream>
#include <tuple>

namespace caustic::service {
namespace {

void add_metric_head(std::ostream& out, const char* name, const char* type, const char* help) {
  out << "# HELP " << name << ' ' << help << "\n# TYPE " << name << ' ' << type << '\n';
}

}  // namespace

void Metrics::count_request(const std::string& route, int status, double seconds) {
  const auto bucket = std::lower_bound(kBounds.begin(), kBounds.end(), seconds) - kBounds.begin();
  const std::lock_guard lock(mutex_);
  ++requests_[{route, status}];
  ++histogram_[static_cast<std::size_t>(bucket)];
  seconds_ += seconds;
}

void Metrics::count_result(const solver::ContourResult& result) {
  evaluations_ += result.evaluations;
  const std::lock_guard lock(mutex_);
  for (const solver::Curve& curve : result.curves) {
    if (curve.closed) ++curves_["closed"];
    for (const solver::Ending ending : curve.ends) ++curves_[solver::to_string(ending)];
  }
}

std::string Metrics::text(const std::vector<Gauge>& gauges) const {
  std::ostringstream out;
  const std::lock_guard lock(mutex_);
  add_metric_head(out, "isocaustic_requests_total", "counter", "Answers by route and status.");
  for (const auto& [key, count] : requests_)
    out << "isocaustic_requests_total{route=\"" << key.first << "\",status=\"" << key.second
        << "\"} " << count << '\n';
  add_metric_head(out, "isocaustic_request_seconds", "histogram",
                  "From the last byte of a request to the first of its answer.");
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < histogram_.size(); ++i) {
    sum += histogram_[i];
    out << "isocaustic_request_seconds_bucket{le=\"";
    (i < kBounds.size() ? out << kBounds[i] : out << "+Inf") << "\"} " << sum << '\n';
  }
  out << "isocaustic_request_seconds_sum " << seconds_ << "\nisocaustic_request_seconds_count "
      << sum << '\n';
  add_metric_head(out, "isocaustic_curves_total", "counter",
                  "Traced curves: closed ones, and both ends of each open one.");
  for (const auto& [ending, count] : curves_)
    out << "isocaustic_curves_total{ending=\"" << ending << "\"} " << count << '\n';
  const std::tuple<const char*, const char*, std::uint64_t> counters[] = {
      {"isocaustic_evaluations_total", "Evaluations of irradiance.", evaluations_},
      {"isocaustic_cache_hits_total", "Requests for curves answered from the store.", cache_hits_},
      {"isocaustic_cache_misses_total", "Requests for curves that were computed.", cache_misses_}};
  for (const auto& [name, help, value] : counters) {
    add_metric_head(out, name, "counter", help);
    out << name << ' ' << value << '\n';
  }
  for (const Gauge& gauge : gauges) {
    add_metric_head(out, gauge.name, "gauge", gauge.help);
    out << gauge.name << ' ' << gauge.value << '\n';
  }
  return out.str();
}

}  // namespace caustic::service
