#include "service/results/answer_cache.h"

namespace caustic::service {
namespace {

constexpr std::size_t kLargestShare = 8;  // of the cache, as its divisor

}  // namespace

std::shared_ptr<const std::string> AnswerCache::find(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto place = places_.find(id);
  if (place == places_.end()) return nullptr;
  entries_.splice(entries_.begin(), entries_, place->second);
  return place->second->second;
}

void AnswerCache::add(const std::string& id, std::shared_ptr<const std::string> answer) {
  if (answer->size() > max_bytes_ / kLargestShare) return;
  const std::lock_guard lock(mutex_);
  if (places_.contains(id)) return;
  bytes_ += answer->size();
  entries_.emplace_front(id, std::move(answer));
  places_[id] = entries_.begin();
  while (bytes_ > max_bytes_) {
    bytes_ -= entries_.back().second->size();
    places_.erase(entries_.back().first);
    entries_.pop_back();
  }
}

void AnswerCache::remove(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto place = places_.find(id);
  if (place == places_.end()) return;
  bytes_ -= place->second->second->size();
  entries_.erase(place->second);
  places_.erase(place);
}

}  // namespace caustic::service
