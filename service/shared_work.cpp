#include "service/shared_work.h"

namespace caustic::service {
namespace {

SharedWork::Outcome outcome_of(const std::function<std::string()>& work) {
  try {
    return work();
  } catch (const ProblemError& error) {
    return error.problem();
  } catch (...) {
    return std::current_exception();
  }
}

}  // namespace

std::string SharedWork::once(const std::string& key, const std::function<std::string()>& work) {
  std::promise<Outcome> promise;
  std::shared_future<Outcome> result;
  bool first = false;
  {
    const std::lock_guard lock(mutex_);
    const auto [entry, fresh] = under_way_.try_emplace(key);
    if (fresh) entry->second = promise.get_future().share();
    result = entry->second;
    first = fresh;
  }
  if (first) {
    promise.set_value(outcome_of(work));
    const std::lock_guard lock(mutex_);
    under_way_.erase(key);
  }
  const Outcome& outcome = result.get();
  if (const auto* value = std::get_if<std::string>(&outcome)) return *value;
  if (const auto* problem = std::get_if<Problem>(&outcome)) throw ProblemError(*problem);
  std::rethrow_exception(std::get<std::exception_ptr>(outcome));
}

}  // namespace caustic::service
