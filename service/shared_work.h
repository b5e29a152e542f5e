// Work that is asked for again while it is under way is done once.
#pragma once

#include <functional>
#include <future>
#include <map>
#include <mutex>
#include <string>

namespace caustic::service {

class SharedWork {
 public:
  /// What `work` returns or throws; or what it does for another thread that is at work under this
  /// key already. Works of one key must be interchangeable.
  std::string once(const std::string& key, const std::function<std::string()>& work);

 private:
  std::mutex mutex_;
  std::map<std::string, std::shared_future<std::string>> under_way_;
};

}  // namespace caustic::service
