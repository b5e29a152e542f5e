#include "service/shared_work.h"

namespace caustic::service {

std::string SharedWork::once(const std::string& key, const std::function<std::string()>& work) {
  std::packaged_task<std::string()> task(work);
  std::shared_future<std::string> result;
  bool first = false;
  {
    const std::lock_guard lock(mutex_);
    const auto [entry, fresh] = under_way_.try_emplace(key);
    if (fresh) entry->second = task.get_future().share();
    result = entry->second;
    first = fresh;
  }
  if (first) {
    task();
    const std::lock_guard lock(mutex_);
    under_way_.erase(key);
  }
  return result.get();
}

}  // namespace caustic::service
