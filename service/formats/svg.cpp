#include "service/formats/format.h"
namespace caustic::service {
std::string write_svg(const PolylineSet&) { return "<svg xmlns=\"http://www.w3.org/2000/svg\"/>"; }
}
