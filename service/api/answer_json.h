// The 200 answer of `POST /v1/contours`, and the curves behind it in the user's units.
#pragma once

#include <string>

#include "service/api/contour_json.h"
#include "service/formats/polyline_set.h"
#include "solver/contours.h"

namespace caustic::service {

/// Throws ProblemError (422) where the result says that this version cannot answer.
void throw_if_unsupported(const solver::ContourResult& result);

/// The curves in the user's length unit. A curve with a number that is not finite is taken out of
/// `result`, with a warning: such a number must not leave.
PolylineSet to_polylines(const ContourCall& call, solver::ContourResult& result);

/// The document of api.md, `result` having gone through to_polylines(). `stored` says whether there
/// are files; if not and `geojson` is not empty, it is put into the answer.
std::string answer_json(const ContourCall& call, const solver::ContourResult& result,
                        const std::string& id, bool stored, const std::string& geojson = {});

}  // namespace caustic::service
