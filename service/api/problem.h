// What is wrong with a request, as RFC 9457 says it. Bad input travels as one exception type and is
// caught once, at the boundary (HTTP or command line).
#pragma once

#include <exception>
#include <string>
#include <utility>
#include <vector>

namespace caustic::service {

/// One thing that is wrong, and where: an RFC 6901 pointer into the request.
struct Fault {
  std::string pointer, detail;
};

struct Problem {
  int status;
  std::string title;
  std::string detail;
  std::vector<Fault> errors;
};

class ProblemError : public std::exception {
 public:
  explicit ProblemError(Problem problem) : problem_(std::move(problem)) {}
  const Problem& problem() const { return problem_; }
  const char* what() const noexcept override { return problem_.title.c_str(); }

 private:
  Problem problem_;
};

/// The phrase of a status of 400 or more.
const char* title_of_status(int status);

/// A problem whose title is the phrase of its HTTP status.
Problem make_problem(int status, std::string detail, std::vector<Fault> errors = {});

/// A bug: what it was goes to stderr, and nothing of it to the client (500).
Problem report_bug(const char* what);

/// The `application/problem+json` document.
std::string to_json(const Problem& problem);

}  // namespace caustic::service
