#pragma once
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "client/child.hpp"
#include "client/interrupt.hpp"
#include "client/progress.hpp"
#include "client/scratch_folder.hpp"

namespace tessera::client {

/// A coordinator and workers on this machine, for as long as this lives: on loopback, on ports that
/// nobody else has, with data in a temporary folder. Nothing is left when it goes.
class Farm {
 public:
  /// Starts the programs that lie beside this one, and waits for the coordinator. Throws
  /// Error{failed} that says which did not come up and what it said.
  Farm(int workers, int threads);
  ~Farm();
  Farm(const Farm&) = delete;
  Farm& operator=(const Farm&) = delete;

  /// The coordinator's HTTP port.
  [[nodiscard]] const std::string& url() const { return url_; }
  /// To be called now and then. A worker that has ended is started again, a few times, and
  /// `printer` says so. Throws Error{failed}, with what it said last, once the coordinator has
  /// ended or no worker is left.
  void check(ProgressPrinter& printer);

 private:
  /// A worker's place, whoever sits in it.
  struct Seat {
    std::function<std::unique_ptr<Child>()> start;
    std::unique_ptr<Child> child;
    int restarts = 0;
    bool given_up = false;
  };

  NotedInterrupts noted_;
  ScratchFolder folder_;
  std::string url_;
  std::unique_ptr<Child> server_;
  std::vector<Seat> seats_;
};

/// Where the coordinator says that it listens.
struct ServerAddresses {
  std::string http;    ///< host:port
  std::string listen;  ///< host:port, for workers
};
/// From the line that it prints, {"http": …, "listen": …}; more keys may stand in it. Throws
/// Error{failed}.
ServerAddresses addresses_from(std::string_view line);

/// Threads of each of so many workers: as many as were asked for, or (0) the machine's, divided.
int threads_of_each(int asked, int workers);

/// Processors that this process may use, at least 1.
int processors();

}  // namespace tessera::client
