// What instructions are counted of: a piece of work that does the same each time it is done.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace caustic::bench {

struct Work {
  std::function<void()> action;
  std::size_t units;  ///< done by one action
};

struct Subject {
  std::string name;  ///< group/specimen
  std::string unit;  ///< what is counted in: a point, a ray, a vertex, …
  std::function<Work()> prepare;
};

using Subjects = std::vector<Subject>;

/// Derivatives and crossings of surfaces, evaluations of the map.
void add_points(Subjects& subjects);
/// Subdivision, tracing, paths.
void add_solver(Subjects& subjects);
/// Reading, writing, whole requests, the answer to a POST.
void add_requests(Subjects& subjects);

/// What compilers must not leave out although nobody looks at it.
template <class Value>
void keep(const Value& value) {
  asm volatile("" : : "g"(&value) : "memory");
}

}  // namespace caustic::bench
