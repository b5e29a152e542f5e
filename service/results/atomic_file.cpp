#include "service/results/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "service/api/identity.h"

namespace caustic::service {
namespace {

[[noreturn]] void fail(const char* what) {
  throw std::system_error(errno, std::generic_category(), what);
}

/// A file descriptor that closes itself.
class Descriptor {
 public:
  Descriptor(const std::filesystem::path& path, int flags) : fd_(open(path.c_str(), flags, 0644)) {}
  ~Descriptor() {
    if (fd_ >= 0) close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const { return fd_; }
  explicit operator bool() const { return fd_ >= 0; }

 private:
  int fd_;
};

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
  const Descriptor descriptor(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (!descriptor || fsync(descriptor.get()) != 0) fail("sync folder");
}

}  // namespace

bool create_file(const std::filesystem::path& path, std::string_view bytes) {
  std::filesystem::path temporary = path;
  temporary += "." + random_id().substr(0, 16) + std::string(kTemporarySuffix);
  bool is_new = false;
  {
    const Descriptor file(temporary, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC);
    if (!file) fail("create");
    const Remover remover{temporary};  // of no effect once renamed
    write_all(file.get(), bytes);
    if (fsync(file.get()) != 0) fail("sync");
    is_new = rename_unless_there(temporary, path);
  }
  sync_folder(path.parent_path());
  return is_new;
}

std::optional<std::string> read_file(const std::filesystem::path& path) {
  const Descriptor file(path, O_RDONLY | O_CLOEXEC);
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
