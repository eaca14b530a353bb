#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "common/image/picture.hpp"
#include "tests/farm/process.hpp"

/// A farm of real processes on loopback for one test.
namespace tessera::farm_test {

class Farm {
 public:
  /// Starts a coordinator on ports that the system picks, over a data folder of its own.
  Farm();

  /// Starts a worker; several are told apart by their number, from 0.
  Process& add_worker(int threads = 1, const std::string& server = {});
  [[nodiscard]] std::vector<Process>& workers() { return workers_; }
  [[nodiscard]] Process& server() { return server_; }

  /// SIGKILL, and a new coordinator over the same data folder and ports.
  void kill_and_restart_server();

  /// The client with `arguments`, against this farm.
  Outcome tessera(std::vector<std::string> arguments, Seconds most = Seconds(120)) const;
  /// Submits and returns the job's id; a failure is a test failure and gives an empty string.
  std::string submit(const std::string& scene, std::vector<std::string> arguments);
  /// The HTTP job object.
  [[nodiscard]] nlohmann::json job(const std::string& id) const;
  /// What HTTP answers to GET; discarded or null where that is no JSON.
  [[nodiscard]] nlohmann::json get(const std::string& route) const;
  /// Until the job's progress is at least `progress` (0…1); false after `most`.
  [[nodiscard]] bool wait_for_progress(const std::string& id, double progress,
                                       Seconds most = Seconds(120)) const;
  /// Until just `count` workers are connected; false after `most`.
  [[nodiscard]] bool wait_for_workers(std::size_t count, Seconds most) const;
  /// Waits for the end and reads the picture; a failure is a test failure.
  image::ExrImage finish(const std::string& id, Seconds most = Seconds(240));

  [[nodiscard]] const std::string& http() const { return http_; }
  [[nodiscard]] const std::string& listen() const { return listen_; }
  [[nodiscard]] const TempFolder& folder() const { return folder_; }
  /// All that the farm's processes wrote to standard error, for a failed test's message.
  [[nodiscard]] std::string logs() const;

 private:
  void start_server(const std::string& http, const std::string& listen);

  TempFolder folder_;
  std::string http_, listen_;
  int starts_ = 0;
  Process server_;
  std::vector<Process> workers_;
};

}  // namespace tessera::farm_test
