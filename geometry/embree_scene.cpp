#include "geometry/embree_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <mutex>

namespace caustic::geometry {

namespace {

// Embree traces in single precision: beyond this many units its own errors could lose a box, so
// coordinates are brought to the unit cube first.
constexpr double kUnit = 1.0;
// Relative widening that covers the single-precision error of a ray in unit coordinates.
constexpr double kFloatSlack = 1e-5;
constexpr float kFar = 1e6f;

float down(double v) {
  return std::nextafter(static_cast<float>(std::max(v, -double(kFar))), -INFINITY);
}
float up(double v) {
  return std::nextafter(static_cast<float>(std::min(v, double(kFar))), INFINITY);
}

// One device for the process: making it takes milliseconds, a scene microseconds.
RTCDevice shared_device() {
  static const RTCDevice device = rtcNewDevice("threads=1");
  return device;
}

// Building and releasing scenes of the shared device goes one at a time; asking needs no lock.
std::mutex& device_mutex() {
  static std::mutex mutex;
  return mutex;
}

struct Query {
  RTCIntersectContext context;  // must come first: Embree hands back its address
  std::vector<int>* out;
};

}  // namespace

struct EmbreeScene::State {
  RTCScene scene = nullptr;
  std::vector<Box> boxes;  // in unit coordinates, widened
  Point center;
  double scale = 1.0;

  ~State() {
    const std::lock_guard lock(device_mutex());
    rtcReleaseScene(scene);
  }

  static void bounds(const RTCBoundsFunctionArguments* args) {
    const Box& box = static_cast<const State*>(args->geometryUserPtr)->boxes[args->primID];
    RTCBounds& b = *args->bounds_o;
    b.lower_x = down(box.min.x());
    b.lower_y = down(box.min.y());
    b.lower_z = down(box.min.z());
    b.upper_x = up(box.max.x());
    b.upper_y = up(box.max.y());
    b.upper_z = up(box.max.z());
  }
  // Called for every box that the ray meets; reports no hit, so that the traversal goes on.
  static void visit(const RTCOccludedFunctionNArguments* args) {
    if (args->valid[0])
      reinterpret_cast<Query*>(args->context)->out->push_back(static_cast<int>(args->primID));
  }
};

EmbreeScene::EmbreeScene(const std::vector<Box>& boxes, double margin)
    : state_(std::make_unique<State>()) {
  State& s = *state_;
  Box all{Point::Constant(kInfinity), Point::Constant(-kInfinity)};
  for (const Box& box : boxes) {
    if (box.bounded()) all = {all.min.cwiseMin(box.min), all.max.cwiseMax(box.max)};
  }
  s.center = all.empty() ? Point::Zero() : all.center();
  s.scale = all.empty() || !(all.diagonal() > 0.0) ? 1.0 : kUnit / all.diagonal();
  for (const Box& box : boxes) {
    const double wide = margin * s.scale + kFloatSlack;
    const Vec3 lo = (box.min - s.center) * s.scale, hi = (box.max - s.center) * s.scale;
    s.boxes.push_back({lo.array() - wide - kFloatSlack * lo.array().abs(),
                       hi.array() + wide + kFloatSlack * hi.array().abs()});
  }
  const std::lock_guard lock(device_mutex());
  const RTCDevice device = shared_device();
  s.scene = rtcNewScene(device);
  rtcSetSceneFlags(s.scene, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(boxes.size()));
  rtcSetGeometryUserData(geometry, &s);
  rtcSetGeometryBoundsFunction(geometry, State::bounds, nullptr);
  rtcSetGeometryOccludedFunction(geometry, State::visit);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(s.scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(s.scene);
}

EmbreeScene::~EmbreeScene() = default;

void EmbreeScene::candidates(const Ray& ray, double t1, std::vector<int>& out) const {
  const State& s = *state_;
  const Vec3 origin = (ray.origin - s.center) * s.scale;
  const Vec3 direction = ray.direction * (t1 * s.scale);
  const double length = direction.norm();
  // Embree ends the process for what is no ray in single precision. A segment of no length has no
  // direction either, and what is far out is left to the caller, box by box.
  if (!((origin.array().abs() <= kFar).all() && length > 0.0 && length < kInfinity)) {
    const Ray segment{origin, direction};
    for (int k = 0; k < static_cast<int>(s.boxes.size()); ++k) {
      if (!direction.allFinite() || s.boxes[k].may_meet(segment, 0.0)) out.push_back(k);
    }
    return;
  }
  RTCRay r{};
  r.org_x = static_cast<float>(origin.x());
  r.org_y = static_cast<float>(origin.y());
  r.org_z = static_cast<float>(origin.z());
  r.dir_x = static_cast<float>(direction.x() / length);
  r.dir_y = static_cast<float>(direction.y() / length);
  r.dir_z = static_cast<float>(direction.z() / length);
  r.tnear = 0.0f;
  r.tfar = up(length);
  r.mask = ~0u;
  Query query;
  rtcInitIntersectContext(&query.context);
  query.out = &out;
  rtcOccluded1(s.scene, &query.context, &r);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
}

}  // namespace caustic::geometry
