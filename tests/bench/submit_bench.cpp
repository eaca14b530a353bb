// What a large scene costs to submit, the first time and the second: bytes that go over, seconds,
// and the most memory that client and coordinator hold; and how often a worker builds it.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "tests/bench/print.hpp"
#include "tests/farm/farm.hpp"
#include "tests/farm/large_scene.hpp"

namespace tessera::farm_test {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double megabyte = 1e6;

struct Submission {
  double seconds = 0, megabytes = 0;
  double client_memory = 0;  ///< the most, MiB
  std::string job;
};

Submission submit(const Farm& farm, const LargeScene& scene,
                  const std::vector<std::string>& more = {}) {
  const auto received = [&] { return farm.metric("tessera_blob_bytes_received_total") / megabyte; };
  std::vector<std::string> command{(programs() / "tessera").string(), "--server",
                                   "http://" + farm.http(), "submit", scene.file()};
  command.insert(command.end(), more.begin(), more.end());
  Submission out;
  const double before = received();
  const TemporaryFolder log;
  const auto began = Clock::now();
  Process client(std::move(command), log / "submit");
  while (client.running()) {
    out.client_memory = std::max(out.client_memory, client.peak_memory());
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  out.seconds = std::chrono::duration<double>(Clock::now() - began).count();
  if (client.wait(Seconds(0)) != 0)
    std::printf("a submission failed: %s\n", client.errors().c_str());
  out.megabytes = received() - before;
  out.job = client.output().substr(0, client.output().find('\n'));
  return out;
}

void print_submission(const std::string& which, const Submission& submission,
                      const std::string& bytes_aim) {
  print(which + ", bytes sent", submission.megabytes, "MB", bytes_aim);
  print(which + ", time", submission.seconds, "s", "");
  print(which + ", the client's peak memory", submission.client_memory, "MiB", "");
}

void measure(int pictures) {
  Farm farm;
  const LargeScene scene(farm.folder().path(), {.pictures = pictures, .side = 2048});
  print("the scene", static_cast<double>(scene.bytes()) / megabyte, "MB", "");
  print_submission("first submission", submit(farm, scene), "the scene's, and a list");
  print_submission("second submission", submit(farm, scene), "0");
  print_submission("by path", submit(farm, scene, {"--by-path"}), "a list");
  print("the coordinator's peak memory", farm.server().peak_memory(), "MiB", "");
}

/// A job of many tasks.
void builds() {
  Farm farm;
  Process& worker = farm.add_worker(2);
  const LargeScene scene(farm.folder().path(), {.pictures = 2, .side = 256});
  const Submission job =
      submit(farm, scene, {"--size", "256x256", "--tile", "16", "--samples", "64"});
  farm.finish(job.job);
  const std::string log = worker.errors();
  double count = 0;
  for (std::size_t at = log.find("scene built"); at != std::string::npos;
       at = log.find("scene built", at + 1))
    ++count;
  print("tasks of a job", farm.job(job.job).at("tasks").get<double>(), "", "");
  print("times that its worker built the scene", count, "", "1");
}

}  // namespace
}  // namespace tessera::farm_test

/// bench_submit [--quick]: a scene of 2 GB; with --quick one of 300 MB, to see that it runs.
int main(int count, char** arguments) {
  const bool quick = count > 1 && std::strcmp(arguments[1], "--quick") == 0;
  tessera::farm_test::measure(quick ? 25 : 160);
  tessera::farm_test::builds();
  return 0;
}
