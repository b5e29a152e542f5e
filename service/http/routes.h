// What is answered to which request: one table, one exception boundary.
#pragma once

#include "service/api/problem.h"
#include "service/contour_service.h"
#include "service/http/message.h"

namespace caustic::service {

class Routes {
 public:
  /// When `stopping` becomes true, calls about points end with 503.
  Routes(const ContourService& contours, const ResultStore& store,
         const std::atomic<bool>* stopping = nullptr)
      : contours_(contours), store_(store), stopping_(stopping) {}

  /// Never throws: whatever goes wrong is an answer too.
  HttpResponse answer(const HttpRequest& request) const noexcept;

 private:
  struct Row;
  static const Row kTable[];

  HttpResponse dispatch(const HttpRequest& request) const;

  HttpResponse post_contours(const HttpRequest& request, const std::string& unused) const;
  HttpResponse post_paths(const HttpRequest& request, const std::string& unused) const;
  HttpResponse post_irradiance(const HttpRequest& request, const std::string& unused) const;
  HttpResponse post_analysis(const HttpRequest& request, const std::string& unused) const;
  HttpResponse get_result(const HttpRequest& request, const std::string& name) const;
  HttpResponse list_examples(const HttpRequest& request, const std::string& unused) const;
  HttpResponse get_example(const HttpRequest& request, const std::string& name) const;
  HttpResponse health(const HttpRequest& request, const std::string& unused) const;
  HttpResponse openapi(const HttpRequest& request, const std::string& unused) const;

  const ContourService& contours_;
  const ResultStore& store_;
  const std::atomic<bool>* stopping_;
};

HttpResponse problem_response(const Problem& problem);

}  // namespace caustic::service
