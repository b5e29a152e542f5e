#include "service/http/routes.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "service/api/identity.h"
#include "service/api/json_text.h"
#include "service/api/problem.h"
#include "service/examples/examples.h"
#include "service/formats/format.h"
#include "service/http/caching.h"
#include "service/http/docs_page.h"
#include "service/http/job_events.h"
#include "service/http/page_response.h"
#include "service/point_service.h"

namespace caustic::service {
namespace {

using nlohmann::ordered_json;

constexpr std::size_t kMaxTarget = 1000;
constexpr std::size_t kLargeBody = 256u << 10;     // read in about 10 ms
constexpr std::uintmax_t kLargeRecord = 1u << 20;  // written as .vtp in about 10 ms

[[noreturn]] void refuse(int status, std::string detail) {
  throw ProblemError(make_problem(status, std::move(detail)));
}

HttpResponse json_response(std::string body) {
  return {200, "application/json", std::move(body), {}};
}

/// `application/json`, with parameters or without.
bool is_json(std::string type) {
  type.resize(std::min(type.size(), type.find(';')));
  while (!type.empty() && (type.back() == ' ' || type.back() == '\t')) type.pop_back();
  std::transform(type.begin(), type.end(), type.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return type == "application/json";
}

/// True if `path` is the pattern, in which {} stands for any one step, returned in `name`.
bool matches(std::string_view pattern, std::string_view path, std::string& name) {
  const auto hole = pattern.find("{}");
  if (hole == pattern.npos) return path == pattern;
  const std::string_view before = pattern.substr(0, hole), after = pattern.substr(hole + 2);
  if (path.size() <= before.size() + after.size() || !path.starts_with(before) ||
      !path.ends_with(after))
    return false;
  name = path.substr(hole, path.size() - before.size() - after.size());
  return name.find('/') == name.npos;
}

bool method_fits(std::string_view served, std::string_view asked) {
  return served == asked || (served == "GET" && asked == "HEAD");
}

std::string_view path_of_target(std::string_view target) {
  return target.substr(0, target.find('?'));
}

/// RFC 7240: `Prefer: respond-async`, among others.
bool prefers_async(const HttpRequest& request) {
  return request.header("prefer").find("respond-async") != std::string_view::npos;
}

/// The one boundary of what goes wrong with a request.
template <typename Action>
void answer_whatever_happens(Exchange& exchange, Action action) noexcept {
  try {
    action();
  } catch (const ProblemError& error) {
    exchange.answer(problem_response(error.problem()));
  } catch (const std::exception& error) {
    exchange.answer(problem_response(report_bug(error.what())));
  } catch (...) {
    exchange.answer(problem_response(report_bug("of no known type")));
  }
}

/// As the browser's own tools show it, ms.
HttpResponse with_waiting_time(const JobReport& report, HttpResponse response) {
  if (!report.waited) return response;
  char text[40];
  std::snprintf(text, sizeof text, "queue;dur=%.3f", 1e3 * *report.waited);
  response.headers.emplace_back("Server-Timing", text);
  return response;
}

/// The answer to whoever waits for this job. Who leaves waits no longer.
void answer_when_done(Jobs& jobs, const std::shared_ptr<Job>& job,
                      const std::shared_ptr<Exchange>& exchange) {
  const void* who = exchange.get();
  exchange->on_leave([&jobs, job, who] { jobs.leave(job, who); });
  job->wait(who, [exchange, &own = *job](const JobOutcome& outcome) {
    const auto* result = std::get_if<JobResult>(&outcome);
    exchange->answer(
        with_waiting_time(own.report(), result ? json_response(result->answer)
                                               : problem_response(std::get<Problem>(outcome))));
  });
}

}  // namespace

struct Routes::Row {
  const char* method;
  const char* pattern;
  bool takes_json;
  void (Routes::*handler)(const Call&);
};

// clang-format off
const Routes::Row Routes::kTable[] = {
    {"POST",   "/v1/contours",       true,  &Routes::post_contours},
    {"POST",   "/v1/paths",          true,  &Routes::post_paths},
    {"POST",   "/v1/irradiance",     true,  &Routes::post_irradiance},
    {"POST",   "/v1/analysis",       true,  &Routes::post_analysis},
    {"GET",    "/v1/results/{}",     false, &Routes::get_result},
    {"GET",    "/v1/jobs/{}",        false, &Routes::get_job},
    {"DELETE", "/v1/jobs/{}",        false, &Routes::delete_job},
    {"GET",    "/v1/jobs/{}/events", false, &Routes::get_job_events},
    {"GET",    "/v1/examples",       false, &Routes::list_examples},
    {"GET",    "/v1/examples/{}",    false, &Routes::get_example},
    {"GET",    "/healthz",           false, &Routes::health},
    {"GET",    "/readyz",            false, &Routes::ready},
    {"GET",    "/metrics",           false, &Routes::metrics},
    {"GET",    "/openapi.json",      false, &Routes::openapi},
    {"GET",    "/docs",              false, &Routes::docs},
    {"GET",    "/",                  false, &Routes::page},
    {"GET",    "/assets/{}",         false, &Routes::page},
};
// clang-format on

HttpResponse problem_response(const Problem& problem) {
  return {problem.status, "application/problem+json", to_json(problem), {}};
}

std::vector<std::pair<std::string, std::string>> Routes::all() {
  std::vector<std::pair<std::string, std::string>> out;
  for (const Row& row : kTable) out.emplace_back(row.method, row.pattern);
  return out;
}

std::string Routes::methods_of(std::string_view target) {
  std::string out, unused;
  for (const Row& row : kTable) {
    if (!matches(row.pattern, path_of_target(target), unused)) continue;
    if (!out.empty()) out += ", ";
    out += row.method == std::string_view("GET") ? "GET, HEAD" : row.method;
  }
  return out.empty() ? out : out + ", OPTIONS";
}

std::string_view Routes::pattern_of(std::string_view target) {
  std::string unused;
  for (const Row& row : kTable)
    if (matches(row.pattern, path_of_target(target), unused)) return row.pattern;
  return "other";
}

void Routes::serve(HttpRequest request, std::shared_ptr<Exchange> exchange) noexcept {
  answer_whatever_happens(*exchange, [&] { dispatch(std::move(request), exchange); });
}

void Routes::dispatch(HttpRequest request, const std::shared_ptr<Exchange>& exchange) {
  if (request.refusal) throw ProblemError(*request.refusal);
  if (request.target.size() > kMaxTarget) refuse(414, "the path is too long");
  const std::string_view path = path_of_target(request.target);
  for (const Row& row : kTable) {
    std::string name;
    if (!matches(row.pattern, path, name) || !method_fits(row.method, request.method)) continue;
    if (row.takes_json && !is_json(request.content_type))
      refuse(415, "Content-Type must be application/json");
    if (row.takes_json && request.body_too_large) refuse(413, "the body is too large");
    auto call = std::make_shared<Call>(Call{std::move(request), std::move(name), exchange});
    if (!is_chore(row, *call)) return (this->*row.handler)(*call);
    const auto chore = [this, &row, call] {
      answer_whatever_happens(*call->exchange, [&] { (this->*row.handler)(*call); });
    };
    if (!chores_.submit(chore)) refuse(503, "too many large requests are waiting");
    return;
  }
  const std::string allowed = methods_of(path);
  if (allowed.empty()) refuse(404, "nothing is here");
  HttpResponse response = problem_response(make_problem(405, "this path takes " + allowed));
  response.headers.emplace_back("Allow", allowed);
  exchange->answer(std::move(response));
}

/// What would keep a thread from other clients for long. To find the zeros of an expression takes
/// up to seconds; a key that is written with escapes may be its.
bool Routes::is_chore(const Row& row, const Call& call) const {
  const std::string& body = call.request.body;
  if (body.size() > kLargeBody) return true;
  if (row.handler == &Routes::post_contours &&
      (body.find("\"expression\"") != body.npos || body.find('\\') != body.npos))
    return true;
  return row.handler == &Routes::get_result &&
         store_.size_of(call.name.substr(0, call.name.find('.'))) > kLargeRecord;
}

// ---- Computations
// --------------------------------------------------------------------------------

void Routes::post_contours(const Call& call) {
  const auto asked = std::make_shared<ContourCall>(read_contour_call(call.request.body));
  if (const auto answer = contours_.find(*asked))
    return call.exchange->answer(json_response(*answer));
  const auto job = jobs_.start(ContourService::key_of(*asked),
                               [&contours = contours_, asked](JobControl& control) {
                                 return contours.compute(*asked, control);
                               });
  // What is stored nowhere has to be waited for.
  if (!asked->store || !prefers_async(call.request))
    return answer_when_done(jobs_, job, call.exchange);
  jobs_.keep(job);
  call.exchange->answer(
      {202,
       "application/json",
       to_json(job->report()),
       {{"Location", "/v1/jobs/" + job->id()}, {"Preference-Applied", "respond-async"}}});
}

void Routes::compute(const Call& call, Answer answer) {
  const auto job = jobs_.start("", [answer, body = call.request.body](JobControl& control) {
    return JobResult{answer(body, control.cancelled())};
  });
  answer_when_done(jobs_, job, call.exchange);
}

void Routes::post_paths(const Call& call) { compute(call, answer_paths); }
void Routes::post_irradiance(const Call& call) { compute(call, answer_irradiance); }
void Routes::post_analysis(const Call& call) { compute(call, answer_analysis); }

// ---- Jobs
// ----------------------------------------------------------------------------------------

void Routes::get_job(const Call& call) {
  const auto report = jobs_.find(call.name);
  if (!report) refuse(404, "no such job");
  call.exchange->answer(with_waiting_time(*report, json_response(to_json(*report))));
}

void Routes::delete_job(const Call& call) {
  const auto report = jobs_.dismiss(call.name);
  if (!report) refuse(404, "no such job");
  call.exchange->answer(json_response(to_json(*report)));
}

void Routes::get_job_events(const Call& call) {
  if (!jobs_.find(call.name)) refuse(404, "no such job");
  // Browsers come again when a stream ends; nothing more is the way to tell them not to.
  if (call.request.header("last-event-id") == kEndEventId)
    return call.exchange->answer({204, "", "", {}});
  HttpResponse response{200, "text/event-stream", "", {{"X-Accel-Buffering", "no"}}};
  if (call.request.method == "GET")
    response.events =
        std::make_shared<JobEvents>([&jobs = jobs_, id = call.name] { return jobs.find(id); });
  call.exchange->answer(std::move(response));
}

// ---- Results, examples
// ---------------------------------------------------------------------------

/// `<id>` is the answer, `<id>.<suffix>` a file.
void Routes::get_result(const Call& call) {
  const std::string& name = call.name;
  const std::string id = name.substr(0, name.find('.'));
  if (!is_id(id)) refuse(404, "no such result");
  if (name == id) {
    const auto answer = store_.find_answer(id);
    if (!answer) refuse(404, "no such result");
    // Computed again after an eviction it says other seconds: the tag is of the bytes.
    const std::string tag = sha256_hex(*answer).substr(0, 32);
    if (has_tag(call.request, tag)) return call.exchange->answer(not_modified(tag));
    return call.exchange->answer(immutable(call.request, tag, json_response(*answer)));
  }
  const Format* format = find_format(std::string_view(name).substr(id.size() + 1));
  if (!format) refuse(404, "no such format");
  if (has_tag(call.request, name) && store_.contains(id))
    return call.exchange->answer(not_modified(name));
  const auto record = store_.load(id);
  if (!record) refuse(404, "no such result");
  call.exchange->answer(immutable(call.request, name,
                                  {200,
                                   format->media_type,
                                   format->write(record->curves),
                                   {{"Content-Disposition", "attachment; filename=" + name}}}));
}

void Routes::list_examples(const Call& call) {
  auto list = ordered_json::array();
  for (const Example& example : examples())
    list.push_back({{"name", example.name}, {"title", example.title}});
  call.exchange->answer(json_response(write_json(ordered_json{{"examples", list}})));
}

void Routes::get_example(const Call& call) {
  const Example* example = find_example(call.name);
  if (!example) refuse(404, "no such example");
  call.exchange->answer(json_response(std::string(example->body)));
}

// ---- Operators
// -----------------------------------------------------------------------------------

void Routes::health(const Call& call) {
  call.exchange->answer(
      json_response(write_json(ordered_json{{"status", "ok"}, {"version", kEngineVersion}})));
}

void Routes::ready(const Call& call) {
  if (jobs_.full()) refuse(503, "too many computations are waiting");
  if (!store_.writable()) refuse(503, "the store cannot be written");
  call.exchange->answer(json_response(write_json(ordered_json{{"status", "ready"}})));
}

void Routes::metrics(const Call& call) {
  const std::vector<Metrics::Gauge> gauges = {
      {"isocaustic_queue_length", "Computations that wait.", double(jobs_.waiting())},
      {"isocaustic_running", "Computations that run.", double(jobs_.running())},
      {"isocaustic_store_bytes", "Bytes of the results that are stored.", double(store_.bytes())}};
  call.exchange->answer({200,
                         "text/plain; version=0.0.4; charset=utf-8",
                         metrics_ ? metrics_->text(gauges) : Metrics().text(gauges),
                         {}});
}

void Routes::openapi(const Call& call) {
  call.exchange->answer(json_response(std::string(openapi_document())));
}

void Routes::page(const Call& call) {
  const PageFile* file = find_page_file(path_of_target(call.request.target));
  if (!file) refuse(404, "nothing is here");
  call.exchange->answer(page_response(call.request, *file));
}

/// The page's own, else, in a build without it, one that needs no script.
void Routes::docs(const Call& call) {
  if (find_page_file("/docs")) return page(call);
  static const std::string page = docs_page(openapi_document());
  HttpResponse response{200,
                        "text/html; charset=utf-8",
                        page,
                        {{"Content-Security-Policy",
                          "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; "
                          "form-action 'none'; frame-ancestors 'none'"}}};
  compress(call.request, response);
  call.exchange->answer(std::move(response));
}

}  // namespace caustic::service
