#include <malloc.h>

#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <exception>
#include <iostream>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/log.hpp"
#include "common/base/open_files.hpp"
#include "server/options.hpp"
#include "server/server.hpp"

namespace {

namespace asio = boost::asio;
using namespace tessera;

constexpr int interrupted = 130;
constexpr std::chrono::seconds stop_time{15};

/// Every connection takes a descriptor: as many as the system lets us have.
void raise_file_limit() {
  constexpr std::uint64_t files = 512;  // the store's, and those that are being sent
  constexpr std::uint64_t all = limits::workers_max + limits::http_connections_max + files;
  const std::uint64_t limit = raise_open_files_limit();
  if (limit >= all) return;
  log::warn(
      "at most {} files may be open, which is the most connections too: {} would do for {} "
      "workers; raise the hard limit (ulimit -Hn, LimitNOFILE=)",
      limit, all, limits::workers_max);
}

/// A result of 64×64 pixels is some blocks of 200 KiB to 450 KiB, which the C library would fetch
/// from the system and give back each time: a page fault for every 4 KiB of every result, more than
/// the decoding costs. From here on the heap keeps such blocks, and up to `spare` of what is free.
void keep_result_memory() {
  constexpr int result_block = 4 << 20, spare = 128 << 20;
  mallopt(M_MMAP_THRESHOLD, result_block);
  mallopt(M_TRIM_THRESHOLD, spare);
}

/// Waits for the first signal, then stops the server. Gives the signal. A second signal, or a stop
/// that hangs, ends the process at once: the store survives that, as it survives a power cut.
asio::awaitable<int> run_until_signal(server::Server& server, asio::signal_set& signals,
                                      asio::steady_timer& patience) {
  const int signal = co_await signals.async_wait(asio::use_awaitable);
  log::info("stopping");
  signals.async_wait([](const boost::system::error_code& error, int) {
    if (!error) std::_Exit(interrupted);
  });
  patience.expires_after(stop_time);
  patience.async_wait([](const boost::system::error_code& error) {
    if (error) return;
    log::error("stopping took too long");
    std::_Exit(1);
  });
  co_await server.stop();
  signals.cancel();
  patience.cancel();
  co_return signal;
}

int serve(const server::Options& options) {
  log::set_level(options.log_level);
  raise_file_limit();
  keep_result_memory();
  std::signal(SIGPIPE, SIG_IGN);
  asio::io_context context(1);
  asio::signal_set signals(context, SIGINT, SIGTERM);
  asio::steady_timer patience(context);
  server::Server server(context, options.server);
  std::cout << server.ready_line() << std::endl;
  int signal = 0;
  std::exception_ptr failure;
  asio::co_spawn(context, run_until_signal(server, signals, patience),
                 [&](std::exception_ptr error, int value) {
                   failure = error;
                   signal = value;
                   context.stop();
                 });
  context.run();
  if (failure) std::rethrow_exception(failure);
  log::info("stopped");
  return signal == SIGINT ? interrupted : 0;
}

}  // namespace

int main(int argc, char** argv) {
  const server::ParsedOptions parsed = server::parse_options(argc, argv);
  if (!parsed.options) return parsed.exit_code;
  try {
    return serve(*parsed.options);
  } catch (const Error& error) {
    std::cerr << "tessera-server: " << error.what() << "\n";
    return exit_code(error.kind());
  } catch (const std::exception& error) {
    std::cerr << "tessera-server: " << error.what() << "\n";
    return 1;
  }
}
