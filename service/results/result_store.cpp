#include "service/results/result_store.h"

#include <fstream>
#include <system_error>

#include "service/api/identity.h"
#include "service/api/problem.h"
#include "service/results/atomic_file.h"

namespace caustic::service {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".record";

bool can_be_whole(const fs::path& path, std::uint64_t size) {
  std::string beginning(kRecordHeaderSize, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(beginning.data(), static_cast<std::streamsize>(beginning.size()));
  return in && size_fits(beginning, size);
}

}  // namespace

ResultStore::ResultStore(fs::path folder) : folder_(std::move(folder)) {
  fs::create_directories(folder_);
  sweep();
}

void ResultStore::sweep() const {
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    std::error_code ignored;  // another server may sweep the same folder
    const std::string suffix = entry.path().extension().string();
    const bool broken = suffix == kSuffix && !can_be_whole(entry.path(), entry.file_size(ignored));
    if (suffix == kTemporarySuffix || broken) fs::remove(entry.path(), ignored);
  }
}

fs::path ResultStore::path_of(const std::string& id) const {
  return folder_ / (id + std::string(kSuffix));
}

std::optional<std::string> ResultStore::read(const std::string& id) const {
  return is_id(id) ? read_file(path_of(id)) : std::nullopt;
}

std::optional<ResultRecord> ResultStore::load(const std::string& id) const {
  const auto bytes = read(id);
  return bytes ? decode(*bytes) : std::nullopt;
}

std::optional<std::string> ResultStore::load_answer(const std::string& id) const {
  const auto bytes = read(id);
  return bytes ? decode_answer(*bytes) : std::nullopt;
}

bool ResultStore::save(const std::string& id, const ResultRecord& record) const {
  try {
    const std::string bytes = encode(record);
    // A record that is there but broken must give way.
    if (const auto present = read(id); present && !decode_answer(*present)) fs::remove(path_of(id));
    return create_file(path_of(id), bytes);
  } catch (const std::system_error& error) {
    throw ProblemError(make_problem(507, "the result cannot be stored: " + error.code().message()));
  }
}

}  // namespace caustic::service
