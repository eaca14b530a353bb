// What the client promises to people and to scripts: exit codes, clean output, nothing left behind.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <thread>

#include "common/base/digest.hpp"
#include "tests/farm/farm.hpp"
#include "tests/farm/scripted_worker.hpp"

namespace tessera::farm_test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string cornell() { return (sources() / "scenes/cornell.json").string(); }

/// `tessera render` with all its temporary files below `folder`.
std::vector<std::string> render_in(const TemporaryFolder& folder,
                                   std::vector<std::string> arguments) {
  std::vector<std::string> all{"/usr/bin/env", "TMPDIR=" + folder.path().string(),
                               (programs() / "tessera").string(), "render", cornell()};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return all;
}

/// How many processes have `text` in their command line.
int processes_with(const std::string& text) {
  int count = 0;
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    if (read_text(entry.path() / "cmdline").find(text) != std::string::npos) ++count;
  }
  return count;
}

/// A process whose command line has both texts; 0 if there is none.
pid_t process_with(const std::string& one, const std::string& other) {
  for (const auto& entry : fs::directory_iterator("/proc")) {
    const std::string name = entry.path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    const std::string line = read_text(entry.path() / "cmdline");
    if (line.find(one) != std::string::npos && line.find(other) != std::string::npos)
      return std::stoi(name);
  }
  return 0;
}

TEST(Client, render_interrupted_ends_soon_and_leaves_nothing) {
  const TemporaryFolder temporary, logs;
  const std::string mark = (temporary.path() / "tessera-render-").string();
  const fs::path picture = logs / "picture.exr";
  Process client(render_in(temporary, {"--samples", "1000000", "--threads", "1", "--workers", "2",
                                       "-o", picture.string()}),
                 logs / "render");
  // A coordinator and two workers, at work.
  ASSERT_TRUE(becomes_true(
      [&] {
        return processes_with(mark) == 3 && client.errors().find("rendering") != std::string::npos;
      },
      Seconds(20)))
      << client.errors();
  client.signal(SIGINT);
  EXPECT_EQ(client.wait(Seconds(5)), 130) << client.errors();
  EXPECT_EQ(processes_with(mark), 0);
  EXPECT_TRUE(fs::is_empty(temporary.path()));
  EXPECT_FALSE(fs::exists(picture));
  EXPECT_NE(client.errors().find("interrupted"), std::string::npos);
}

TEST(Client, render_goes_on_when_a_worker_dies_and_gives_up_when_none_is_left) {
  const TemporaryFolder temporary, logs;
  const std::string mark = (temporary.path() / "tessera-render-").string();
  Process client(render_in(temporary, {"--samples", "1000000", "--threads", "1", "--workers", "1",
                                       "-o", (logs / "picture.exr").string()}),
                 logs / "render");
  // The worker is killed whenever it is there; the client starts it again three times.
  pid_t last = 0;
  const bool ended = becomes_true(
      [&] {
        const pid_t worker = process_with("tessera-worker", mark);
        if (worker != 0 && worker != last) {
          kill(worker, SIGKILL);
          last = worker;
        }
        return !client.running();
      },
      Seconds(60));
  ASSERT_TRUE(ended) << client.errors();
  EXPECT_EQ(client.wait(Seconds(1)), 1);
  const std::string said = client.errors();
  std::size_t restarts = 0;
  for (std::size_t at = said.find("it is started again"); at != std::string::npos;
       at = said.find("it is started again", at + 1))
    ++restarts;
  EXPECT_EQ(restarts, 3U) << said;
  EXPECT_NE(said.find("no worker is left"), std::string::npos) << said;
  EXPECT_TRUE(fs::is_empty(temporary.path()));
}

TEST(Client, render_with_a_worker_killed_once_still_makes_the_picture) {
  const TemporaryFolder temporary, logs;
  const std::string mark = (temporary.path() / "tessera-render-").string();
  const fs::path picture = logs / "picture.exr";
  Process client(render_in(temporary, {"--size", "64x64", "--samples", "2000", "--threads", "1",
                                       "--workers", "2", "-o", picture.string()}),
                 logs / "render");
  ASSERT_TRUE(becomes_true([&] { return client.errors().find("rendering") != std::string::npos; },
                           Seconds(60)))
      << client.errors();
  const pid_t worker = process_with("tessera-worker", mark);
  ASSERT_NE(worker, 0) << client.errors();
  kill(worker, SIGKILL);
  EXPECT_EQ(client.wait(Seconds(300)), 0) << client.errors();
  EXPECT_NE(client.errors().find("was killed by signal 9"), std::string::npos) << client.errors();
  EXPECT_TRUE(fs::exists(picture));
}

TEST(Client, what_a_killed_render_left_is_cleared_away_by_the_next) {
  const TemporaryFolder temporary, logs;
  const std::string mark = (temporary.path() / "tessera-render-").string();
  Process killed(render_in(temporary, {"--samples", "1000000", "--threads", "1", "-o",
                                       (logs / "killed.exr").string()}),
                 logs / "killed");
  ASSERT_TRUE(becomes_true([&] { return processes_with(mark) == 2; }, Seconds(60)));
  killed.kill();
  ASSERT_TRUE(becomes_true([&] { return processes_with(mark) == 0; }, Seconds(20)))
      << "the kernel ends what it started";
  EXPECT_FALSE(fs::is_empty(temporary.path()));
  const Outcome next = run(render_in(temporary, {"--size", "16x16", "--samples", "1", "--threads",
                                                 "1", "-o", (logs / "next.exr").string()}));
  EXPECT_EQ(next.code, 0) << next.errors;
  EXPECT_TRUE(fs::is_empty(temporary.path()));
}

