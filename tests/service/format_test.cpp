#include "service/formats/format.h"

#include <gtest/gtest.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkIdList.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataReader.h>
#include <vtkSmartPointer.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataReader.h>

#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "service/formats/svg_plot.h"
#include "tests/support/polylines.h"

namespace caustic::service {
namespace {

using test::sample_polylines;

vtkSmartPointer<vtkPolyData> read_vtp(const std::string& bytes) {
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->ReadFromInputStringOn();
  reader->SetInputString(bytes);
  reader->Update();
  return reader->GetOutput();
}

vtkSmartPointer<vtkPolyData> read_legacy(const std::string& bytes) {
  vtkNew<vtkPolyDataReader> reader;
  reader->ReadFromInputStringOn();
  reader->SetInputString(bytes);
  reader->ReadAllScalarsOn();
  reader->ReadAllVectorsOn();
  reader->ReadAllFieldsOn();
  reader->Update();
  return reader->GetOutput();
}

/// Everything that a set says, in the arrays that api.md names, to `relative` accuracy.
void expect_same(vtkPolyData* data, const PolylineSet& set, double relative) {
  const auto near = [relative](double a, double b) {
    EXPECT_NEAR(a, b, relative * std::max(1.0, std::abs(b)));
  };
  ASSERT_EQ(data->GetNumberOfPoints(), std::ssize(set.vertices));
  ASSERT_EQ(data->GetNumberOfLines(), std::ssize(set.curves));
  EXPECT_EQ(data->GetPoints()->GetDataType(), VTK_DOUBLE);
  vtkPointData* points = data->GetPointData();
  const std::pair<const char*, int> arrays[] = {{"irradiance", 1}, {"residual", 1},
                                                {"gradient", 3},   {"arc_length", 1},
                                                {"uv", 2},         {"reflector_point", 3}};
  for (const auto& [name, components] : arrays) {
    ASSERT_TRUE(points->GetArray(name)) << name;
    EXPECT_EQ(points->GetArray(name)->GetNumberOfComponents(), components) << name;
    EXPECT_EQ(points->GetArray(name)->GetDataType(), VTK_DOUBLE) << name;
  }
  for (vtkIdType i = 0; i < data->GetNumberOfPoints(); ++i) {
    const PolylineVertex& vertex = set.vertices[i];
    for (int c = 0; c < 3; ++c) {
      near(data->GetPoint(i)[c], vertex.position[c]);
      near(points->GetArray("gradient")->GetComponent(i, c), vertex.gradient[c]);
      near(points->GetArray("reflector_point")->GetComponent(i, c), vertex.reflector_point[c]);
    }
    for (int c = 0; c < 2; ++c) near(points->GetArray("uv")->GetComponent(i, c), vertex.uv[c]);
    near(points->GetArray("irradiance")->GetComponent(i, 0), vertex.irradiance);
    near(points->GetArray("residual")->GetComponent(i, 0), vertex.residual);
    near(points->GetArray("arc_length")->GetComponent(i, 0), vertex.arc_length);
  }
  vtkNew<vtkIdList> ids;
  for (vtkIdType id = 0; id < data->GetNumberOfLines(); ++id) {
    const Polyline& curve = set.curves[id];
    data->GetLines()->GetCellAtId(id, ids);
    ASSERT_EQ(ids->GetNumberOfIds(), static_cast<vtkIdType>(curve.file_vertices()));
    EXPECT_EQ(ids->GetId(0), static_cast<vtkIdType>(curve.first));
    EXPECT_EQ(ids->GetId(ids->GetNumberOfIds() - 1) == ids->GetId(0), curve.closed != 0);
    const auto cell = [&](const char* name) {
      return data->GetCellData()->GetArray(name)->GetComponent(id, 0);
    };
    EXPECT_EQ(cell("curve_id"), id);
    EXPECT_EQ(cell("kind"), static_cast<int>(curve.kind));
    EXPECT_EQ(cell("closed"), curve.closed);
    EXPECT_EQ(cell("family_id"), curve.family_id);
    EXPECT_EQ(cell("parity"), curve.parity);
    near(cell("level"), curve.level);
    near(cell("length"), curve.length);
  }
  const std::pair<const char*, std::string> strings[] = {{"scene_json", set.scene_json},
                                                         {"units_json", set.units_json},
                                                         {"engine_version", set.engine_version},
                                                         {"request_sha256", set.request_sha256}};
  for (const auto& [name, value] : strings) {
    auto* array = vtkStringArray::SafeDownCast(data->GetFieldData()->GetAbstractArray(name));
    ASSERT_TRUE(array) << name;
    EXPECT_EQ(array->GetValue(0), value);
  }
}

TEST(Formats, say_the_rings_of_totals) {
  PolylineSet set = sample_polylines();
  const auto read = [&] { return read_vtp(write_vtp(set)); };
  EXPECT_FALSE(read()->GetCellData()->HasArray("ring_id"));
  set.total = true;
  set.curves[1].kind = PolylineKind::jump;
  set.curves[1].boundary = 4;
  set.curves[1].ring_id = 2;
  set.curves[1].ring_order = 5;
  set.vertices[set.curves[1].first].dark = 0.125;
  set.vertices[set.curves[1].first].bright = -1.0;
  const auto data = read();
  expect_same(data, set, 0.0);
  const auto first = static_cast<vtkIdType>(set.curves[1].first);
  EXPECT_EQ(data->GetPointData()->GetArray("E_dark")->GetComponent(first, 0), 0.125);
  EXPECT_EQ(data->GetPointData()->GetArray("E_bright")->GetComponent(first, 0), -1.0);
  EXPECT_EQ(data->GetCellData()->GetArray("boundary")->GetComponent(1, 0), 4);
  EXPECT_EQ(data->GetCellData()->GetArray("ring_id")->GetComponent(1, 0), 2);
  EXPECT_EQ(data->GetCellData()->GetArray("ring_order")->GetComponent(1, 0), 5);
  const auto feature = nlohmann::json::parse(write_geojson(set))["features"][1]["properties"];
  EXPECT_EQ(feature["kind"], "jump");
  EXPECT_EQ(feature["ring_order"], 5);
  EXPECT_NE(write_svg(set).find("class=\"curve jump\""), std::string::npos);
}

TEST(Formats, vtp_says_everything_exactly) {
  const PolylineSet set = sample_polylines();
  const std::string bytes = write_vtp(set);
  expect_same(read_vtp(bytes), set, 0.0);
  EXPECT_NE(bytes.find("vtkZLibDataCompressor"), std::string::npos);
  EXPECT_EQ(bytes.find("appended"), std::string::npos);
}

TEST(Formats, legacy_vtk_says_everything_to_eleven_digits) {
  const PolylineSet set = sample_polylines();
  const std::string bytes = write_legacy_vtk(set);
  EXPECT_TRUE(bytes.starts_with("# vtk DataFile Version 4.2\n"));
  EXPECT_NE(bytes.find("\nASCII\n"), std::string::npos);
  expect_same(read_legacy(bytes), set, 1e-10);
}

TEST(Formats, a_set_without_curves_is_a_file_too) {
  PolylineSet set = sample_polylines();
  set.curves.clear();
  set.vertices.clear();
  EXPECT_EQ(read_vtp(write_vtp(set))->GetNumberOfLines(), 0);
  EXPECT_EQ(read_legacy(write_legacy_vtk(set))->GetNumberOfLines(), 0);
  EXPECT_NE(write_svg(set).find("no curves"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(write_geojson(set))["features"].empty());
  EXPECT_EQ(std::ranges::count(write_csv(set), '\n'), 1);
}

TEST(Formats, geojson_is_one_line_string_a_curve) {
  const PolylineSet set = sample_polylines();
  const auto document = nlohmann::json::parse(write_geojson(set));
  EXPECT_EQ(document["type"], "FeatureCollection");
  ASSERT_EQ(document["features"].size(), 3u);
  const auto& first = document["features"][0];
  EXPECT_EQ(first["geometry"]["type"], "LineString");
  EXPECT_EQ(first["geometry"]["coordinates"].size(), 51u);
  EXPECT_EQ(first["geometry"]["coordinates"][0], first["geometry"]["coordinates"][50]);
  EXPECT_EQ(first["geometry"]["coordinates"][7][0], set.vertices[7].uv[0]);
  EXPECT_EQ(first["properties"], nlohmann::json::parse(R"({"curve_id":0,"kind":"isolux","level":0.1,
      "closed":true,"family_id":0,"parity":1,"length":2.5})"));
  const auto& caustic = document["features"][2]["properties"];
  EXPECT_TRUE(caustic["level"].is_null());
  EXPECT_EQ(caustic["kind"], "caustic");
  EXPECT_EQ(caustic["closed"], false);
}

TEST(Formats, csv_has_a_row_a_vertex) {
  const PolylineSet set = sample_polylines();
  std::istringstream lines(write_csv(set));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line,
            "curve_id,kind,level,closed,family_id,parity,vertex,x,y,z,u,v,irradiance,residual,"
            "gradient_x,gradient_y,gradient_z,arc_length,x1,y1,z1");
  int rows = 0;
  for (; std::getline(lines, line); ++rows) EXPECT_EQ(std::ranges::count(line, ','), 20);
  EXPECT_EQ(rows, 51 + 51 + 50);
  EXPECT_TRUE(line.empty() || line.starts_with("2,1,-1,0,0,0,49,"));
}

TEST(Formats, svg_draws_and_labels_every_level) {
  const std::string svg = write_svg(sample_polylines());
  for (const char* part :
       {"u [mm]", "v [mm]", "W/m²", ">0.1<", ">0.2<", "caustic", "id=\"curve2\""})
    EXPECT_NE(svg.find(part), std::string::npos) << part;
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(Formats, svg_stays_sane_for_odd_receivers) {
  for (const double width : {1e-12, 1.0, 1e12}) {
    for (const double ratio : {1e-9, 1.0, 1e9}) {
      PolylineSet set = sample_polylines();
      set.receiver_size = {width, width * ratio};
      const std::string svg = write_svg(set);
      EXPECT_EQ(svg.find("nan"), std::string::npos);
      EXPECT_EQ(svg.find("inf"), std::string::npos);
      EXPECT_LT(svg.size(), 40'000u);
    }
  }
}

TEST(Formats, numbers_read_well) {
  EXPECT_EQ(label_text(0.0005), "0.0005");
  EXPECT_EQ(label_text(1000), "1000");
  EXPECT_EQ(label_text(12.3456), "12.35");
  EXPECT_EQ(label_text(0), "0");
  EXPECT_EQ(label_text(-2.5), "-2.5");
  EXPECT_EQ(label_text(3e-9), "3e-09");
}

/// The same bytes whatever ran before and beside it.
TEST(Formats, are_deterministic) {
  const PolylineSet set = sample_polylines();
  PolylineSet other = set;
  other.curves.resize(1);
  std::vector<std::string> expected;
  for (const Format& format : formats()) expected.push_back(format.write(set));
  std::vector<std::thread> threads;
  std::atomic<int> different = 0;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int round = 0; round < 10; ++round) {
        for (std::size_t i = 0; i < formats().size(); ++i) {
          formats()[(i + t) % formats().size()].write(other);
          different += formats()[i].write(set) != expected[i];
        }
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(different, 0);
}

}  // namespace
}  // namespace caustic::service
