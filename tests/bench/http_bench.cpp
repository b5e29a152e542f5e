// The round trip as a client sees it: POST of a request, GET of its .vtp, each on a connection of
// its own, against the program itself; its store is on tmpfs. Every scene is another, so that no
// answer is known before.
#include <benchmark/benchmark.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "service/examples/examples.h"
#include "tests/bench/samples.h"
#include "tests/support/http_client.h"
#include "tests/support/program.h"
#include "tests/support/temporary_folder.h"

namespace caustic::bench {
namespace {

using nlohmann::json;

class Client {
 public:
  explicit Client(std::string_view example)
      : body_(json::parse(service::find_example(example)->body)) {
    body_["measure"] = "sheet";
  }

  /// Moves the light by a hair, and asks for other files than ever.
  std::string next_body(double chord = 0.0) {
    auto& x = body_["scene"]["light"]["position"][0];
    x = x.get<double>() * (1.0 + 1e-6);
    if (chord > 0.0) body_["tolerance"]["chord"] = chord;
    return body_.dump();
  }
  /// False if the server does not do what it should.
  bool round_trip(const std::string& body) {
    test::HttpReply answer;
    post.time([&] { answer = test::http_post(server_.port(), "/v1/contours", body); });
    if (answer.status != 200) return false;
    const auto begin = answer.body.find("/v1/results/"), end = answer.body.find('"', begin);
    if (begin == std::string::npos) return false;
    std::string target = answer.body.substr(begin, end - begin);
    target = target.substr(0, target.rfind('.')) + ".vtp";
    test::HttpReply file;
    get.time([&] { file = test::http_get(server_.port(), target); });
    return file.status == 200 && file.body.find("VTKFile") != std::string::npos;
  }
  long peak_memory() const { return server_.peak_memory(); }

  Samples post, get;

 private:
  json body_;
  test::TemporaryFolder store_{"/dev/shm"};
  test::ServerProcess server_{store_.path()};
};

void round_trip(benchmark::State& state, const char* example) {
  Client client(example);
  Samples samples;
  for (auto _ : state) {
    const std::string body = client.next_body();
    bool good = false;
    samples.time([&] { good = client.round_trip(body); });
    if (!good) return state.SkipWithError("no answer");
  }
  samples.report_milliseconds(state);
  state.counters["post_ms"] = 1e3 * client.post.median();
  state.counters["get_ms"] = 1e3 * client.get.median();
}
BENCHMARK_CAPTURE(round_trip, ellipsoid_bowl, "ellipsoid-bowl")->Name("http/ellipsoid_bowl");
BENCHMARK_CAPTURE(round_trip, A1_sphere_ceiling, "sphere-ceiling")->Name("http/A1_sphere_ceiling");

// Largest resident set after a thousand requests of 500 … 10,000 vertices.
void memory(benchmark::State& state) {
  Client client("ellipsoid-bowl");
  int i = 0;
  for (auto _ : state) {
    const double chords[] = {0.2, 0.02, 0.002, 0.00045};
    if (!client.round_trip(client.next_body(chords[i++ % 4])))
      return state.SkipWithError("no answer");
  }
  state.counters["peak_MiB"] = static_cast<double>(client.peak_memory()) / 1024.0;
}
BENCHMARK(memory)->Name("http/memory")->Iterations(1000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace caustic::bench
