#include "service/results/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "service/api/identity.h"
#include "service/descriptor.h"

namespace caustic::service {
namespace {

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

Descriptor open_file(const std::filesystem::path& path, int flags) {
  return Descriptor(open(path.c_str(), flags | O_CLOEXEC, 0644));
}

/// Removes a name when it goes out of scope.
struct Remover {
  const std::filesystem::path& path;
  ~Remover() { unlink(path.c_str()); }
};

void write_all(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) fail("write");
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
}

bool rename_unless_there(const std::filesystem::path& from, const std::filesystem::path& to) {
  if (renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  if (errno == EEXIST) return false;
  // A file system without RENAME_NOREPLACE: the same result replaces itself.
  if (errno != EINVAL && errno != ENOSYS) fail("rename");
  if (rename(from.c_str(), to.c_str()) != 0) fail("rename");
  return true;
}

void sync_folder(const std::filesystem::path& folder) {
  const Descriptor descriptor = open_file(folder, O_RDONLY | O_DIRECTORY);
  if (!descriptor || fsync(descriptor.get()) != 0) fail("sync folder");
}

/// A new file that is locked, so that nobody takes it for one that was left behind.
Descriptor open_temporary(const std::filesystem::path& path) {
  while (true) {
    Descriptor file = open_file(path, O_WRONLY | O_CREAT | O_EXCL);
    if (!file || flock(file.get(), LOCK_EX) != 0) fail("create");
    struct stat status;
    if (fstat(file.get(), &status) == 0 && status.st_nlink > 0) return file;
    // Swept between its creation and the lock.
  }
}

bool write_file(const std::filesystem::path& path, std::string_view bytes, bool replaces) {
  std::filesystem::path temporary = path;
  temporary += "." + random_id().substr(0, 16) + std::string(kTemporarySuffix);
  bool is_new = true;
  {
    const Descriptor file = open_temporary(temporary);
    const Remover remover{temporary};  // of no effect once renamed
    write_all(file.get(), bytes);
    if (fsync(file.get()) != 0) fail("sync");
    if (!replaces)
      is_new = rename_unless_there(temporary, path);
    else if (rename(temporary.c_str(), path.c_str()) != 0)
      fail("rename");
  }
  sync_folder(path.parent_path());
  return is_new;
}

}  // namespace

bool create_file(const std::filesystem::path& path, std::string_view bytes) {
  return write_file(path, bytes, false);
}

void replace_file(const std::filesystem::path& path, std::string_view bytes) {
  write_file(path, bytes, true);
}

void sweep_temporaries(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != kTemporarySuffix) continue;
    const Descriptor file = open_file(entry.path(), O_RDONLY);
    if (file && flock(file.get(), LOCK_EX | LOCK_NB) == 0) unlink(entry.path().c_str());
  }
}

std::optional<std::string> read_file(const std::filesystem::path& path) {
  const Descriptor file = open_file(path, O_RDONLY);
  if (!file && errno == ENOENT) return std::nullopt;
  struct stat status;
  if (!file || fstat(file.get(), &status) != 0) fail("open");
  std::string out(static_cast<std::size_t>(status.st_size), '\0');
  std::size_t done = 0;
  while (done < out.size()) {
    const ssize_t count = read(file.get(), out.data() + done, out.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) fail("read");
    if (count == 0) break;
    done += static_cast<std::size_t>(count);
  }
  out.resize(done);
  return out;
}

}  // namespace caustic::service
