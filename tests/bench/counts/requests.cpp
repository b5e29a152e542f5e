// What a request costs the service: reading, the solver, writing; and the answer to a POST, without
// its socket.
#include <nlohmann/json.hpp>

#include "service/api/answer_json.h"
#include "service/contour_service.h"
#include "service/examples/examples.h"
#include "service/formats/format.h"
#include "service/point_service.h"
#include "tests/bench/counts/subject.h"
#include "tests/support/temporary_folder.h"

namespace caustic::bench {
namespace {

using service::ContourCall;

// Under callgrind everything takes fifty times as long.
constexpr double kPatience = 3600.0;

ContourCall example_call(std::string_view name) {
  ContourCall call = service::read_contour_call(service::find_example(name)->body);
  call.request.time_limit = kPatience;
  return call;
}

solver::ContourResult traced(const ContourCall& call) {
  return solver::trace_contours(call.system, call.request);
}

// The example from its text to the answer, as the program traces it, in vertices.
Work whole(std::string_view name) {
  const auto answer = [=] {
    const ContourCall call = example_call(name);
    solver::ContourResult result = traced(call);
    const service::PolylineSet curves = to_polylines(call, result);
    keep(answer_json(call, result, result_id(call, result), true));
    return curves.vertices.size();
  };
  return {answer, answer()};
}

Work reading(std::string_view name) {
  const std::string_view body = service::find_example(name)->body;
  return {[=] { keep(service::read_contour_call(body).id); }, body.size()};
}

Work writing(const service::Format& format) {
  const ContourCall call = example_call("ellipsoid-bowl");
  solver::ContourResult result = traced(call);
  const service::PolylineSet curves = to_polylines(call, result);
  return {[=, write = format.write] { keep(write(curves).size()); }, curves.vertices.size()};
}

// What the service does of a POST and a GET of the .vtp between sockets; each scene is new to it.
Work post_and_get() {
  struct Service {
    test::TemporaryFolder folder;
    service::ResultStore store{folder.path()};
    service::ContourService contours{solver::trace_contours, store};
    nlohmann::json body = nlohmann::json::parse(service::find_example("ellipsoid-bowl")->body);
  };
  const auto service = std::make_shared<Service>();
  return {[=] {
            auto& x = service->body["scene"]["light"]["position"][0];
            x = x.get<double>() * (1.0 + 1e-6);
            const auto answer = nlohmann::json::parse(service->contours.post(service->body.dump()));
            const auto record = service->store.load(answer["id"]);
            keep(service::write_vtp(record->curves));
          },
          1};
}

Work analysis(std::string_view name) {
  nlohmann::json body = nlohmann::json::parse(service::find_example(name)->body);
  nlohmann::json asked{{"scene", body["scene"]}, {"levels", body["levels"]}};
  return {[text = asked.dump()] { keep(service::answer_analysis(text)); }, 1};
}

}  // namespace

void add_requests(Subjects& subjects) {
  for (const service::Format& format : service::formats()) {
    subjects.push_back({std::string("writing/") + format.suffix, "vertices",
                        [&format] { return writing(format); }});
  }
  for (const char* name : {"ellipsoid-bowl", "freeform-heights"})
    subjects.push_back({std::string("reading/") + name, "bytes", [=] { return reading(name); }});
  subjects.push_back({"post_and_get/ellipsoid-bowl", "round trips", post_and_get});
  subjects.push_back(
      {"analysis/sphere-ceiling", "requests", [] { return analysis("sphere-ceiling"); }});
  for (const service::Example& example : service::examples()) {
    subjects.push_back({"example/" + std::string(example.name), "vertices",
                        [name = example.name] { return whole(name); }});
  }
}

}  // namespace caustic::bench
