// 6: POV-Ray's photons. Its picture of the receiver, seen straight on, is the irradiance; then
// marching squares. Of balls under a lamp only. `fade_power 2`, or its lamp is not inverse-square;
// a screen next to the lamp keeps its direct light, hundreds of times brighter, off the window.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "tests/bench/methods/marching_squares.h"
#include "tests/support/temporary_folder.h"

namespace caustic::bench {

using geometry::Point;
using geometry::Vec2;
using geometry::Vec3;

namespace {

constexpr int kPixels = 256;
// Neighbours as of our photon map; more make POV-Ray slow.
constexpr double kMostNeighbours = 1000.0;
int gathered(double photons) {
  return static_cast<int>(std::min(kMostNeighbours, 0.1 * std::pow(photons, 2.0 / 3.0)));
}
// A picture is at most 1 bright; 65535 steps up to three times the highest level.
double brightness(const Scene& scene) { return 1.0 / (3.0 * scene.levels.back()); }
constexpr double kFade = 1e-3;    // 1/(1 + (r/kFade)²) is inverse-square to 1e-7 at one metre
constexpr double kScreen = 3e-3;  // of the way from the lamp to the window
constexpr double kWider =
    1.05;  // than the window are the screen and, five times that, the receiver

std::string text(const Vec3& v) {
  std::ostringstream out;
  out.precision(17);
  out << '<' << v.x() << ',' << v.y() << ',' << v.z() << '>';
  return out.str();
}

// The window's corners, `wider` than it is, `share` of the way from the lamp.
std::string quadrangle(const Scene& scene, const Point& lamp, double wider, double share) {
  const auto& receiver = scene.system.receiver();
  std::string corners;
  for (const Vec2& sign : {Vec2(-1, -1), Vec2(1, -1), Vec2(1, 1), Vec2(-1, 1), Vec2(-1, -1)}) {
    const Point p = receiver.point(wider * sign.cwiseProduct(receiver.half));
    corners += "," + text(lamp + share * (p - lamp));
  }
  return "polygon { 5" + corners;
}

void write_scene(const Scene& scene, double photons, const std::string& path) {
  const auto& receiver = scene.system.receiver();
  const Point lamp = std::get<solver::PointLight>(scene.system.light()).position;
  const double intensity = std::get<solver::PointLight>(scene.system.light()).intensity;
  const double side = receiver.m.dot(lamp - receiver.origin) > 0.0 ? 1.0 : -1.0;
  // Pixels have their middles where marching squares wants the samples.
  const Vec2 view = 2.0 * receiver.half * kPixels / (kPixels - 1.0);
  const int k = gathered(photons);
  std::ofstream out(path);
  out.precision(17);
  out << "#version 3.7;\n"
      << "global_settings { assumed_gamma 1 photons { count " << photons << " gather " << k / 2
      << ", " << k << " } }\n"
      << "camera { orthographic location "
      << text(receiver.origin + side * 0.01 * scene.width() * receiver.m) << " direction "
      << text(-side * receiver.m) << " right " << text(view.x() * receiver.u) << " up "
      << text(view.y() * receiver.v) << " }\n"
      << "light_source { " << text(lamp) << " rgb "
      << intensity * brightness(scene) / (2.0 * kFade * kFade) << " fade_power 2 fade_distance "
      << kFade << " photons { reflection on } }\n"
      << "sphere { 0, 1 pigment { rgb 1 } finish { ambient 0 diffuse 0 reflection { 1 } }\n"
      << "  photons { target reflection on collect off } }\n"
      << quadrangle(scene, lamp, kWider, kScreen)
      << " pigment { rgb 0 } finish { ambient 0 diffuse 0 } photons { collect off } }\n"
      << quadrangle(scene, lamp, 1.0 + 5.0 * (kWider - 1.0), 1.0)
      << " pigment { rgb 1 } finish { ambient 0 diffuse 1 } }\n";
}

// The red of a picture of 16 bits a colour, from its lower left corner; empty if it is none.
std::vector<double> read_picture(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::string word;
  std::vector<int> header;  // after "P6": width, height, largest value
  in >> word;
  while (in && header.size() < 3) {
    in >> word;
    if (word[0] == '#')
      std::getline(in, word);
    else
      header.push_back(std::atoi(word.c_str()));
  }
  in.get();
  if (!in || header != std::vector{kPixels, kPixels, 65535}) return {};
  std::vector<double> red(static_cast<std::size_t>(kPixels) * kPixels);
  for (int j = kPixels - 1; j >= 0; --j) {
    for (int i = 0; i < kPixels; ++i) {
      unsigned char pixel[6];
      in.read(reinterpret_cast<char*>(pixel), sizeof pixel);
      red[static_cast<std::size_t>(j) * kPixels + i] = (256.0 * pixel[0] + pixel[1]) / 65535.0;
    }
  }
  return in ? red : std::vector<double>{};
}

Drawing draw_povray(const Scene& scene, double photons) {
  const test::TemporaryFolder folder;
  const std::string base = (folder.path() / "scene").string();
  write_scene(scene, photons, base + ".pov");
  const std::string size = std::to_string(kPixels);
  const std::string command = "povray +I" + base + ".pov +O" + base + ".ppm +FP16 +W" + size +
                              " +H" + size + " -D -A File_Gamma=1 Dither=off Work_Threads=1 > " +
                              base + ".log 2>&1";
  Drawing drawing{std::vector<std::vector<test::Line>>(scene.levels.size()),
                  static_cast<std::uint64_t>(photons), "k = " + std::to_string(gathered(photons))};
  const bool done = std::system(command.c_str()) == 0;
  const auto picture = done ? read_picture(base + ".ppm") : std::vector<double>{};
  if (picture.empty()) {
    drawing.remark = "povray failed";
    return drawing;
  }
  std::size_t next = 0;  // in the order of the samples
  drawing.levels = marching_squares(
      scene, kPixels, kPixels, [&](const Vec2&) { return picture[next++] / brightness(scene); });
  return drawing;
}

std::string povray_missing() {
  return std::system("command -v povray > /dev/null") == 0 ? "" : "povray is not installed";
}

}  // namespace

std::vector<Method> povray_methods() {
  return {{"POV-Ray",
           solver::Measure::total,
           {1e4, 1e5, 1e6, 1e7},
           draw_povray,
           [](const Scene& scene) { return scene.name[0] == 'A'; },
           povray_missing()}};
}

}  // namespace caustic::bench
