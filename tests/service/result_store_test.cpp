#include "service/results/result_store.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/resource.h>

#include <csignal>
#include <fstream>
#include <thread>

#include "service/api/identity.h"
#include "service/api/problem.h"
#include "service/descriptor.h"
#include "tests/support/polylines.h"
#include "tests/support/temporary_folder.h"

namespace caustic::service {
namespace {

namespace fs = std::filesystem;

const std::string kId(64, '7');

ResultRecord record(const std::string& answer = "{}") { return {answer, test::sample_polylines()}; }

void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

TEST(ResultStore, keeps_what_it_is_given) {
  const test::TemporaryFolder folder;
  const fs::path deep = folder.path() / "a" / "b";
  {
    const ResultStore store(deep);
    EXPECT_FALSE(store.load(kId));
    EXPECT_TRUE(store.save(kId, record("{\"a\":1}")));
  }
  const ResultStore again(deep);
  ASSERT_TRUE(again.load(kId));
  EXPECT_EQ(again.load(kId)->answer, "{\"a\":1}");
  EXPECT_EQ(again.load_answer(kId), "{\"a\":1}");
}

TEST(ResultStore, the_first_stays) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path());
  EXPECT_TRUE(store.save(kId, record("\"first\"")));
  EXPECT_FALSE(store.save(kId, record("\"second\"")));
  EXPECT_EQ(store.load_answer(kId), "\"first\"");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(ResultStore, many_threads_leave_one_whole_file) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path());
  std::atomic<int> firsts = 0;
  std::vector<std::thread> threads;
  for (int i = 0; i < 8; ++i)
    threads.emplace_back([&, i] { firsts += store.save(kId, record(std::to_string(i))); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(firsts, 1);
  EXPECT_EQ(folder.entries(), 1u);
  EXPECT_TRUE(store.load(kId));
}

TEST(ResultStore, asks_the_disk_for_ids_only) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path() / "store");
  write(folder.path() / "secret.record", encode(record()));
  for (const char* id : {"", "..", "../secret", "/etc/passwd", "../store/../secret"})
    EXPECT_FALSE(store.load(id)) << id;
}

TEST(ResultStore, sweeps_what_an_interrupted_server_left) {
  const test::TemporaryFolder folder;
  const std::string whole = encode(record());
  const auto name = [&](char c, const char* suffix) {
    return folder.path() / (std::string(64, c) + suffix);
  };
  write(name('a', ".record"), whole);
  write(name('b', ".record"), whole.substr(0, whole.size() / 2));
  write(name('c', ".record"), "");
  write(name('d', ".record.0123456789abcdef.tmp"), whole);
  write(folder.path() / "notes.txt", "somebody else's");
  const ResultStore store(folder.path());
  EXPECT_TRUE(fs::exists(name('a', ".record")));
  EXPECT_TRUE(fs::exists(folder.path() / "notes.txt"));
  EXPECT_EQ(folder.entries(), 2u);
}

TEST(ResultStore, a_damaged_record_is_none_and_gives_way) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path());
  std::string bytes = encode(record("\"old\""));
  bytes[bytes.size() / 2] ^= 1;
  write(folder.path() / (kId + ".record"), bytes);
  EXPECT_FALSE(store.load(kId));
  EXPECT_FALSE(store.load_answer(kId));
  EXPECT_TRUE(store.save(kId, record("\"new\"")));
  EXPECT_EQ(store.load_answer(kId), "\"new\"");
}

TEST(ResultStore, leaves_alone_what_another_server_is_writing) {
  const test::TemporaryFolder folder;
  const fs::path path = folder.path() / (kId + ".record.0123456789abcdef.tmp");
  const Descriptor writer(open(path.c_str(), O_WRONLY | O_CREAT, 0644));
  ASSERT_EQ(flock(writer.get(), LOCK_EX), 0);
  const ResultStore store(folder.path());
  EXPECT_TRUE(fs::exists(path));
}

std::string id_of(int i) { return sha256_hex(std::to_string(i)); }

TEST(ResultStore, what_was_not_asked_for_the_longest_makes_room) {
  const test::TemporaryFolder folder;
  const std::uint64_t size = encode(record("0")).size();
  const ResultStore store(folder.path(), 10 * size);
  const auto age = [&](int i, int seconds) {
    fs::last_write_time(folder.path() / (id_of(i) + ".record"),
                        fs::file_time_type::clock::now() - std::chrono::seconds(seconds));
  };
  for (int i = 0; i < 10; ++i) {
    store.save(id_of(i), record(std::to_string(i)));
    age(i, 100 - i);
  }
  EXPECT_EQ(store.bytes(), 10 * size);
  EXPECT_EQ(folder.entries(), 10u);
  EXPECT_TRUE(store.load_answer(id_of(0)));  // asked for, so others go first
  store.save(id_of(10), record("X"));
  EXPECT_EQ(folder.entries(), 9u);
  EXPECT_LE(store.bytes(), 9 * size);
  for (int i : {0, 3, 9, 10}) EXPECT_TRUE(store.load_answer(id_of(i))) << i;
  for (int i : {1, 2}) EXPECT_FALSE(store.load_answer(id_of(i))) << i;
  EXPECT_TRUE(store.save(id_of(1), record("1")));  // evicted is not forbidden
  const ResultStore smaller(folder.path(), 4 * size);
  EXPECT_LE(folder.entries(), 4u);
  for (int i = 0; i < 11; ++i)  // what another server evicted is gone from memory too
    EXPECT_EQ(store.find_answer(id_of(i)) != nullptr,
              fs::exists(folder.path() / (id_of(i) + ".record")));
}

TEST(ResultStore, knows_whether_it_can_be_written) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path() / "s");
  EXPECT_TRUE(store.writable());
  EXPECT_TRUE(fs::is_empty(folder.path() / "s"));
  fs::remove(folder.path() / "s");
  EXPECT_FALSE(store.writable());
}

TEST(AnswerCache, keeps_what_was_asked_for_lately) {
  AnswerCache cache(1000);
  const auto answer = [](std::size_t size) {
    return std::make_shared<const std::string>(size, 'x');
  };
  for (int i = 0; i < 10; ++i) cache.add(id_of(i), answer(100));
  EXPECT_TRUE(cache.find(id_of(0)));
  cache.add(id_of(10), answer(100));
  EXPECT_TRUE(cache.find(id_of(0)));
  EXPECT_FALSE(cache.find(id_of(1)));
  cache.add(id_of(11), answer(500));  // one must not push out all others
  EXPECT_FALSE(cache.find(id_of(11)));
  cache.remove(id_of(0));
  EXPECT_FALSE(cache.find(id_of(0)));
}

TEST(ResultStore, a_full_disk_is_a_problem_and_leaves_nothing) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path());
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before;
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 1000;
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  int status = 0;
  try {
    store.save(kId, record());
  } catch (const ProblemError& error) {
    status = error.problem().status;
  }
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_EQ(status, 507);
  EXPECT_EQ(folder.entries(), 0u);
  EXPECT_TRUE(store.save(kId, record()));
}

TEST(ResultStore, a_folder_that_went_away_is_a_problem) {
  const test::TemporaryFolder folder;
  const ResultStore store(folder.path() / "gone");
  fs::remove(folder.path() / "gone");
  EXPECT_THROW(store.save(kId, record()), ProblemError);
}

}  // namespace
}  // namespace caustic::service
