#include "service/http/reactor.h"

#include <gtest/gtest.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <future>
#include <mutex>
#include <thread>

#include "service/descriptor.h"

namespace caustic::service {
namespace {

using std::chrono::milliseconds;

HttpResponse text(std::string body) { return {200, "text/plain", std::move(body), {}}; }

/// The other end of a connection.
class Client {
 public:
  explicit Client(Reactor& reactor, int buffer = 0) {
    int ends[2];
    EXPECT_EQ(socketpair(AF_UNIX, SOCK_STREAM, 0, ends), 0);
    if (buffer) setsockopt(ends[1], SOL_SOCKET, SO_SNDBUF, &buffer, sizeof buffer);
    socket_ = Descriptor(ends[0]);
    reactor.adopt(ends[1]);
  }
  bool send(const std::string& bytes) const {
    return ::send(socket_.get(), bytes.data(), bytes.size(), MSG_NOSIGNAL) == ssize_t(bytes.size());
  }
  /// Reads until `end` has come or the connection is closed.
  std::string receive_until(const std::string& end) const {
    std::string out;
    char bytes[4096];
    while (out.find(end) == out.npos) {
      pollfd ready{socket_.get(), POLLIN, 0};
      if (poll(&ready, 1, 30'000) != 1) return out + " TIMEOUT";
      const ssize_t count = recv(socket_.get(), bytes, sizeof bytes, 0);
      if (count <= 0) return out;
      out.append(bytes, static_cast<std::size_t>(count));
    }
    return out;
  }
  std::string receive_all() const { return receive_until("\1 never"); }
  void end_sending() const { shutdown(socket_.get(), SHUT_WR); }
  void close() { socket_ = Descriptor(); }

 private:
  Descriptor socket_;
};

const std::string kGet = "GET /a HTTP/1.1\r\nHost: x\r\n\r\n";

void echo(HttpRequest request, const std::shared_ptr<Exchange>& exchange) {
  if (request.refusal) {
    HttpResponse response = text(request.refusal->detail);
    response.status = request.refusal->status;
    return exchange->answer(std::move(response));
  }
  exchange->answer(text(request.target + "=" + request.body + ";"));
}

ReactorOptions quick() {
  ReactorOptions options;
  options.threads = 1;
  options.head_time = options.body_time = options.idle_time = milliseconds(300);
  return options;
}
ReactorOptions one_thread() {
  ReactorOptions options;
  options.threads = 1;
  return options;
}

/// A handler that keeps one request's way back.
class Kept {
 public:
  HttpHandler handler() {
    return [this](HttpRequest, std::shared_ptr<Exchange> exchange) {
      exchange->on_leave([this] { left.set_value(); });
      exchange_ = std::move(exchange);
      here.set_value();
    };
  }
  /// Once the request is here.
  void wait() { here.get_future().wait(); }
  void answer(std::string body) { exchange_->answer(text(std::move(body))); }

  std::promise<void> here, left;

 private:
  std::shared_ptr<Exchange> exchange_;
};

TEST(Reactor, answers_what_comes_at_once_in_its_order) {
  Reactor reactor(echo, one_thread());
  const Client client(reactor);
  std::string bytes;
  for (int i = 0; i < 100; ++i)
    bytes += "POST /" + std::to_string(i) + " HTTP/1.1\r\nHost: x\r\nContent-Length: 2\r\n\r\nxy";
  client.send(bytes + "GET /last HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n");
  const std::string answers = client.receive_all();
  std::size_t at = 0;
  for (int i = 0; i < 100; ++i) {
    at = answers.find("\r\n\r\n/" + std::to_string(i) + "=xy;", at);
    ASSERT_NE(at, answers.npos) << i;
  }
  EXPECT_TRUE(answers.ends_with("Connection: close\r\n\r\n/last=;"));
}

TEST(Reactor, one_thread_serves_others_beside_those_who_are_idle_or_slow) {
  std::vector<std::shared_ptr<Exchange>> waiting;
  std::mutex mutex;
  ReactorOptions options = one_thread();
  Reactor reactor(
      [&](HttpRequest request, std::shared_ptr<Exchange> exchange) {
        if (request.target == "/big")
          return exchange->answer(text(std::string(10 << 20, 'x') + ';'));
        if (request.target != "/later") return echo(std::move(request), exchange);
        const std::lock_guard lock(mutex);
        waiting.push_back(std::move(exchange));
      },
      options);
  std::vector<std::unique_ptr<Client>> others;
  for (int i = 0; i < 40; ++i) {
    others.push_back(std::make_unique<Client>(reactor));
    const char* beginnings[] = {
        "", "GET /a HT", "POST /a HTTP/1.1\r\nHost: x\r\nContent-Length: 9\r\n\r\nab",
        "GET /big HTTP/1.1\r\nHost: x\r\n\r\n", "GET /later HTTP/1.1\r\nHost: x\r\n\r\n"};
    others.back()->send(beginnings[i % 5]);
  }
  const Client client(reactor);
  for (int i = 0; i < 20; ++i) {
    client.send(kGet);
    EXPECT_TRUE(client.receive_until("/a=;").ends_with("/a=;"));
  }
  others[1]->send("TP/1.1\r\nHost: x\r\n\r\n");  // it was slow, not lost
  EXPECT_TRUE(others[1]->receive_until("/a=;").ends_with("/a=;"));
  const auto later = [&] {
    const std::lock_guard lock(mutex);
    return waiting.size();
  };
  for (int i = 0; i < 3000 && later() < 8; ++i) std::this_thread::sleep_for(milliseconds(1));
  ASSERT_EQ(later(), 8u);
  for (const auto& exchange : waiting) exchange->answer(text("now;"));
  EXPECT_TRUE(others[4]->receive_until("now;").ends_with("now;"));
  EXPECT_GT(others[3]->receive_until(";").size(), 10u << 20);
}

TEST(Reactor, who_takes_too_long_is_told_so) {
  Reactor reactor(echo, quick());
  ReactorOptions quick_when_idle = one_thread();  // there is time for a first request
  quick_when_idle.idle_time = milliseconds(50);
  Reactor other(echo, quick_when_idle);
  const Client head(reactor), body(reactor), idle(reactor), used(other);
  head.send("GET /a HT");
  body.send("POST /a HTTP/1.1\r\nHost: x\r\nContent-Length: 9\r\n\r\nab");
  used.send(kGet);
  EXPECT_TRUE(head.receive_all().starts_with("HTTP/1.1 408 "));
  EXPECT_TRUE(body.receive_all().starts_with("HTTP/1.1 408 "));
  EXPECT_EQ(idle.receive_all(), "");
  EXPECT_TRUE(used.receive_all().ends_with("/a=;"));
}

/// A byte now and then does not put the end off.
TEST(Reactor, dripping_does_not_help) {
  Reactor reactor(echo, quick());
  const Client client(reactor);
  client.send("GET /");
  for (int i = 0; i < 2000 && client.send("a"); ++i) {
    std::this_thread::sleep_for(milliseconds(5));
    if (reactor.connections() == 0) break;
    if (i == 100) break;
  }
  EXPECT_TRUE(client.receive_all().starts_with("HTTP/1.1 408 "));
}

TEST(Reactor, the_longest_idle_makes_room) {
  ReactorOptions options = one_thread();
  options.max_connections = 3;
  Reactor reactor(echo, options);
  const Client first(reactor);
  std::this_thread::sleep_for(milliseconds(2));
  const Client second(reactor), third(reactor);
  second.send("GET /a HT");  // at work
  std::this_thread::sleep_for(milliseconds(20));
  const Client fourth(reactor);
  EXPECT_EQ(first.receive_all(), "");
  fourth.send(kGet);
  EXPECT_TRUE(fourth.receive_until(";").ends_with("/a=;"));
  second.send("TP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_TRUE(second.receive_until(";").ends_with("/a=;"));
}

TEST(Reactor, bodies_together_are_bounded) {
  ReactorOptions options = one_thread();
  options.max_input = 1u << 20;
  Reactor reactor(echo, options);
  std::vector<std::unique_ptr<Client>> clients;
  int refused = 0;
  for (int i = 0; i < 8; ++i) {
    clients.push_back(std::make_unique<Client>(reactor));
    clients.back()->send("POST /a HTTP/1.1\r\nHost: x\r\nContent-Length: 8000000\r\n\r\n");
    std::thread sender([&] { clients.back()->send(std::string(400'000, 'x')); });
    sender.join();
  }
  for (const auto& client : clients) {
    client->end_sending();
    refused += client->receive_all().starts_with("HTTP/1.1 503 ");
  }
  EXPECT_GT(refused, 0);
  EXPECT_LT(refused, 8);
}

TEST(Reactor, tells_when_a_client_leaves_before_its_answer) {
  Kept kept;
  Reactor reactor(kept.handler(), one_thread());
  Client client(reactor);
  client.send(kGet);
  client.close();
  ASSERT_EQ(kept.left.get_future().wait_for(std::chrono::seconds(30)), std::future_status::ready);
  kept.answer("too late");
  for (int i = 0; i < 3000 && reactor.connections() > 0; ++i)
    std::this_thread::sleep_for(milliseconds(1));
  EXPECT_EQ(reactor.connections(), 0u);
}

TEST(Reactor, an_answer_may_come_after_its_end) {
  Kept kept;
  {
    Reactor reactor(kept.handler(), one_thread());
    const Client client(reactor);
    client.send(kGet);
    kept.wait();
  }
  kept.answer("too late");
}

TEST(Reactor, draining_waits_for_answers_and_ends_the_rest) {
  Kept kept;
  Reactor reactor(kept.handler(), one_thread());
  const Client idle(reactor), busy(reactor);
  busy.send(kGet);
  kept.wait();
  std::thread answering([&] {
    std::this_thread::sleep_for(milliseconds(20));
    kept.answer("at last;");
  });
  reactor.drain(std::chrono::seconds(30));
  answering.join();
  EXPECT_EQ(reactor.connections(), 0u);
  EXPECT_EQ(idle.receive_all(), "");
  EXPECT_TRUE(busy.receive_all().ends_with("Connection: close\r\n\r\nat last;"));
}

/// Counts to a number, one at a time.
class Counting : public EventSource {
 public:
  explicit Counting(int last) : last_(last) {}
  bool next(std::string& out) override {
    out += "data: " + std::to_string(++now_) + "\n\n";
    return now_ < last_;
  }

 private:
  int now_ = 0, last_;
};

TEST(Reactor, streams_events_on_no_thread_and_only_so_many) {
  ReactorOptions options = one_thread();
  options.max_streams = 2;
  Reactor reactor(
      [](HttpRequest request, const std::shared_ptr<Exchange>& exchange) {
        if (request.target == "/a") return echo(std::move(request), exchange);
        HttpResponse response{200, "text/event-stream", "", {}};
        response.events = std::make_shared<Counting>(request.target == "/3" ? 3 : 1 << 30);
        exchange->answer(std::move(response));
      },
      options);
  Client endless(reactor);
  endless.send("GET /endless HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_NE(endless.receive_until("data: 2\n\n").find("text/event-stream"), std::string::npos);
  const Client three(reactor);
  three.send("GET /3 HTTP/1.1\r\nHost: x\r\n\r\n");
  three.receive_until("data: 1\n\n");
  const Client refused(reactor);
  refused.send("GET /3 HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_TRUE(refused.receive_until("\r\n\r\n").starts_with("HTTP/1.1 503 "));
  EXPECT_TRUE(three.receive_all().ends_with("data: 3\n\n"));
  const Client other(reactor);
  other.send(kGet);
  EXPECT_TRUE(other.receive_until(";").ends_with("/a=;"));
  endless.close();
  for (int i = 0; i < 3000 && reactor.connections() > 2; ++i)
    std::this_thread::sleep_for(milliseconds(1));
  EXPECT_EQ(reactor.connections(), 2u);  // `refused` and `other` are of use still
}

TEST(Reactor, many_threads_many_clients) {
  ReactorOptions options;
  options.threads = 4;
  Reactor reactor(echo, options);
  std::atomic<int> good = 0;
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t)
    threads.emplace_back([&] {
      for (int i = 0; i < 20; ++i) {
        const Client client(reactor);
        for (int k = 0; k < 5; ++k) {
          client.send(kGet);
          good += client.receive_until("/a=;").ends_with("/a=;");
        }
      }
    });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(good, 4 * 20 * 5);
}

}  // namespace
}  // namespace caustic::service
