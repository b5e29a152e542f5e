// What a request is refused for.
#pragma once

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "service/api/contour_json.h"
#include "service/api/problem.h"

namespace caustic::test {

/// Pointer below `prefix` → detail of every fault of a contour request; none may lie elsewhere.
inline std::map<std::string, std::string> faults_of(const nlohmann::json& request,
                                                    const std::string& prefix = "") {
  std::map<std::string, std::string> out;
  try {
    service::read_contour_call(request.dump());
  } catch (const service::ProblemError& error) {
    EXPECT_EQ(error.problem().status, 422);
    for (const service::Fault& fault : error.problem().errors) {
      EXPECT_TRUE(fault.pointer.starts_with(prefix)) << fault.pointer;
      out[fault.pointer.substr(prefix.size())] = fault.detail;
    }
  }
  return out;
}

inline std::vector<std::string> pointers_of(const std::map<std::string, std::string>& faults) {
  std::vector<std::string> out;
  for (const auto& [pointer, detail] : faults) out.push_back(pointer);
  return out;
}

inline std::vector<std::string> pointers_of(const nlohmann::json& request) {
  return pointers_of(faults_of(request));
}

}  // namespace caustic::test
