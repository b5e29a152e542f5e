// The results, one file each, named by their identity. A file appears whole or not at all: it is
// written under a temporary name, synced, renamed, and the folder synced. When they take too much
// room, those that were not asked for the longest go; a file's time of change is when it was. Safe
// for many threads and processes.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "service/results/answer_cache.h"
#include "service/results/result_record.h"

namespace caustic::service {

class ResultStore {
 public:
  static constexpr std::uint64_t kDefaultBytes = std::uint64_t{4} << 30;

  /// Creates the folder with its parents; removes what an interrupted server left behind.
  /// Throws std::system_error if the folder cannot be used.
  explicit ResultStore(std::filesystem::path folder, std::uint64_t max_bytes = kDefaultBytes);

  std::optional<ResultRecord> load(const std::string& id) const;
  /// Null if there is none.
  std::shared_ptr<const std::string> find_answer(const std::string& id) const;
  std::optional<std::string> load_answer(const std::string& id) const;
  bool contains(const std::string& id) const;
  /// Bytes of its record, 0 if there is none.
  std::uint64_t size_of(const std::string& id) const;

  /// Stores the record, unless one of this id is there already: the first stays, and false is
  /// returned. Returns once it is on disk. Throws ProblemError (507), leaving nothing behind, if
  /// that fails.
  bool save(const std::string& id, const ResultRecord& record) const;

  /// True if a file can be written, which is tried.
  bool writable() const;
  /// Bytes of all records, as far as this process knows.
  std::uint64_t bytes() const { return bytes_; }
  const std::filesystem::path& folder() const { return folder_; }

 private:
  std::filesystem::path path_of(const std::string& id) const;
  std::optional<std::string> read(const std::string& id) const;
  void sweep() const;
  void evict(const std::string& but) const;

  const std::filesystem::path folder_;
  const std::uint64_t max_bytes_;
  mutable AnswerCache answers_;
  mutable std::mutex evicting_;
  mutable std::atomic<std::uint64_t> bytes_ = 0, saves_ = 0;
};

}  // namespace caustic::service
