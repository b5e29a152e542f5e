// What a server that is killed leaves behind, whatever the moment.
#include <gtest/gtest.h>

#include <atomic>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>
#include <vector>

#include "tests/support/http_client.h"
#include "tests/support/program.h"
#include "tests/support/requests.h"
#include "tests/support/temporary_folder.h"

namespace caustic::test {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

constexpr int kClients = 200;

/// Rounds of the suite; ISOCAUSTIC_KILLS says otherwise.
int rounds() {
  const char* wanted = std::getenv("ISOCAUSTIC_KILLS");
  return wanted ? std::atoi(wanted) : 2;
}

/// The post of one client, like no other's. Every fourth asks for a job.
std::string post_bytes(int round, int client) {
  json request = ball_request();
  request["levels"] = {3e-4 * (1 + 1e-3 * round + 1e-6 * client)};
  const std::string body = request.dump();
  return post_head("/v1/contours", "Content-Type: application/json\r\nContent-Length: " +
                                       std::to_string(body.size()) + "\r\n" +
                                       (client % 4 ? "" : "Prefer: respond-async\r\n")) +
         body;
}

std::vector<std::string> names_in(const fs::path& folder, const std::string& suffix) {
  std::vector<std::string> out;
  if (!fs::exists(folder)) return out;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == suffix) out.push_back(entry.path().stem().string());
  return out;
}

/// All clients at once; the server is killed once so many have their answer, and a moment later.
std::vector<HttpReply> killed_while_posting(const fs::path& data, int round, int answers,
                                            std::chrono::microseconds moment) {
  ServerProcess victim(data, {"--queue", std::to_string(kClients)});
  std::vector<std::unique_ptr<HttpConnection>> clients;
  for (int i = 0; i < kClients; ++i) {
    clients.push_back(std::make_unique<HttpConnection>(victim.port()));
    EXPECT_TRUE(clients.back()->send(post_bytes(round, i)));
  }
  std::vector<HttpReply> replies(kClients);
  std::atomic<int> answered = 0;
  std::vector<std::thread> readers;
  for (std::size_t i = 0; i < replies.size(); ++i)
    readers.emplace_back([&, i] {
      replies[i] = clients[i]->receive();
      answered += replies[i].status != 0;
    });
  for (int wait = 0; wait < 60'000 && answered < answers; ++wait)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  std::this_thread::sleep_for(moment);
  EXPECT_TRUE(victim.running());
  victim.stop(SIGKILL);
  for (std::thread& reader : readers) reader.join();
  EXPECT_GE(answered, answers);
  return replies;
}

TEST(KilledServer, leaves_whole_files_and_all_that_it_answered) {
  const TemporaryFolder folder;
  const fs::path data = folder.path() / "data";
  std::mt19937_64 random(20261122);
  std::vector<HttpReply> replies;
  for (int round = 0; round < rounds(); ++round) {
    const auto answers = static_cast<int>(kClients / 4 + random() % (kClients / 2));
    const auto moment = std::chrono::microseconds(random() % 5000);
    for (HttpReply& reply : killed_while_posting(data, round, answers, moment))
      replies.push_back(std::move(reply));
  }
  const std::size_t stored = names_in(data, ".record").size();
  EXPECT_GT(stored, 0u);

  const ServerProcess again(data);
  for (const fs::path& place : {data, data / "jobs"}) EXPECT_TRUE(names_in(place, ".tmp").empty());
  const auto ids = names_in(data, ".record");
  EXPECT_EQ(ids.size(), stored);  // none was broken, so none was swept away
  HttpConnection client(again.port());
  const auto get = [&](const std::string& target) {
    EXPECT_TRUE(client.send("GET " + target + " HTTP/1.1\r\nHost: x\r\n\r\n"));
    return client.receive();
  };
  for (const std::string& id : ids) EXPECT_EQ(get("/v1/results/" + id + ".csv").status, 200) << id;
  int whole = 0;
  for (const HttpReply& reply : replies) {
    const json answer = json::parse(reply.body, nullptr, false);
    if (answer.is_discarded()) continue;  // cut off on its way by the kill
    ++whole;
    const std::string id = answer["id"];
    if (reply.status == 200) {
      EXPECT_EQ(get("/v1/results/" + id).body, reply.body);
      continue;
    }
    ASSERT_EQ(reply.status, 202) << reply.body;
    const json job = json::parse(get("/v1/jobs/" + id).body);
    if (job["status"] == "successful") {
      EXPECT_EQ(get(job["result"]).status, 200) << job;
    } else {
      EXPECT_EQ(job["status"], "failed");
      EXPECT_TRUE(job["problem"]["detail"].get<std::string>().starts_with("interrupted")) << job;
    }
  }
  EXPECT_GT(whole, 0);
}

}  // namespace
}  // namespace caustic::test
