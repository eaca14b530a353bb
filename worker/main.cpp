#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <boost/asio/co_spawn.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/signal_set.hpp>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <thread>

#include "common/base/build_info.hpp"
#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/base/names.hpp"
#include "common/base/open_files.hpp"
#include "common/net/address.hpp"
#include "worker/agent/agent.hpp"
#include "worker/agent/path_renderer.hpp"

namespace {

namespace asio = boost::asio;
using namespace tessera;

struct Options {
  std::string server = "127.0.0.1:8421";
  std::string token;
  std::string name;
  std::string cache;
  std::string log_level = "info";
  double cache_gib = 10;
  std::vector<std::string> asset_roots;
  int threads = 0;
};

std::string host_name() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 && is_plain_name(name) ? name : "worker";
}

std::filesystem::path default_cache() {
  if (const char* xdg = std::getenv("XDG_CACHE_HOME"); xdg != nullptr && *xdg != '\0')
    return std::filesystem::path(xdg) / "tessera";
  if (const char* home = std::getenv("HOME"); home != nullptr && *home != '\0')
    return std::filesystem::path(home) / ".cache" / "tessera";
  return std::filesystem::temp_directory_path() / "tessera-cache";
}

void add_options(CLI::App& app, Options& options) {
  app.description(
      "Renders tiles for a Tessera coordinator: connects, takes leases, fetches the scene, and "
      "sends results until it is told "
      "to leave. A coordinator that is not there yet is waited for.");
  app.footer(
      "SIGTERM or SIGINT: finishes what renders, delivers it, gives the rest back, and leaves; a "
      "second one leaves at once.\n"
      "Exit codes: 0 left as asked; 1 failed; 2 wrong usage; 4 refused; 130 interrupted twice.");
  app.set_version_flag("--version", std::string(version()));
  app.add_option("--server", options.server, "the coordinator's port for workers, HOST:PORT")
      ->capture_default_str();
  app.add_option("--threads", options.threads, "threads that render; 0: all")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  app.add_option("--name", options.name,
                 "for people, and what a quarantine goes by; the host's name unless given");
  app.add_option("--cache", options.cache,
                 "folder for scenes' files, which workers may share (default: ~/.cache/tessera)");
  app.add_option("--cache-size", options.cache_gib, "most that the cache keeps, GiB")
      ->check(CLI::Range(0.0, 1e6))
      ->capture_default_str();
  app.add_option("--asset-root", options.asset_roots,
                 "folder beneath which jobs may name files by path (tessera submit --by-path) "
                 "instead of uploading them; may be given several times. Nothing else is read")
      ->type_name("DIR")
      ->allow_extra_args(false);
  app.add_option(
         "--token", options.token,
         "what the coordinator wants shown; better in the environment, where others cannot see it")
      ->envname("TESSERA_TOKEN");
  app.add_option("--log-level", options.log_level, "debug, info, warn or error")
      ->capture_default_str();
}

void log_stats(const agent::CrewStats& stats) {
  const double mean = stats.gaps > 0 ? stats.gap_seconds / static_cast<double>(stats.gaps) : 0;
  log::info("{} tasks rendered; {} gaps between them, mean {:.3f} ms, longest {:.3f} ms",
            stats.tasks, stats.gaps, 1e3 * mean, 1e3 * stats.gap_most);
}

/// The first signal drains, a second one ends the program at once. Two that come together are one:
/// some tools signal both a process and its group.
void watch(asio::signal_set& signals, agent::Agent& worker,
           std::chrono::steady_clock::time_point first = {}) {
  signals.async_wait([&signals, &worker, first](const boost::system::error_code& error, int) {
    if (error) return;
    const auto now = std::chrono::steady_clock::now();
    const bool is_first = first == std::chrono::steady_clock::time_point{};
    if (is_first) worker.drain("asked by a signal");
    if (!is_first && now - first > std::chrono::milliseconds(200)) std::_Exit(130);
    watch(signals, worker, is_first ? now : first);
  });
}

int work(const Options& options) {
  constexpr std::size_t log_lines = 20;  // go with what it says of a failed task
  log::set_level(log::level_from(options.log_level));
  log::keep_recent(log_lines);
  const int all = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  agent::AgentSettings settings;
  settings.server = net::parse_address(options.server, net::default_worker_port);
  settings.token = options.token;
  settings.name = options.name.empty() ? host_name() : options.name;
  if (!is_plain_name(settings.name))
    throw Error(ErrorKind::bad_input, "--name: expected 1 to 128 bytes without control characters");
  settings.cache = options.cache.empty() ? default_cache() : std::filesystem::path(options.cache);
  for (const std::string& root : options.asset_roots) settings.fetch.asset_roots.emplace_back(root);
  raise_open_files_limit();  // a scene's files that are named by path stay open
  settings.fetch.cache_bytes = static_cast<std::uint64_t>(options.cache_gib * 1024 * 1024 * 1024);

  const auto renderer = agent::make_path_renderer(options.threads > 0 ? options.threads : all);
  asio::io_context io(1);
  agent::Agent worker(io, settings, *renderer);
  asio::signal_set signals(io, SIGTERM, SIGINT);
  watch(signals, worker);
  int code = 1;
  std::exception_ptr failure;
  asio::co_spawn(io, worker.run(), [&](std::exception_ptr error, int result) {
    failure = error;
    code = result;
    signals.cancel();
    io.stop();
  });
  io.run();
  if (failure) std::rethrow_exception(failure);
  log_stats(worker.stats());
  return code;
}

}  // namespace

int main(int count, char** arguments) {
  Options options;
  CLI::App app;
  add_options(app, options);
  try {
    app.parse(count, arguments);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  try {
    return work(options);
  } catch (const Error& error) {
    std::cerr << "tessera-worker: " << error.what() << '\n';
    return exit_code(error.kind());
  } catch (const std::exception& error) {
    std::cerr << "tessera-worker: " << error.what() << '\n';
    return 1;
  }
}
