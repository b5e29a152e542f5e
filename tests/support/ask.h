// Asks routes without a server, and waits for the answer.
#pragma once

#include <future>

#include "service/http/routes.h"

namespace caustic::test {

class WaitingExchange : public service::Exchange {
 public:
  void answer(service::HttpResponse response) override { promise_.set_value(std::move(response)); }
  void on_leave(std::function<void()> leave) override { leave_ = std::move(leave); }

  service::HttpResponse wait() { return promise_.get_future().get(); }
  /// The client goes without waiting.
  void leave() {
    if (leave_) leave_();
  }

 private:
  std::promise<service::HttpResponse> promise_;
  std::function<void()> leave_;
};

/// The value of this header, empty if there is none.
inline std::string header(const service::HttpResponse& response, const std::string& name) {
  for (const auto& [key, value] : response.headers)
    if (key == name) return value;
  return "";
}

inline service::HttpResponse ask(service::Routes& routes, service::HttpRequest request) {
  const auto exchange = std::make_shared<WaitingExchange>();
  routes.serve(std::move(request), exchange);
  return exchange->wait();
}

}  // namespace caustic::test
