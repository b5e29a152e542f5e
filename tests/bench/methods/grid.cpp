// 3: the obvious program. The irradiance, exact, at N × N points, and marching squares.
// 4: the same, and each vertex brought to the curve by Newton's method.
#include <vtkCellArray.h>
#include <vtkContourFilter.h>
#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkStripper.h>

#include <cmath>

#include "solver/point_irradiance.h"
#include "tests/bench/methods/marching_squares.h"

namespace caustic::bench {

using geometry::Vec2;

std::vector<std::vector<test::Line>> marching_squares(const Scene& scene, int nx, int ny,
                                                      const std::function<double(const Vec2&)>& E) {
  const Vec2 half = scene.system.receiver().half;
  vtkNew<vtkImageData> image;
  image->SetDimensions(nx, ny, 1);
  image->SetOrigin(-half.x(), -half.y(), 0.0);
  image->SetSpacing(2.0 * half.x() / (nx - 1), 2.0 * half.y() / (ny - 1), 1.0);
  vtkNew<vtkDoubleArray> values;
  values->SetNumberOfValues(static_cast<vtkIdType>(nx) * ny);
  for (int j = 0; j < ny; ++j) {
    for (int i = 0; i < nx; ++i) {
      const Vec2 q(half.x() * (2.0 * i / (nx - 1) - 1.0), half.y() * (2.0 * j / (ny - 1) - 1.0));
      values->SetValue(static_cast<vtkIdType>(j) * nx + i, E(q));
    }
  }
  image->GetPointData()->SetScalars(values);

  vtkNew<vtkContourFilter> contours;
  contours->SetInputData(image);
  for (std::size_t k = 0; k < scene.levels.size(); ++k)
    contours->SetValue(static_cast<int>(k), scene.levels[k]);
  vtkNew<vtkStripper> strips;
  strips->SetInputConnection(contours->GetOutputPort());
  strips->SetMaximumLength(10'000'000);
  strips->Update();

  vtkPolyData* const found = strips->GetOutput();
  vtkDataArray* const level = found->GetPointData()->GetScalars();
  std::vector<std::vector<test::Line>> lines(scene.levels.size());
  vtkIdType count = 0;
  const vtkIdType* ids = nullptr;
  vtkCellArray* const cells = found->GetLines();
  for (cells->InitTraversal(); cells->GetNextCell(count, ids);) {
    test::Line line;
    for (vtkIdType i = 0; i < count; ++i)
      line.emplace_back(found->GetPoint(ids[i])[0], found->GetPoint(ids[i])[1]);
    std::size_t k = 0;
    for (std::size_t i = 1; i < scene.levels.size(); ++i) {
      const double value = level->GetTuple1(ids[0]);
      if (std::abs(value - scene.levels[i]) < std::abs(value - scene.levels[k])) k = i;
    }
    lines[k].push_back(std::move(line));
  }
  return lines;
}

namespace {

// What a meter reads on a caustic.
constexpr double kUnbounded = 1e6;
// Newton's steps for a vertex, and when to stop, |E/E₀ − 1|.
constexpr int kSteps = 8;
constexpr double kResidual = 1e-11;

// Back to where it was if it does not converge within a cell: next to a jump there is nothing to
// converge to.
Vec2 projected(solver::LightMeter& meter, const geometry::ReceiverFrame& receiver,
               const Vec2& start, double level, double cell, std::uint64_t& evaluations) {
  Vec2 q = start;
  for (int i = 0; i < kSteps && (q - start).norm() <= cell; ++i) {
    const auto reading = meter.at(q);
    ++evaluations;
    if (std::abs(reading.E / level - 1.0) <= kResidual) return q;
    const Vec2 slope(reading.gradient.dot(receiver.u), reading.gradient.dot(receiver.v));
    if (!(slope.squaredNorm() > 0.0)) return start;
    q += (level - reading.E) * slope / slope.squaredNorm();
  }
  return start;
}

Drawing draw_grid(const Scene& scene, double points, bool project) {
  solver::LightMeter meter(scene.system, {}, false);
  Drawing drawing;
  const int n = static_cast<int>(points);
  drawing.levels = marching_squares(scene, n, n, [&](const Vec2& q) {
    ++drawing.evaluations;
    const auto reading = meter.at(q);
    return reading.on_caustic ? kUnbounded : reading.E;
  });
  if (!project) return drawing;
  for (std::size_t k = 0; k < drawing.levels.size(); ++k)
    for (test::Line& line : drawing.levels[k])
      for (Vec2& q : line)
        q = projected(meter, scene.system.receiver(), q, scene.levels[k], scene.width() / n,
                      drawing.evaluations);
  return drawing;
}

}  // namespace

std::vector<Method> grid_methods() {
  const std::vector<double> sides{16, 32, 64, 128, 256, 512, 1024, 2048};
  const auto method = [&](const char* name, bool project) {
    return Method{name, solver::Measure::total, sides,
                  [project](const Scene& scene, double n) { return draw_grid(scene, n, project); }};
  };
  return {method("grid", false), method("grid, Newton", true)};
}

}  // namespace caustic::bench
