// JSON text in and out. Reading is strict and safe against hostile text; writing prints each number
// as the shortest decimal that reads back as the same double, so that equal requests have equal
// text.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>

namespace caustic::service {

/// Deepest nesting of arrays and objects: recursion over a document stays within any stack.
constexpr int kMaxJsonDepth = 64;
/// Most values in one document: bounds the memory that a body of a few MiB can take to ~100 MB.
constexpr int kMaxJsonValues = 2'000'000;

/// Every number comes out as a double, −0 as 0. Throws ProblemError (400): not JSON, NaN, Infinity,
/// a number beyond double, a duplicate key, too deep, too many values, text after the document.
nlohmann::json parse_json(std::string_view text);

/// Compact text, members in the document's order (sorted for nlohmann::json).
/// Numbers must be finite: a bug otherwise.
std::string write_json(const nlohmann::json& document);
std::string write_json(const nlohmann::ordered_json& document);

/// Appends the shortest decimal of a finite number.
void append_number(std::string& out, double value);

}  // namespace caustic::service
