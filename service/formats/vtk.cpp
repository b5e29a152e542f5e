// The only file that includes VTK. Each writer gets a poly data built for it alone: what another
// writer left in a shared one would change its bytes.
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkDoubleArray.h>
#include <vtkFieldData.h>
#include <vtkIntArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataWriter.h>
#include <vtkStringArray.h>
#include <vtkXMLPolyDataWriter.h>
#include <vtkZLibDataCompressor.h>

#include "service/formats/format.h"

namespace caustic::service {
namespace {

/// Level 1: half of level 5's time for a few per cent of size.
constexpr int kCompressionLevel = 1;
constexpr int kBlockSize = 1 << 18;

vtkDoubleArray* add_doubles(vtkFieldData* data, const char* name, int components,
                            vtkIdType tuples) {
  vtkNew<vtkDoubleArray> array;
  array->SetName(name);
  array->SetNumberOfComponents(components);
  array->SetNumberOfTuples(tuples);
  data->AddArray(array);
  return array;
}

vtkIntArray* add_ints(vtkFieldData* data, const char* name, vtkIdType tuples) {
  vtkNew<vtkIntArray> array;
  array->SetName(name);
  array->SetNumberOfTuples(tuples);
  data->AddArray(array);
  return array;
}

void add_string(vtkFieldData* data, const char* name, const std::string& text) {
  vtkNew<vtkStringArray> array;
  array->SetName(name);
  array->InsertNextValue(text);
  data->AddArray(array);
}

void add_points(const PolylineSet& set, vtkPolyData* out) {
  const auto count = static_cast<vtkIdType>(set.vertices.size());
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  points->SetNumberOfPoints(count);
  vtkPointData* data = out->GetPointData();
  auto* irradiance = add_doubles(data, "irradiance", 1, count);
  auto* residual = add_doubles(data, "residual", 1, count);
  auto* gradient = add_doubles(data, "gradient", 3, count);
  auto* arc_length = add_doubles(data, "arc_length", 1, count);
  auto* uv = add_doubles(data, "uv", 2, count);
  auto* reflector_point = add_doubles(data, "reflector_point", 3, count);
  auto* dark = set.total ? add_doubles(data, "E_dark", 1, count) : nullptr;
  auto* bright = set.total ? add_doubles(data, "E_bright", 1, count) : nullptr;
  for (vtkIdType i = 0; i < count; ++i) {
    const PolylineVertex& vertex = set.vertices[static_cast<std::size_t>(i)];
    points->SetPoint(i, vertex.position.data());
    irradiance->SetValue(i, vertex.irradiance);
    residual->SetValue(i, vertex.residual);
    gradient->SetTypedTuple(i, vertex.gradient.data());
    arc_length->SetValue(i, vertex.arc_length);
    uv->SetTypedTuple(i, vertex.uv.data());
    reflector_point->SetTypedTuple(i, vertex.reflector_point.data());
    if (dark) dark->SetValue(i, vertex.dark);
    if (bright) bright->SetValue(i, vertex.bright);
  }
  out->SetPoints(points);
}

void add_lines(const PolylineSet& set, vtkPolyData* out) {
  vtkNew<vtkCellArray> lines;
  for (const Polyline& curve : set.curves) {
    lines->InsertNextCell(static_cast<int>(curve.file_vertices()));
    for (std::uint64_t i = 0; i < curve.file_vertices(); ++i)
      lines->InsertCellPoint(static_cast<vtkIdType>(curve.first + (i == curve.count ? 0 : i)));
  }
  out->SetLines(lines);
}

void add_cell_data(const PolylineSet& set, vtkPolyData* out) {
  const auto count = static_cast<vtkIdType>(set.curves.size());
  vtkCellData* data = out->GetCellData();
  auto* curve_id = add_ints(data, "curve_id", count);
  auto* kind = add_ints(data, "kind", count);
  auto* level = add_doubles(data, "level", 1, count);
  auto* closed = add_ints(data, "closed", count);
  auto* family_id = add_ints(data, "family_id", count);
  auto* parity = add_ints(data, "parity", count);
  auto* length = add_doubles(data, "length", 1, count);
  auto* boundary = set.total ? add_ints(data, "boundary", count) : nullptr;
  auto* ring_id = set.total ? add_ints(data, "ring_id", count) : nullptr;
  auto* ring_order = set.total ? add_ints(data, "ring_order", count) : nullptr;
  for (vtkIdType i = 0; i < count; ++i) {
    const Polyline& curve = set.curves[static_cast<std::size_t>(i)];
    curve_id->SetValue(i, static_cast<int>(i));
    kind->SetValue(i, static_cast<int>(curve.kind));
    level->SetValue(i, curve.level);
    closed->SetValue(i, curve.closed);
    family_id->SetValue(i, curve.family_id);
    parity->SetValue(i, curve.parity);
    length->SetValue(i, curve.length);
    if (!set.total) continue;
    boundary->SetValue(i, curve.boundary);
    ring_id->SetValue(i, curve.ring_id);
    ring_order->SetValue(i, curve.ring_order);
  }
}

vtkNew<vtkPolyData> poly_data(const PolylineSet& set) {
  vtkNew<vtkPolyData> out;
  add_points(set, out);
  add_lines(set, out);
  add_cell_data(set, out);
  add_string(out->GetFieldData(), "scene_json", set.scene_json);
  add_string(out->GetFieldData(), "units_json", set.units_json);
  add_string(out->GetFieldData(), "engine_version", set.engine_version);
  add_string(out->GetFieldData(), "request_sha256", set.request_sha256);
  return out;
}

}  // namespace

std::string write_vtp(const PolylineSet& set) {
  const vtkNew<vtkPolyData> data = poly_data(set);
  vtkNew<vtkZLibDataCompressor> compressor;
  compressor->SetCompressionLevel(kCompressionLevel);
  vtkNew<vtkXMLPolyDataWriter> writer;
  writer->SetInputData(data.Get());
  writer->SetDataModeToBinary();
  writer->SetCompressor(compressor);
  writer->SetBlockSize(kBlockSize);
  writer->WriteToOutputStringOn();
  writer->Write();
  return writer->GetOutputString();
}

std::string write_legacy_vtk(const PolylineSet& set) {
  const vtkNew<vtkPolyData> data = poly_data(set);
  vtkNew<vtkPolyDataWriter> writer;
  writer->SetInputData(data.Get());
  writer->SetFileVersion(42);
  writer->SetFileTypeToASCII();
  writer->SetHeader("Isocaustic curves");
  writer->WriteToOutputStringOn();
  writer->Write();
  return writer->GetOutputStdString();
}

}  // namespace caustic::service
