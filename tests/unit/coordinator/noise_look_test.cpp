#include "server/coordinator/noise_look.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <boost/asio/io_context.hpp>
#include <new>
#include <thread>

#include "server/coordinator/job_table.hpp"

namespace tessera::server {
namespace {

/// Looks at films of nothing: what they measure is the test's.
class NoiseLooksTest : public testing::Test {
 protected:
  NoiseLooksTest() {
    JobSpec spec;
    spec.name = "film";
    spec.render.width = spec.render.height = 8;
    spec.bundle = digest_of("scene");
    spec.frames = {1, 8, 1};
    for (int frame = 1; frame <= 8; ++frame)
      films.open(1, std::make_shared<const JobPlan>(spec), frame, 0);
  }
  ~NoiseLooksTest() override { pool.join(); }

  NoiseLook look_of(std::int32_t frame, std::uint64_t bytes = 40) {
    NoiseLook look;
    look.job = 1;
    look.frame = frame;
    look.bytes = bytes;
    look.wanted = [this] { return wanted; };
    look.tell = [this](double noise) { told.push_back(noise); };
    return look;
  }
  void run_until(const std::function<bool()>& enough) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
    while (!enough() && std::chrono::steady_clock::now() < end)
      io.run_one_for(std::chrono::milliseconds(10));
    EXPECT_TRUE(enough());
  }
  void run_all() {
    io.run_for(std::chrono::seconds(20));
    EXPECT_TRUE(io.stopped()) << "something goes on";
  }

  boost::asio::io_context io{1};
  boost::asio::thread_pool pool{4};
  Crew crew{io.get_executor()};
  Signal changed{io.get_executor()};
  WholeFilms whole{100, changed};
  Films films{io.get_executor(), pool, 1, crew, 1000, {}, {}};
  bool wanted = true;
  std::vector<double> told;
};

TEST_F(NoiseLooksTest, AreTriedAgainWhateverTheyFailBy) {
  std::atomic<int> tries = 0;
  NoiseLooks looks(films, whole, changed, crew, pool, [&](const FilmSnapshot&) {
    if (++tries < 3) throw std::bad_alloc();
    return 0.25;
  });
  crew.start("a look", looks.look(look_of(1)));
  run_all();
  EXPECT_EQ(told, std::vector<double>{0.25});
  EXPECT_EQ(tries, 3);
}

TEST_F(NoiseLooksTest, EndOnceNobodyWaitsForThem) {
  std::atomic<int> tries = 0;
  NoiseLooks looks(films, whole, changed, crew, pool, [&](const FilmSnapshot&) -> double {
    ++tries;
    throw std::bad_alloc();
  });
  crew.start("a look", looks.look(look_of(1)));
  run_until([&] { return tries > 1; });
  wanted = false;
  run_all();
  EXPECT_TRUE(told.empty());
}

TEST_F(NoiseLooksTest, EndOnceTheirJobGoesOnWithoutAThresholdThoughItsPlanIsTheSame) {
  JobRecord record;
  record.spec = films.find(1, 1)->plan().spec;
  record.spec.noise_threshold = 0.1;
  Job job(record, Instant(), 0);
  std::atomic<int> tries = 0;
  NoiseLooks looks(films, whole, changed, crew, pool, [&](const FilmSnapshot&) -> double {
    ++tries;
    throw std::bad_alloc();
  });
  NoiseLook look = look_of(1);
  look.wanted = [&job, plan = job.plan->digest] { return job.awaits_noise(plan); };
  crew.start("a look", looks.look(std::move(look)));
  run_until([&] { return tries > 1; });
  job.record.spec.noise_threshold = 0;
  job.spec_changed();
  run_all();
  EXPECT_TRUE(told.empty());
}

TEST_F(NoiseLooksTest, ThatNobodyWaitsForEndWhileTheyWaitForMemory) {
  const WholeFilms::Share others = whole.take(100);
  std::atomic<int> tries = 0;
  NoiseLooks looks(films, whole, changed, crew, pool, [&](const FilmSnapshot&) {
    ++tries;
    return 0.5;
  });
  crew.start("a look", looks.look(look_of(1)));
  io.poll();
  wanted = false;
  changed.notify();
  run_all();
  EXPECT_EQ(tries, 0);
  EXPECT_EQ(whole.used(), 100U);
}

TEST_F(NoiseLooksTest, AreNotToldIfNobodyWaitsForThemAnyMore) {
  std::atomic<bool> measuring = false, go_on = false;
  NoiseLooks looks(films, whole, changed, crew, pool, [&](const FilmSnapshot&) {
    measuring = true;
    while (!go_on) std::this_thread::yield();
    return 0.5;
  });
  crew.start("a look", looks.look(look_of(1)));
  run_until([&] { return measuring.load(); });
  wanted = false;
  go_on = true;
  run_all();
  EXPECT_TRUE(told.empty());
  EXPECT_EQ(whole.used(), 0U);
}

TEST_F(NoiseLooksTest, AreAtAsManyFilmsAsThereIsMemoryFor) {
  std::atomic<int> here = 0, most = 0;
  NoiseLooks looks(films, whole, changed, crew, pool, [&](const FilmSnapshot&) {
    const int now = ++here;
    for (int seen = most; seen < now && !most.compare_exchange_weak(seen, now);) continue;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    --here;
    return 0.5;
  });
  for (int frame = 1; frame <= 8; ++frame) crew.start("a look", looks.look(look_of(frame)));
  run_until([&] { return told.size() == 8; });
  EXPECT_EQ(most, 2) << "two of 40 bytes fit into 100";
  EXPECT_EQ(whole.used(), 0U);
}

}  // namespace
}  // namespace tessera::server
