// A check that cannot fail proves nothing: each is shown a sound answer, and the same with a fault
// planted that it is there to find.
#include "tests/stress/checks.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/stress/batches.h"
#include "tests/stress/random_scene.h"
#include "tests/stress/scene_run.h"
#include "tests/support/requests.h"

namespace caustic::stress {
namespace {

using solver::CurveKind;
using solver::Ending;

/// A torus beside its lamp: open and closed curves, ends of several names.
json torus_request(const char* measure) {
  json request = test::ball_request();
  request["scene"]["light"]["position"] = {3, 0, 2};
  request["scene"]["surfaces"][0]["shape"] = {{"type", "torus"},
                                              {"center", {0, 0, 0}},
                                              {"axis", {0, 0, 1}},
                                              {"major_radius", 1.5},
                                              {"minor_radius", 0.5}};
  request["scene"]["receiver"]["origin"] = {0, 0, 4};
  request["scene"]["receiver"]["size"] = {8, 8};
  request["levels"] = {0.004, 0.01};
  request["measure"] = measure;
  request["tolerance"] = {{"chord", 0.01}};
  return request;
}

class PlantedFault : public testing::Test {
 protected:
  explicit PlantedFault(const char* measure = "sheet")
      : trial_(run_trial(torus_request(measure))), oracle_(trial_.request["scene"]) {}

  Finding found(Check check) const { return check({trial_, oracle_, 7, 3}); }
  void expect_found_after(Check check, const std::function<void(Trial&)>& plant) {
    const auto before = found(check);
    EXPECT_FALSE(before) << *before;
    Trial sound = trial_;
    plant(trial_);
    EXPECT_TRUE(found(check));
    trial_ = std::move(sound);
  }
  static solver::Curve& first(Trial& trial, CurveKind kind, bool closed = false) {
    for (solver::Curve& c : trial.result.curves)
      if (c.kind == kind && c.closed == closed) return c;
    throw std::runtime_error("the scene has no such curve");
  }

