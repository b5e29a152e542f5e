#include "service/cli/progress_bar.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <string>

namespace caustic::service {
namespace {

constexpr auto kPatience = std::chrono::seconds(1);
constexpr int kWidth = 40;

}  // namespace

ProgressBar::ProgressBar() : start_(std::chrono::steady_clock::now()) {}

ProgressBar::~ProgressBar() {
  if (shown_percent_ >= 0) std::fputs("\r\033[K", stderr);
}

std::function<void(double)> ProgressBar::callback() {
  if (!isatty(STDERR_FILENO)) return {};
  return [this](double share) { show(share); };
}

void ProgressBar::show(double share) {
  const int percent = static_cast<int>(100.0 * std::clamp(share, 0.0, 1.0));
  if (percent == shown_percent_ || std::chrono::steady_clock::now() - start_ < kPatience) return;
  shown_percent_ = percent;
  const int filled = percent * kWidth / 100;
  std::fprintf(stderr, "\r[%s%s] %3d %%", std::string(filled, '#').c_str(),
               std::string(kWidth - filled, '.').c_str(), percent);
}

}  // namespace caustic::service