TEST(Client, render_answers_with_one_object_and_its_progress_is_plain_lines) {
  const TemporaryFolder temporary;
  const fs::path picture = temporary / "picture.exr";
  const Outcome outcome =
      run(render_in(temporary, {"--size", "32x24", "--samples", "5", "--threads", "1", "--json",
                                "-o", picture.string()}));
  ASSERT_EQ(outcome.code, 0) << outcome.errors;
  const json report = json::parse(outcome.output, nullptr, false);
  ASSERT_TRUE(report.is_object()) << outcome.output;
  EXPECT_EQ(report.at("output"), picture.string());
  EXPECT_EQ(report.at("samples"), 5);
  EXPECT_EQ(report.at("workers"), 1);
  EXPECT_EQ(report.at("threads"), 1);
  EXPECT_GE(report.at("rays").get<double>(), 32 * 24 * 5);
  EXPECT_GT(report.at("render_seconds").get<double>(), 0);
  EXPECT_GE(report.at("seconds").get<double>(), report.at("render_seconds").get<double>());
  EXPECT_EQ(outcome.output.find('\n'), outcome.output.size() - 1);
  EXPECT_NE(outcome.errors.find("done"), std::string::npos) << outcome.errors;
  EXPECT_EQ(outcome.errors.find_first_of("\r\x1b"), std::string::npos) << outcome.errors;
  EXPECT_EQ(image::read_exr_file(picture).width, 32);
  // The picture alone is left.
  EXPECT_EQ(std::distance(fs::directory_iterator(temporary.path()), fs::directory_iterator()), 1);
}

TEST(Client, wait_for_a_cancelled_job_fails_and_says_why) {
  Farm farm;  // without workers, so that the job stays
  const std::string id = farm.submit(cornell(), {});
  Process waiting(
      {(programs() / "tessera").string(), "--server", "http://" + farm.http(), "wait", id},
      farm.folder() / "wait");
  EXPECT_EQ(waiting.wait(Seconds(0.3)), std::nullopt);
  EXPECT_EQ(farm.tessera({"cancel", id}).code, 0);
  EXPECT_EQ(waiting.wait(Seconds(5)), 1);
  EXPECT_NE(waiting.errors().find("job " + id + " was cancelled"), std::string::npos)
      << waiting.errors();
  EXPECT_EQ(farm.tessera({"wait", id}).code, 1);
}

TEST(Client, fetch_of_an_unknown_job_fails_with_a_sentence_and_makes_no_file) {
  const Farm farm;
  const fs::path picture = farm.folder() / "none.exr";
  const Outcome outcome = farm.tessera({"fetch", "77", "-o", picture.string()});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.output, "");
  EXPECT_TRUE(outcome.errors.starts_with("tessera: ")) << outcome.errors;
  EXPECT_NE(outcome.errors.find("77"), std::string::npos) << outcome.errors;
  EXPECT_EQ(outcome.errors.find('\n'), outcome.errors.size() - 1) << outcome.errors;
  EXPECT_FALSE(fs::exists(picture));
}

TEST(Client, jobs_and_workers_answer_in_json_when_asked) {
  Farm farm;
  farm.add_worker();
  const std::string id = farm.submit(cornell(), {"--size", "16x16", "--samples", "1"});
  ASSERT_TRUE(
      becomes_true([&] { return farm.get("/v1/workers").at("workers").size() == 1; }, Seconds(10)));
  const json jobs = json::parse(farm.tessera({"--json", "jobs"}).output, nullptr, false);
  ASSERT_TRUE(jobs.is_object());
  ASSERT_EQ(jobs.at("jobs").size(), 1U);
  EXPECT_EQ(jobs.at("jobs")[0].at("id").dump(), id);
  const json workers = json::parse(farm.tessera({"workers", "--json"}).output, nullptr, false);
  ASSERT_TRUE(workers.is_object());
  ASSERT_EQ(workers.at("workers").size(), 1U);
  EXPECT_EQ(workers.at("workers")[0].at("name"), "worker-0");
}

TEST(Client, a_scene_that_the_server_has_is_not_sent_again) {
  Farm farm;
  const std::string first = farm.submit(cornell(), {});
  constexpr std::size_t digest_tail = 62;  // of 64 digits; two name the folder
  // A blob that is sent again is another file under the same name.
  const auto blobs = [&] {
    std::map<std::string, ino_t> out;
    for (const auto& entry : fs::recursive_directory_iterator(farm.folder() / "data" / "blobs")) {
      struct stat status {};
      if (entry.path().filename().string().size() == digest_tail && entry.is_regular_file() &&
          ::stat(entry.path().c_str(), &status) == 0)
        out[entry.path().string()] = status.st_ino;
    }
    return out;
  };
  const auto before = blobs();
  EXPECT_GE(before.size(), 2U);  // the scene, and the list of its files

  const std::string digest = digest_of_file(cornell()).hex();
  const std::string question = R"({"digests": [")" + digest + R"("]})";
  const Line line(farm.http());
  line.send("POST /v1/blobs/missing HTTP/1.1\r\nHost: " + farm.http() +
            "\r\nContent-Type: application/json\r\nConnection: close\r\nContent-Length: " +
            std::to_string(question.size()) + "\r\n\r\n" + question);
  const std::string answer = line.receive_all(Seconds(10));
  EXPECT_NE(answer.find(R"("missing":[])"), std::string::npos) << answer;

  const std::string second = farm.submit(cornell(), {});
  EXPECT_NE(first, second);
  EXPECT_EQ(blobs(), before);
}

}  // namespace
}  // namespace tessera::farm_test
