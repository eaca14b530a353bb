#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/image/picture.hpp"
#include "tests/farm/process.hpp"

/// A farm of real processes on loopback for one test.
namespace tessera::farm_test {

/// What is not as it usually is.
struct FarmSettings {
  std::filesystem::path data;           ///< else a folder of the farm's own
  std::vector<std::string> run_server;  ///< stands before the coordinator's command line
  std::vector<std::string> flags;       ///< more of the coordinator's
};

class Farm {
 public:
  /// Starts a coordinator on ports that the system picks, over a data folder of its own.
  explicit Farm(FarmSettings settings = {});

  /// Starts a worker; several are told apart by their number, from 0. `flags`: more of its command
  /// line.
  Process& add_worker(int threads = 1, const std::string& server = {},
                      std::vector<std::string> flags = {});
  [[nodiscard]] std::vector<Process>& workers() { return workers_; }
  [[nodiscard]] Process& server() { return server_; }

  /// SIGKILL, and a new coordinator over the same data folder and ports.
  void kill_and_restart_server();
  /// The second half of it; until it answers.
  void start_killed_server();
  /// The same, but the new one is killed too, so soon after its start.
  void kill_server_and_its_successor_after(Seconds wait);
  /// SIGKILL, and a new worker of the same name and cache.
  void kill_and_restart_worker(std::size_t number);

  /// The client with `arguments`, against this farm.
  Outcome tessera(std::vector<std::string> arguments, Seconds most = Seconds(120)) const;
  /// Submits and returns the job's id; a failure is a test failure and gives an empty string.
  std::string submit(const std::string& scene, std::vector<std::string> arguments);
  /// The HTTP job object.
  [[nodiscard]] nlohmann::json job(const std::string& id) const;
  /// What HTTP answers to GET; discarded or null where that is no JSON.
  [[nodiscard]] nlohmann::json get(const std::string& route) const;
  /// The same of POST and other methods with a body.
  [[nodiscard]] nlohmann::json send(const std::string& method, const std::string& route,
                                    const nlohmann::json& body) const;
  /// A number of /metrics, of a family without labels; negative if it is not there.
  [[nodiscard]] double metric(const std::string& name) const;
  /// Until the job's progress is at least `progress` (0…1); false after `most`.
  [[nodiscard]] bool wait_for_progress(const std::string& id, double progress,
                                       Seconds most = Seconds(120)) const;
  /// Until just `count` workers are connected; false after `most`.
  [[nodiscard]] bool wait_for_workers(std::size_t count, Seconds most) const;
  /// Waits for the end and reads the picture, by the client; a failure is a test failure.
  image::ExrImage finish(const std::string& id, Seconds most = Seconds(240));

  /// One frame's picture of a job of several, as the client fetches it.
  [[nodiscard]] image::ExrImage fetch_frame(const std::string& id, int frame) const;

  /// As finish(), but over HTTP, without starting a program for it.
  [[nodiscard]] image::ExrImage finish_quickly(const std::string& id,
                                               Seconds most = Seconds(240)) const;

  [[nodiscard]] const std::string& http() const { return http_; }
  [[nodiscard]] const std::string& listen() const { return listen_; }
  [[nodiscard]] const TemporaryFolder& folder() const { return folder_; }
  /// All that the farm's processes wrote to standard error, for a failed test's message.
  [[nodiscard]] std::string logs() const;

 private:
  [[nodiscard]] std::string ask(const std::string& method, const std::string& route,
                                const std::string& body) const;
  void start_server();
  void await_server();
  [[nodiscard]] Process start_worker(std::size_t number) const;

  FarmSettings settings_;
  TemporaryFolder folder_;
  std::string http_ = "127.0.0.1:0", listen_ = "127.0.0.1:0";
  struct WorkerFlags {
    int threads = 1;
    std::string server;
    std::vector<std::string> more;
  };
  std::vector<WorkerFlags> worker_flags_;
  int starts_ = 0;
  Process server_;
  std::vector<Process> workers_;
};

}  // namespace tessera::farm_test
