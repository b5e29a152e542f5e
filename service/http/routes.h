// What is answered to which request: one table, one exception boundary.
#pragma once

#include "service/api/problem.h"
#include "service/contour_service.h"
#include "service/http/message.h"
#include "service/jobs/jobs.h"

namespace caustic::service {

class Routes {
 public:
  Routes(const ContourService& contours, const ResultStore& store, Jobs& jobs,
         const Metrics* metrics = nullptr)
      : contours_(contours), store_(store), jobs_(jobs), metrics_(metrics) {}

  /// Answers, now or later; never throws: whatever goes wrong is an answer too.
  void serve(HttpRequest request, std::shared_ptr<Exchange> exchange) noexcept;

  /// All of the table, method and pattern.
  static std::vector<std::pair<std::string, std::string>> all();
  /// The methods of this path, as `Allow` lists them; empty if nothing is there.
  static std::string methods_of(std::string_view target);
  /// The pattern that this path fits, "other" if none.
  static std::string_view pattern_of(std::string_view target);

 private:
  struct Call {
    HttpRequest request;
    std::string name;  ///< what stands for {} in the pattern
    std::shared_ptr<Exchange> exchange;
  };
  struct Row;
  static const Row kTable[];
  using Answer = std::string (*)(std::string_view body, const std::atomic<bool>* cancelled);

  void dispatch(HttpRequest request, const std::shared_ptr<Exchange>& exchange);
  bool is_chore(const Row& row, const Call& call) const;

  void post_contours(const Call& call);
  void post_paths(const Call& call);
  void post_irradiance(const Call& call);
  void post_analysis(const Call& call);
  void get_result(const Call& call);
  void get_job(const Call& call);
  void delete_job(const Call& call);
  void get_job_events(const Call& call);
  void list_examples(const Call& call);
  void get_example(const Call& call);
  void health(const Call& call);
  void ready(const Call& call);
  void metrics(const Call& call);
  void openapi(const Call& call);
  void docs(const Call& call);
  void page(const Call& call);

  void compute(const Call& call, Answer answer);

  const ContourService& contours_;
  const ResultStore& store_;
  Jobs& jobs_;
  const Metrics* metrics_;
  /// For what takes long and is no computation: reading large bodies and expressions, writing large
  /// files.
  static constexpr int kChoreThreads = 2;
  static constexpr std::size_t kMostChores = 256;
  Workers chores_{kChoreThreads, kMostChores};
};

HttpResponse problem_response(const Problem& problem);

}  // namespace caustic::service
