#include "service/results/result_store.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <system_error>
#include <vector>

#include "service/api/identity.h"
#include "service/api/problem.h"
#include "service/descriptor.h"
#include "service/results/atomic_file.h"

namespace caustic::service {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".record";
constexpr std::size_t kAnswersInMemory = 8u << 20;
/// Another server on the same folder writes too: the sum is taken anew after so many records.
constexpr std::uint64_t kSavesBetweenSums = 64;
/// What is evicted to: not every record should cost a look at all.
constexpr double kRoomShare = 0.9;

bool can_be_whole(const fs::path& path, std::uint64_t size) {
  std::string beginning(kRecordHeaderSize, '\0');
  std::ifstream in(path, std::ios::binary);
  in.read(beginning.data(), static_cast<std::streamsize>(beginning.size()));
  return in && size_fits(beginning, size);
}

/// Says that the record was asked for just now. To the second: often enough for those that are
/// asked for all the time.
void touch(const fs::path& path, const struct stat& status) {
  timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (now.tv_sec != status.st_mtim.tv_sec) utimensat(AT_FDCWD, path.c_str(), nullptr, 0);
}

struct StoredFile {
  fs::path path;
  std::uint64_t size;
  fs::file_time_type asked;
};

/// All records, the one that was not asked for the longest first.
std::vector<StoredFile> stored_files(const fs::path& folder) {
  std::vector<StoredFile> out;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    std::error_code gone;  // others evict too
    if (entry.path().extension() != kSuffix) continue;
    const StoredFile file{entry.path(), entry.file_size(gone), entry.last_write_time(gone)};
    if (!gone) out.push_back(file);
  }
  std::sort(out.begin(), out.end(),
            [](const StoredFile& a, const StoredFile& b) { return a.asked < b.asked; });
  return out;
}

}  // namespace

ResultStore::ResultStore(fs::path folder, std::uint64_t max_bytes)
    : folder_(std::move(folder)), max_bytes_(max_bytes), answers_(kAnswersInMemory) {
  fs::create_directories(folder_);
  sweep();
  evict("");
}

void ResultStore::sweep() const {
  sweep_temporaries(folder_);
  for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
    std::error_code ignored;  // another server may sweep the same folder
    if (entry.path().extension() == kSuffix &&
        !can_be_whole(entry.path(), entry.file_size(ignored)))
      fs::remove(entry.path(), ignored);
  }
}

void ResultStore::evict(const std::string& but) const {
  const std::lock_guard lock(evicting_);
  const std::vector<StoredFile> files = stored_files(folder_);
  std::uint64_t sum = 0;
  for (const StoredFile& file : files) sum += file.size;
  const auto room = static_cast<std::uint64_t>(kRoomShare * static_cast<double>(max_bytes_));
  if (sum > max_bytes_) {
    for (const StoredFile& file : files) {
      const std::string id = file.path.stem().string();
      if (sum <= room) break;
      if (id == but) continue;
      std::error_code ignored;
      fs::remove(file.path, ignored);
      answers_.remove(id);
      sum -= file.size;
    }
  }
  bytes_ = sum;
}

fs::path ResultStore::path_of(const std::string& id) const {
  return folder_ / (id + std::string(kSuffix));
}

bool ResultStore::contains(const std::string& id) const {
  struct stat status;
  if (!is_id(id) || stat(path_of(id).c_str(), &status) != 0) return false;
  touch(path_of(id), status);
  return true;
}

std::uint64_t ResultStore::size_of(const std::string& id) const {
  struct stat status;
  const bool there = is_id(id) && stat(path_of(id).c_str(), &status) == 0;
  return there ? static_cast<std::uint64_t>(status.st_size) : 0;
}

std::optional<std::string> ResultStore::read(const std::string& id) const {
  return contains(id) ? read_file(path_of(id)) : std::nullopt;
}

std::optional<ResultRecord> ResultStore::load(const std::string& id) const {
  const auto bytes = read(id);
  return bytes ? decode(*bytes) : std::nullopt;
}

std::shared_ptr<const std::string> ResultStore::find_answer(const std::string& id) const {
  // Another server may have evicted it: what is in memory counts as long as the file is there.
  if (auto answer = answers_.find(id)) {
    if (contains(id)) return answer;
    answers_.remove(id);
  }
  const auto bytes = read(id);
  auto decoded = bytes ? decode_answer(*bytes) : std::nullopt;
  if (!decoded) return nullptr;
  auto answer = std::make_shared<const std::string>(std::move(*decoded));
  answers_.add(id, answer);
  return answer;
}

std::optional<std::string> ResultStore::load_answer(const std::string& id) const {
  const auto answer = find_answer(id);
  return answer ? std::optional(*answer) : std::nullopt;
}

bool ResultStore::save(const std::string& id, const ResultRecord& record) const {
  try {
    const std::string bytes = encode(record);
    // A record that is there but broken must give way.
    if (const auto present = read(id); present && !decode_answer(*present)) {
      fs::remove(path_of(id));
      answers_.remove(id);
    }
    const bool is_new = create_file(path_of(id), bytes);
    if (is_new) bytes_ += bytes.size();
    if (bytes_ > max_bytes_ || ++saves_ % kSavesBetweenSums == 0) evict(id);
    return is_new;
  } catch (const std::system_error& error) {
    throw ProblemError(make_problem(507, "the result cannot be stored: " + error.code().message()));
  }
}

bool ResultStore::writable() const {
  const fs::path path =
      folder_ / ("probe." + random_id().substr(0, 16) + std::string(kTemporarySuffix));
  const Descriptor file(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  const bool good = file && ::write(file.get(), "?", 1) == 1;
  ::unlink(path.c_str());
  return good;
}

}  // namespace caustic::service
