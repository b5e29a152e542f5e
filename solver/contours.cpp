#include "solver/contours.h"

namespace caustic::solver {

const char* to_string(CurveKind kind) {
  switch (kind) {
    case CurveKind::isolux:
      return "isolux";
    case CurveKind::caustic:
      return "caustic";
    case CurveKind::jump:
      return "jump";
    case CurveKind::receiver_edge:
      return "receiver_edge";
    case CurveKind::boundary:
      return "boundary";
  }
  return "isolux";
}

const char* to_string(CriticalType type) {
  switch (type) {
    case CriticalType::minimum:
      return "min";
    case CriticalType::maximum:
      return "max";
    case CriticalType::saddle:
      return "saddle";
  }
  return "saddle";
}

const char* to_string(Ending ending) {
  switch (ending) {
    case Ending::silhouette:
      return "silhouette";
    case Ending::aperture:
      return "aperture";
    case Ending::shadow:
      return "shadow";
    case Ending::occlusion:
      return "occlusion";
    case Ending::total_internal_reflection:
      return "total_internal_reflection";
    case Ending::receiver_edge:
      return "receiver_edge";
    case Ending::limit:
      return "limit";
    case Ending::node:
      return "node";
  }
  return "limit";
}

}  // namespace caustic::solver
