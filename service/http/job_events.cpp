#include "service/http/job_events.h"

namespace caustic::service {
namespace {

constexpr auto kPing = std::chrono::seconds(10);

}  // namespace

bool JobEvents::next(std::string& out) {
  const auto now = std::chrono::steady_clock::now();
  const auto report = look_();
  if (!report) return false;
  const std::string text = to_json(*report);
  if (text != last_) {
    last_ = text;
    last_sent_ = now;
    const std::string id = report->ended() ? std::string(kEndEventId) : std::to_string(++id_);
    out +=
        "id: " + id + "\nevent: " + (report->ended() ? "end" : "job") + "\ndata: " + text + "\n\n";
  } else if (now - last_sent_ > kPing) {
    last_sent_ = now;
    out += ": ping\n\n";
  }
  return !report->ended();
}

}  // namespace caustic::service
