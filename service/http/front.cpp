#include "service/http/front.h"

#include <openssl/crypto.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <nlohmann/json.hpp>

#include "service/api/identity.h"
#include "service/http/routes.h"
#include "service/page/page_files.h"

namespace caustic::service {
namespace {

using Clock = std::chrono::steady_clock;

constexpr std::size_t kMaxRequestId = 64, kMostLoggedTarget = 200;
constexpr const char* kRetrySeconds = "1";

/// The client's own name of the request if it is a plain one, else a new one.
std::string request_id(std::string_view given) {
  const bool plain = !given.empty() && given.size() <= kMaxRequestId &&
                     std::all_of(given.begin(), given.end(), [](unsigned char c) {
                       return std::isalnum(c) || c == '-' || c == '_' || c == '.';
                     });
  if (plain) return std::string(given);
  static const std::string process = random_id().substr(0, 12);
  static std::atomic<std::uint64_t> next = 1;
  return process + '-' + std::to_string(next++);
}

/// UTC to the millisecond, as RFC 3339 has it.
std::string now_as_text() {
  timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  tm parts;
  gmtime_r(&now.tv_sec, &parts);
  char text[40];
  const std::size_t size = std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts);
  std::snprintf(text + size, sizeof text - size, ".%03ldZ", now.tv_nsec / 1'000'000);
  return text;
}

}  // namespace

/// The way back, on which each answer gets what all have, is counted and logged.
class Front::Answering : public Exchange {
 public:
  Answering(const Front& front, const HttpRequest& request, std::shared_ptr<Exchange> exchange)
      : front_(front),
        exchange_(std::move(exchange)),
        method_(request.method),
        target_(request.target),
        id_(request.id),
        peer_(request.peer),
        origin_(request.header("origin")),
        bytes_in_(request.body.size()),
        begin_(Clock::now()) {}

  void on_leave(std::function<void()> leave) override { exchange_->on_leave(std::move(leave)); }

  void answer(HttpResponse response) override {
    HttpHeaders& headers = response.headers;
    headers.emplace_back("X-Request-Id", id_);
    headers.emplace_back("X-Content-Type-Options", "nosniff");
    const auto has = [&](std::string_view name) {
      return std::any_of(headers.begin(), headers.end(),
                         [&](const auto& header) { return header.first == name; });
    };
    if (!has("Cache-Control")) headers.emplace_back("Cache-Control", "no-store");
    if (response.status == 503) headers.emplace_back("Retry-After", kRetrySeconds);
    if (!front_.options_.origins.empty()) headers.emplace_back("Vary", "Origin");
    if (front_.is_friend(origin_)) {
      headers.emplace_back("Access-Control-Allow-Origin", origin_);
      headers.emplace_back("Access-Control-Expose-Headers",
                           "ETag, Location, Preference-Applied, Retry-After, Server-Timing, "
                           "X-Request-Id");
    }
    note(response);
    exchange_->answer(std::move(response));
  }

 private:
  void note(const HttpResponse& response) const {
    const std::chrono::duration<double> seconds = Clock::now() - begin_;
    const std::string_view route = Routes::pattern_of(target_);
    front_.metrics_.count_request(std::string(route), response.status, seconds.count());
    if (!front_.log_) return;
    const nlohmann::ordered_json line{{"time", now_as_text()},
                                      {"id", id_},
                                      {"peer", peer_},
                                      {"method", method_},
                                      {"target", target_.substr(0, kMostLoggedTarget)},
                                      {"status", response.status},
                                      {"bytes_in", bytes_in_},
                                      {"bytes_out", response.body.size()},
                                      {"ms", std::round(1e6 * seconds.count()) / 1e3}};
    front_.log_->write(line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  }

  const Front& front_;
  const std::shared_ptr<Exchange> exchange_;
  const std::string method_, target_, id_, peer_, origin_;
  const std::size_t bytes_in_;
  const Clock::time_point begin_;
};

Front::Front(HttpHandler routes, const FrontOptions& options, Metrics& metrics, LogLines* log)
    : routes_(std::move(routes)),
      options_(options),
      token_digest_(sha256_hex(options.token)),
      metrics_(metrics),
      log_(log) {}

bool Front::is_friend(std::string_view origin) const {
  return !origin.empty() && std::find(options_.origins.begin(), options_.origins.end(), origin) !=
                                options_.origins.end();
}

/// Digests have one length, so comparing them takes one time, whatever was sent.
bool Front::may_ask(const HttpRequest& request) const {
  if (options_.token.empty() || request.refusal) return true;
  const std::string_view path =
      std::string_view(request.target).substr(0, request.target.find('?'));
  if (path == "/healthz" || path == "/readyz") return true;
  // The page has to be there before it can ask for a token; it is the same for everybody.
  if (find_page_file(path)) return true;
  std::string_view shown = request.header("authorization");
  constexpr std::string_view kScheme = "Bearer ";
  if (!shown.starts_with(kScheme)) return false;
  shown.remove_prefix(kScheme.size());
  const std::string digest = sha256_hex(shown);
  return CRYPTO_memcmp(digest.data(), token_digest_.data(), digest.size()) == 0;
}

/// Browsers ask so before they let a page of another origin ask, and show no token yet.
bool Front::asks_for_methods(const HttpRequest& request) const {
  return request.method == "OPTIONS" && !request.refusal &&
         !Routes::methods_of(request.target).empty() &&
         (!options_.origins.empty() || may_ask(request));
}

HttpResponse Front::methods(const HttpRequest& request) const {
  const std::string methods = Routes::methods_of(request.target);
  HttpResponse response{204, "", "", {{"Allow", methods}}};
  if (is_friend(request.header("origin"))) {
    response.headers.emplace_back("Access-Control-Allow-Methods", methods);
    response.headers.emplace_back("Access-Control-Allow-Headers",
                                  "Authorization, Content-Type, If-None-Match, Last-Event-ID, "
                                  "Prefer, X-Request-Id");
    response.headers.emplace_back("Access-Control-Max-Age", "600");
  }
  return response;
}

void Front::operator()(HttpRequest request, std::shared_ptr<Exchange> exchange) const {
  request.id = request_id(request.header("x-request-id"));
  const auto answering = std::make_shared<Answering>(*this, request, std::move(exchange));
  if (asks_for_methods(request)) return answering->answer(methods(request));
  if (may_ask(request)) return routes_(std::move(request), answering);
  HttpResponse response =
      problem_response(make_problem(401, "a token is needed: Authorization: Bearer ..."));
  response.headers.emplace_back("WWW-Authenticate", "Bearer");
  answering->answer(std::move(response));
}

}  // namespace caustic::service
