// The main job over the wire: post a scene, download its files, read them with VTK's own readers
// and with one that VTK did not write.
#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkPolyDataReader.h>
#include <vtkXMLPolyDataReader.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/support/http_client.h"
#include "tests/support/program.h"
#include "tests/support/requests.h"
#include "tests/support/temporary_folder.h"

namespace caustic::test {
namespace {

using nlohmann::json;

class DownloadTest : public testing::Test {
 protected:
  json post(const json& request) {
    const HttpReply reply = http_post(server.port(), "/v1/contours", request.dump());
    EXPECT_EQ(reply.status, 200) << reply.body;
    return json::parse(reply.body);
  }
  /// Downloads one format into the folder.
  std::string download(const json& answer, const std::string& format) {
    const HttpReply reply = http_get(server.port(), answer["files"][format]);
    EXPECT_EQ(reply.status, 200);
    const auto path = folder.path() / ("download." + format);
    std::ofstream(path, std::ios::binary) << reply.body;
    return path.string();
  }

  TemporaryFolder folder;
  ServerProcess server{folder.path() / "data"};
};

/// Vertices as a file has them: a closed curve comes back to its first.
std::size_t file_vertices(const json& curve) {
  return curve["vertices"].get<std::size_t>() + (curve["closed"] ? 1 : 0);
}

void expect_curves(vtkPolyData* data, const json& answer) {
  ASSERT_EQ(data->GetNumberOfLines(), std::ssize(answer["curves"]));
  for (vtkIdType i = 0; i < data->GetNumberOfLines(); ++i)
    EXPECT_EQ(data->GetLines()->GetCellSize(i),
              static_cast<vtkIdType>(file_vertices(answer["curves"][i])));
}

TEST_F(DownloadTest, vtk_reads_both_files) {
  const json answer = post(ball_request());
  ASSERT_GE(answer["curves"].size(), 2u);
  vtkNew<vtkXMLPolyDataReader> xml;
  xml->SetFileName(download(answer, "vtp").c_str());
  xml->Update();
  expect_curves(xml->GetOutput(), answer);
  vtkNew<vtkPolyDataReader> legacy;
  legacy->SetFileName(download(answer, "vtk").c_str());
  legacy->Update();
  expect_curves(legacy->GetOutput(), answer);
}

TEST_F(DownloadTest, another_reader_reads_both_files) {
  json request = ball_request();
  const std::string name = "<b&\"'> é😀 ]]> 100%";
  surface(request)["name"] = name;
  const json answer = post(request);
  for (const char* format : {"vtp", "vtk"}) {
    const auto result = run_command({"python3", ISOCAUSTIC_READ_VTK, download(answer, format)});
    ASSERT_EQ(result.exit_code, 0) << result.err;
    const json file = json::parse(result.out);
    ASSERT_EQ(file["lines"].size(), answer["curves"].size());
    for (std::size_t i = 0; i < answer["curves"].size(); ++i) {
      const json &line = file["lines"][i], &curve = answer["curves"][i];
      EXPECT_EQ(line.size(), file_vertices(curve));
      EXPECT_EQ(line.front() == line.back(), curve["closed"].get<bool>());
      const double level = curve["level"].is_null() ? -1.0 : curve["level"].get<double>();
      EXPECT_NEAR(file["cell_data"]["level"][i], level, 1e-10 * std::abs(level));
      EXPECT_EQ(file["cell_data"]["curve_id"][i], i);
      for (const json& vertex : line)
        EXPECT_NEAR(file["point_data"]["irradiance"][vertex.get<int>()], level,
                    1e-8 * std::abs(level));
    }
    const json scene = json::parse(file["field_data"]["scene_json"].get<std::string>());
    EXPECT_EQ(scene["surfaces"][0]["name"], name);
    EXPECT_EQ(file["field_data"]["engine_version"], answer["engine_version"]);
  }
}

TEST_F(DownloadTest, has_media_types_and_names) {
  const json answer = post(ball_request());
  const std::pair<const char*, const char*> types[] = {{"vtp", "application/x-vtk-polydata"},
                                                       {"vtk", "application/x-vtk-legacy"},
                                                       {"svg", "image/svg+xml"},
                                                       {"geojson", "application/geo+json"},
                                                       {"csv", "text/csv"}};
  for (const auto& [format, type] : types) {
    const std::string target = answer["files"][format];
    const HttpReply whole = http_get(server.port(), target);
    EXPECT_EQ(whole.headers.at("content-type"), type);
    EXPECT_EQ(whole.headers.at("content-disposition"),
              "attachment; filename=" + target.substr(target.rfind('/') + 1));
    const HttpReply head = http_get(server.port(), target, "HEAD");
    EXPECT_EQ(head.status, 200);
    EXPECT_EQ(head.headers.at("content-length"), std::to_string(whole.body.size()));
  }
}

TEST_F(DownloadTest, units_change_numbers_but_not_irradiance) {
  json request = ball_request();
  request["store"] = false;
  const json metres = post(request);
  request["scene"]["length_unit"] = "mm";
  for (const char* place : {"/scene/light/position", "/scene/surfaces/0/shape/center",
                            "/scene/receiver/origin", "/scene/receiver/size"})
    for (json& x : request[json::json_pointer(place)]) x = 1000 * x.get<double>();
  surface(request)["shape"]["radius"] = 1000;
  const json millimetres = post(request);
  EXPECT_NE(metres["id"], millimetres["id"]);
  ASSERT_EQ(metres["curves"].size(), millimetres["curves"].size());
  for (std::size_t i = 0; i < metres["curves"].size(); ++i)
    EXPECT_NEAR(millimetres["curves"][i]["length"].get<double>(),
                1000 * metres["curves"][i]["length"].get<double>(),
                metres["curves"][i]["length"].get<double>());
}

/// Bytes depend on the request alone: not on what ran before nor on what runs beside it.
TEST_F(DownloadTest, same_request_same_bytes) {
  std::vector<json> requests;
  for (int i = 0; i < 4; ++i) {
    requests.push_back(ball_request());
    requests.back()["levels"] = {0.0003 + 1e-5 * i, 0.0005};
  }
  const auto files_of = [&requests](int port, std::size_t i) {
    const HttpReply reply = http_post(port, "/v1/contours", requests[i].dump());
    json answer = json::parse(reply.body);
    std::string bytes;
    for (const auto& [format, target] : answer["files"].items())
      bytes += http_get(port, target).body;
    answer["work"].erase("seconds");
    return answer.dump() + bytes;
  };
  std::vector<std::string> expected(requests.size());
  for (std::size_t i = 0; i < requests.size(); ++i) expected[i] = files_of(server.port(), i);

  const ServerProcess other(folder.path() / "other");
  std::atomic<int> different = 0;
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 8; ++t)
    threads.emplace_back([&, t] {
      for (std::size_t k = 0; k < requests.size(); ++k) {
        const std::size_t i = (k + t) % requests.size();
        different += files_of(other.port(), i) != expected[i];
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(different, 0);
}

TEST_F(DownloadTest, a_run_over_its_limit_says_so) {
  json request = ball_request();
  request["limits"] = {{"vertices", 20}};
  const json cut = post(request);
  EXPECT_EQ(cut["complete"], false);
  EXPECT_FALSE(cut["warnings"].empty());
  EXPECT_NE(http_get(server.port(), cut["files"]["vtp"]).body.find("VTKFile"), std::string::npos);
  request["limits"] = {{"time_ms", 0.001}};
  const json late = post(request);
  EXPECT_EQ(late["complete"], false);
  EXPECT_NE(late["id"], cut["id"]);
  request.erase("limits");
  EXPECT_EQ(post(request)["complete"], true);
}

TEST_F(DownloadTest, results_survive_a_restart) {
  const HttpReply posted = http_post(server.port(), "/v1/contours", ball_request().dump());
  const json answer = json::parse(posted.body);
  const HttpReply file = http_get(server.port(), answer["files"]["vtp"]);
  EXPECT_EQ(server.stop(SIGTERM), 0);
  const ServerProcess again(folder.path() / "data");
  EXPECT_EQ(http_get(again.port(), answer["files"]["vtp"]).body, file.body);
  EXPECT_EQ(http_get(again.port(), "/v1/results/" + answer["id"].get<std::string>()).body,
            posted.body);
  EXPECT_EQ(http_post(again.port(), "/v1/contours", ball_request().dump()).body, posted.body);
}

}  // namespace
}  // namespace caustic::test
