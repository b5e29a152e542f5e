#include "service/http/reactor.h"

#include <sys/eventfd.h>
#include <sys/socket.h>

#include <cerrno>
#include <condition_variable>
#include <system_error>
#include <thread>

#include "service/http/reactor_core.h"

namespace caustic::service {
namespace {

using std::chrono::milliseconds;

constexpr auto kTick = milliseconds(100);
constexpr std::uint64_t kWakeId = 0;

Descriptor checked(int descriptor, const char* what) {
  if (descriptor < 0) throw std::system_error(errno, std::generic_category(), what);
  return Descriptor(descriptor);
}

}  // namespace

Reactor::Core::Core(HttpHandler the_handler, const ReactorOptions& the_options)
    : handler(std::move(the_handler)),
      options(the_options),
      epoll(checked(epoll_create1(EPOLL_CLOEXEC), "epoll")),
      wake(checked(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK), "eventfd")) {
  epoll_event event{EPOLLIN, {.u64 = kWakeId}};
  if (epoll_ctl(epoll.get(), EPOLL_CTL_ADD, wake.get(), &event) != 0)
    throw std::system_error(errno, std::generic_category(), "epoll");
}

std::shared_ptr<Reactor::Connection> Reactor::Core::find(std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  const auto found = connections_.find(id);
  return found == connections_.end() ? nullptr : found->second;
}

std::vector<std::shared_ptr<Reactor::Connection>> Reactor::Core::all() {
  const std::lock_guard lock(mutex_);
  std::vector<std::shared_ptr<Connection>> out;
  out.reserve(connections_.size());
  for (const auto& [id, connection] : connections_) out.push_back(connection);
  return out;
}

void Reactor::Core::add(std::uint64_t id, std::shared_ptr<Connection> connection) {
  const std::lock_guard lock(mutex_);
  connections_.emplace(id, std::move(connection));
  ++count;
}

void Reactor::Core::remove(std::uint64_t id) {
  const std::lock_guard lock(mutex_);
  count -= connections_.erase(id);
}

struct Reactor::Threads {
  std::vector<std::thread> workers;
  std::thread ticker;
  std::atomic<bool> stopping = false;
  std::mutex mutex;
  std::condition_variable stopped;
};

Reactor::Reactor(HttpHandler handler, const ReactorOptions& options)
    : core_(std::make_shared<Core>(std::move(handler), options)),
      threads_(std::make_unique<Threads>()) {
  const auto work = [core = core_, &stopping = threads_->stopping] {
    while (!stopping) {
      epoll_event event;  // one at a time: a thread that is long at one delays no other
      if (epoll_wait(core->epoll.get(), &event, 1, -1) != 1 || event.data.u64 == kWakeId) continue;
      if (const auto connection = core->find(event.data.u64)) connection->handle(event.events);
    }
  };
  for (int i = 0; i < options.threads; ++i) threads_->workers.emplace_back(work);
  threads_->ticker = std::thread([core = core_, &threads = *threads_] {
    std::unique_lock lock(threads.mutex);
    while (!threads.stopped.wait_for(lock, kTick, [&] { return threads.stopping.load(); })) {
      const auto now = ReactorClock::now();
      for (const auto& connection : core->all()) connection->tick(now);
    }
  });
}

Reactor::~Reactor() {
  {
    const std::lock_guard lock(threads_->mutex);
    threads_->stopping = true;
  }
  threads_->stopped.notify_one();
  core_->draining = true;
  const std::uint64_t one = 1;
  if (::write(core_->wake.get(), &one, sizeof one) != sizeof one)
    std::abort();  // it cannot be full
  for (std::thread& worker : threads_->workers) worker.join();
  threads_->ticker.join();
  for (const auto& connection : core_->all()) connection->close_now();
}

void Reactor::adopt(int descriptor) {
  if (core_->count >= core_->options.max_connections) {
    std::shared_ptr<Connection> oldest;
    auto since = ReactorClock::time_point::max();
    for (const auto& connection : core_->all())
      if (const auto idle = connection->idle_since(); idle && *idle < since)
        since = *idle, oldest = connection;
    // Nobody is idle: closing is all that can be said without a place to say it from.
    if (!oldest || !oldest->close_if_reading()) return void(::close(descriptor));
  }
  const std::uint64_t id = core_->next_id++;
  const auto connection = std::make_shared<Connection>(core_, id, descriptor);
  core_->add(id, connection);
  connection->begin();
  if (core_->draining) connection->close_if_reading();
}

void Reactor::drain(milliseconds patience) {
  core_->draining = true;
  for (const auto& connection : core_->all()) connection->close_if_reading();
  const auto deadline = ReactorClock::now() + patience;
  while (core_->count > 0 && ReactorClock::now() < deadline)
    std::this_thread::sleep_for(milliseconds(2));
}

std::size_t Reactor::connections() const { return core_->count; }

}  // namespace caustic::service
