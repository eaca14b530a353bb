#pragma once
#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "common/base/clock.hpp"

namespace tessera::client {

/// A program that this one started, and that does not outlive it: it is killed when this object
/// goes, and by the kernel if this program dies. It has a process group of its own, so that Ctrl-C
/// on the terminal reaches this program alone, which then ends its children in order. Variables
/// TESSERA_… are not handed on. Standard error goes to `log`.
class Child {
 public:
  /// Throws Error{failed} if it cannot be started.
  Child(std::string name, const std::filesystem::path& program, std::vector<std::string> arguments,
        std::filesystem::path log);
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Whether it still runs; does not wait.
  [[nodiscard]] bool running();
  /// How it ended, and the last lines of what it said.
  [[nodiscard]] std::string epitaph() const;
  /// The first line of its standard output; nothing if it ended, or `time` passed, without one.
  std::optional<std::string> first_line(Duration time);
  /// Asks it to end (SIGTERM).
  void ask_to_end();
  /// Waits until it ended, at most so long; kills it then.
  void end_within(Duration time);

 private:
  std::string name_;
  std::filesystem::path log_;
  pid_t pid_ = -1;
  int output_ = -1;
  bool running_ = false;
  int status_ = 0;
};

}  // namespace tessera::client
