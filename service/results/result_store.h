// The results, one file each, named by their identity. A file appears whole or not at all: it is
// written under a temporary name, synced, renamed, and the folder synced. Safe for many threads and
// processes.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "service/results/result_record.h"

namespace caustic::service {

class ResultStore {
 public:
  /// Creates the folder with its parents; removes what an interrupted server left behind.
  /// Throws std::system_error if the folder cannot be used.
  explicit ResultStore(std::filesystem::path folder);

  std::optional<ResultRecord> load(const std::string& id) const;
  std::optional<std::string> load_answer(const std::string& id) const;

  /// Stores the record, unless one of this id is there already: the first stays, and false is
  /// returned. Returns once it is on disk. Throws ProblemError (507), leaving nothing behind, if
  /// that fails.
  bool save(const std::string& id, const ResultRecord& record) const;

 private:
  std::filesystem::path path_of(const std::string& id) const;
  std::optional<std::string> read(const std::string& id) const;
  void sweep() const;

  std::filesystem::path folder_;
};

}  // namespace caustic::service
