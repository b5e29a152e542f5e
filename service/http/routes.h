// What is answered to which request: one table, one exception boundary.
#pragma once

#include "service/api/problem.h"
#include "service/contour_service.h"
#include "service/http/message.h"

namespace caustic::service {

class Routes {
 public:
  Routes(const ContourService& contours, const ResultStore& store)
      : contours_(contours), store_(store) {}

  /// Never throws: whatever goes wrong is an answer too.
  HttpResponse answer(const HttpRequest& request) const noexcept;

 private:
  struct Row;
  static const Row kTable[];

  HttpResponse dispatch(const HttpRequest& request) const;

  HttpResponse post_contours(const HttpRequest& request, const std::string& unused) const;
  HttpResponse get_result(const HttpRequest& request, const std::string& name) const;
  HttpResponse list_examples(const HttpRequest& request, const std::string& unused) const;
  HttpResponse get_example(const HttpRequest& request, const std::string& name) const;
  HttpResponse health(const HttpRequest& request, const std::string& unused) const;
  HttpResponse openapi(const HttpRequest& request, const std::string& unused) const;

  const ContourService& contours_;
  const ResultStore& store_;
};

HttpResponse problem_response(const Problem& problem);

}  // namespace caustic::service
