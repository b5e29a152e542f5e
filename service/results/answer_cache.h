// Answers that were asked for lately, in memory, so that an answer takes microseconds.
#pragma once

#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <unordered_map>
#include <utility>

namespace caustic::service {

class AnswerCache {
 public:
  explicit AnswerCache(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// Null if it is not here.
  std::shared_ptr<const std::string> find(const std::string& id);
  /// What was asked for least lately gives way. Answers too large to be kept with others are not.
  void add(const std::string& id, std::shared_ptr<const std::string> answer);
  void remove(const std::string& id);

 private:
  using Entry = std::pair<std::string, std::shared_ptr<const std::string>>;

  const std::size_t max_bytes_;
  std::mutex mutex_;
  std::list<Entry> entries_;  ///< the latest first
  std::unordered_map<std::string, std::list<Entry>::iterator> places_;
  std::size_t bytes_ = 0;
};

}  // namespace caustic::service
