// Work that is asked for again while it is under way is done once.
#pragma once

#include <exception>
#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <string>
#include <variant>

#include "service/api/problem.h"

namespace caustic::service {

class SharedWork {
 public:
  /// A problem is passed on as a value: each thread throws an exception of its own, for one object
  /// thrown in several would be shared and written by all of them.
  using Outcome = std::variant<std::string, Problem, std::exception_ptr>;

  /// What `work` returns or throws; or what it does for another thread that is at work under this
  /// key already. Works of one key must be interchangeable.
  std::string once(const std::string& key, const std::function<std::string()>& work);

 private:
  std::mutex mutex_;
  std::map<std::string, std::shared_future<Outcome>> under_way_;
};

}  // namespace caustic::service