  Trial trial_;
  Oracle oracle_;
};

class PlantedInTotal : public PlantedFault {
 protected:
  PlantedInTotal() : PlantedFault("total") {}
};

TEST_F(PlantedFault, InNumbers) {
  expect_found_after(check_finite, [](Trial& t) { t.curves.vertices[3].gradient[1] = NAN; });
  expect_found_after(check_time, [](Trial& t) { t.cpu = t.call.request.time_limit + 1.0; });
}

TEST_F(PlantedFault, InAVertex) {
  // Ten tolerances off, in E and on the receiver.
  expect_found_after(check_vertices, [](Trial& t) {
    for (auto& c : t.result.curves) c.level *= 1.0 + 10.0 * t.call.request.irradiance_tolerance;
  });
  expect_found_after(check_vertices, [](Trial& t) {
    for (auto& c : t.result.curves) c.vertices.front().uv.x() += 1e-9;
  });
  expect_found_after(check_vertices, [](Trial& t) {
    for (auto& c : t.result.curves) c.parity = -c.parity;
  });
  expect_found_after(check_vertices, [](Trial& t) {
    for (auto& c : t.result.curves) c.vertices.front().irradiance *= 1.0 + 1e-7;
  });
  expect_found_after(check_vertices, [](Trial& t) {
    solver::CurveVertex& v = first(t, CurveKind::caustic).vertices.front();
    const solver::CurveVertex& next = first(t, CurveKind::isolux).vertices.front();
    v = next;
  });
}

TEST_F(PlantedFault, InAGradient) {
  expect_found_after(check_gradients, [](Trial& t) {
    for (auto& c : t.result.curves) c.vertices.front().gradient *= 1.0 + 1e-5;
  });
  expect_found_after(check_gradients, [](Trial& t) {  // turned, or out of the receiver's plane
    for (auto& c : t.result.curves)
      c.vertices.front().gradient += 1e-5 * c.vertices.front().gradient.norm() * Vec3(1, 2, 3);
  });
}

TEST_F(PlantedFault, BetweenVertices) {
  expect_found_after(check_chords, [](Trial& t) {
    for (auto& c : t.result.curves) {  // of four vertices one is left
      std::size_t left = 0;
      for (std::size_t i = 0; i < c.vertices.size(); i += 4) c.vertices[left++] = c.vertices[i];
      c.vertices.resize(left);
    }
  });
}

TEST_F(PlantedFault, InTheNameOfAnEnd) {
  for (const Ending wrong :
       {Ending::silhouette, Ending::aperture, Ending::shadow, Ending::occlusion,
        Ending::total_internal_reflection, Ending::receiver_edge, Ending::limit, Ending::node}) {
    expect_found_after(check_ends, [wrong](Trial& t) {
      for (auto& c : t.result.curves)
        for (Ending& end : c.ends) end = end == wrong ? Ending::aperture : wrong;
    });
  }
}

TEST_F(PlantedFault, TwiceTheSameCurve) {
  expect_found_after(check_once,
                     [](Trial& t) { t.result.curves.push_back(first(t, CurveKind::isolux)); });
  expect_found_after(check_once, [](Trial& t) {  // a part of it, the other way
    solver::Curve part = first(t, CurveKind::isolux);
    part.vertices.resize(part.vertices.size() / 2);
    std::reverse(part.vertices.begin(), part.vertices.end());
    t.result.curves.push_back(part);
  });
}

TEST_F(PlantedFault, BehindABlocker) {
  EXPECT_FALSE(found(check_seen));
  json scene = trial_.request["scene"];
  scene["surfaces"].push_back(
      {{"name", "screen"},
       {"shape", {{"type", "plane"}, {"point", {0, 0, 3}}, {"normal", {0, 0, 1}}}},
       {"optics", {{"type", "absorb"}}}});
  const Oracle with_screen(scene);
  EXPECT_TRUE(check_seen({trial_, with_screen, 7}));
}

TEST_F(PlantedFault, ACurveIsMissing) {
  const auto drop = [](Trial& t) {
    const double level = t.result.levels[0];
    std::erase_if(t.result.curves, [&](const solver::Curve& c) { return c.level == level; });
  };
  for (const Check check : {check_rays, check_moved, check_scaled, check_mirrored})
    expect_found_after(check, drop);
}

TEST_F(PlantedInTotal, ACurveIsMissing) {
  expect_found_after(check_inside, [](Trial& t) {
    const double level = t.result.levels[0];
    std::erase_if(t.result.curves, [&](const solver::Curve& c) { return c.level == level; });
  });
  expect_found_after(check_rings, [](Trial& t) {
    for (auto& c : t.result.curves)
      if (!c.closed) c.vertices.pop_back();
  });
}

TEST_F(PlantedInTotal, OnAnArc) {
  expect_found_after(check_meter, [](Trial& t) {
    for (auto& c : t.result.curves)
      if (c.kind == CurveKind::isolux) c.level *= 1.0 + 1e-7;
  });
  expect_found_after(check_meter, [](Trial& t) {
    for (auto& c : t.result.curves)
      if (c.kind == CurveKind::isolux) std::reverse(c.vertices.begin(), c.vertices.end());
  });
  expect_found_after(check_meter, [](Trial& t) {
    for (auto& c : t.result.curves)
      for (auto& v : c.vertices) v.dark *= 0.5;
  });
}

TEST_F(PlantedInTotal, InAnEstimate) {
  solver::ContourRequest request = trial_.call.request;
  solver::Analysis analysis = solver::analyse(trial_.call.system, request);
  const Subject subject{trial_, oracle_, 7, 3};
  ASSERT_FALSE(analysis.levels.empty());
  const auto before = wrong_estimates(subject, analysis);
  EXPECT_FALSE(before) << *before;
  auto area = analysis, flux = analysis, least = analysis;
  area.levels[0].area.value = 64.0;  // all of the receiver
  EXPECT_TRUE(wrong_estimates(subject, area));
  flux.levels[0].flux.value *= 0.3;
  EXPECT_TRUE(wrong_estimates(subject, flux));
  least.min.E.value = 2.0 * least.average.value;
  EXPECT_TRUE(wrong_estimates(subject, least));
}

TEST(Transforms, OfSurfacesInAnotherOrder) {
  json request = torus_request("sheet");
  request["scene"]["surfaces"].push_back(
      {{"name", "plate"},
       {"shape", {{"type", "plane"}, {"point", {0, 0, -1}}, {"normal", {0, 0, 1}}}},
       {"aperture", {{{"type", "box"}, {"min", {-3, -3, -2}}, {"max", {3, 3, 0}}}}},
       {"optics", {{"type", "mirror"}}}});
  Trial trial = run_trial(request);
  const Oracle oracle(request["scene"]);
  const auto before = check_permuted({trial, oracle, 7});
  EXPECT_FALSE(before) << *before;
  std::erase_if(trial.result.curves, [](const solver::Curve& c) { return c.family_id == 1; });
  EXPECT_TRUE(check_permuted({trial, oracle, 7}));
}

TEST(Batches, OutliveTheirScenes) {
  std::vector<std::string> ends(8);
  run_batches(
      {0, 8, 2, 4},
      [](std::uint64_t k, const Voice& voice) {
        voice.say({{"making", k}}, 1);
        if (k == 2) std::abort();
        while (k == 5) {
        }
        if (k == 6) std::_Exit(4);
        voice.say({{"done", true}}, 1);
      },
      [&](std::uint64_t k, const json& line) {
        if (line.contains("done")) ends[k] = "done";
        if (line.contains("died")) ends[k] = line["died"];
      });
  EXPECT_EQ(ends, (std::vector<std::string>{"done", "done", "signal Aborted", "done", "done",
                                            "out of time", "exit status 4", "done"}));
}

/// Requests that once crashed, or had a wrong answer.
TEST(Mended, StaysSo) {
  int seen = 0;
  for (const auto& file : std::filesystem::directory_iterator(ISOCAUSTIC_MENDED)) {
    SCOPED_TRACE(file.path().filename());
    std::ifstream in(file.path());
    const json outcome = outcome_of(json::parse(in), 1, 0, Thoroughness::quick(), [] {});
    EXPECT_FALSE(outcome.contains("refused"));
    for (const json& finding : outcome.value("findings", json::array())) ADD_FAILURE() << finding;
    ++seen;
  }
  EXPECT_GT(seen, 0);
}

TEST(RandomScene, IsTheSameForTheSameSeed) {
  EXPECT_EQ(random_request(3, 14), random_request(3, 14));
  EXPECT_NE(random_request(3, 14), random_request(3, 15));
}

}  // namespace
}  // namespace caustic::stress
