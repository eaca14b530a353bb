#pragma once
#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.hpp"

/// Real processes for tests: started, signalled, waited for; never left behind.
namespace tessera::farm_test {

using Seconds = std::chrono::duration<double>;

/// A child process whose output goes to files. Destroyed, it is killed and waited for.
class Process {
 public:
  /// `arguments[0]` is the program; output and errors are appended to files `log`.out and
  /// `log`.err.
  Process(std::vector<std::string> arguments, const std::filesystem::path& log);
  ~Process();
  Process(Process&& other) noexcept;
  Process& operator=(Process&& other) noexcept;
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void signal(int number) const;
  /// Its exit code, 128 + the signal that ended it, or nullopt if it still runs after `most`.
  std::optional<int> wait(Seconds most);
  /// SIGKILL, and waits.
  void kill();
  [[nodiscard]] bool running();
  [[nodiscard]] std::string output() const;
  [[nodiscard]] std::string errors() const;
  [[nodiscard]] pid_t pid() const { return pid_; }
  /// The most memory that it has held at once since it started, or since forget_peak_memory(),
  /// MiB.
  [[nodiscard]] double peak_memory() const;
  void forget_peak_memory() const;

 private:
  pid_t pid_ = -1;
  std::optional<int> code_;
  std::filesystem::path log_;
};

/// What a command that ended left.
struct Outcome {
  int code = -1;
  std::string output;
  std::string errors;
};
/// Runs to its end; after `most` it is killed and the code is 137.
Outcome run(std::vector<std::string> arguments, Seconds most = Seconds(60));

/// Asks again and again, with a pause between, until it holds; false if it does not within `most`.
bool becomes_true(const std::function<bool()>& holds, Seconds most = Seconds(60),
                  std::chrono::milliseconds pause = std::chrono::milliseconds(10));

std::string read_text(const std::filesystem::path& file);
/// Where the programs under test are: TESSERA_BIN_DIR.
std::filesystem::path programs();
/// The checkout: TESSERA_SOURCE_DIR.
std::filesystem::path sources();

}  // namespace tessera::farm_test
