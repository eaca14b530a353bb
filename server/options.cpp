#include "server/options.hpp"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <cstdlib>
#include <fstream>
#include <iostream>

#include "common/base/build_info.hpp"
#include "common/base/error.hpp"
#include "server/quantities.hpp"

namespace tessera::server {

namespace {

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? std::string() : std::string(value);
}

std::string token_from_file(const std::string& name) {
  std::ifstream file(name);
  std::string token;
  if (!file || !(file >> token))
    throw Error(ErrorKind::bad_input, "expected a file that holds the token", {.file = name});
  return token;
}

net::Address address_from(const std::string& text, std::uint16_t default_port) {
  net::Address address = net::parse_address(text, default_port);
  if (address.host == "localhost") address.host = "127.0.0.1";
  return address;
}

/// The flags as they stand on the command line.
struct Flags {
  std::string data, http, listen, token, token_file, public_url;
  std::string log_level = "info";
  std::string film_memory, keep_jobs = "forever", disk_limit, cache_size;
  bool insecure = false, no_durable = false;
  int pool_threads = ServerSettings().pool_threads;
  int preparation_timeout = ServerSettings().preparation_timeout;
};

void declare(CLI::App& app, Flags& flags) {
  app.set_version_flag("--version",
                       fmt::format("tessera-server {} ({})", version(), build_commit()));
  app.add_option(
         "--data", flags.data,
         "Folder that keeps jobs, results and scenes [" + default_data_folder().string() + "]")
      ->type_name("DIR");
  app.add_option("--http", flags.http,
                 "Address for people, scripts and the page [127.0.0.1:8420]; port 0 picks one")
      ->type_name("HOST:PORT");
  app.add_option("--listen", flags.listen, "Address for workers [127.0.0.1:8421]; port 0 picks one")
      ->type_name("HOST:PORT");
  auto* token = app.add_option("--token", flags.token,
                               "All requests and workers must show it; also TESSERA_TOKEN")
                    ->type_name("TOKEN");
  app.add_option("--token-file", flags.token_file, "File that holds the token")
      ->type_name("FILE")
      ->excludes(token);
  app.add_flag("--insecure", flags.insecure,
               "Listen for other machines although nothing is encrypted");
  app.add_option("--public-url", flags.public_url,
                 "How workers and browsers reach the HTTP port, where not by its address")
      ->type_name("URL");
  app.add_option("--log-level", flags.log_level, "debug, info, warn or error [info]")
      ->type_name("LEVEL");
  app.add_option("--pool-threads", flags.pool_threads, "Threads that decode, encode and sync [2]")
      ->type_name("N");
  app.add_option("--preparation-timeout", flags.preparation_timeout,
                 "A worker whose preparation of a scene has not got on for so many seconds is not "
                 "waited for [1800]")
      ->type_name("SECONDS");
  app.add_option("--film-memory", flags.film_memory,
                 "Memory for the films of unfinished frames, the rest is on disk, such as 8G [half "
                 "of the machine's]")
      ->type_name("SIZE");
  app.add_option("--keep-jobs", flags.keep_jobs,
                 "How long jobs that have ended are kept, with their pictures, such as 30d "
                 "[forever]")
      ->type_name("TIME");
  app.add_option("--disk-limit", flags.disk_limit,
                 "Bytes of the data folder beyond which new jobs and uploads are refused, such as "
                 "500G [what the file system has]")
      ->type_name("SIZE");
  app.add_option("--cache-size", flags.cache_size,
                 "Bytes of scenes' files kept that no job needs any more, so that they need not be "
                 "sent again; the least recently used go [10G]")
      ->type_name("SIZE");
  app.add_flag("--no-durable", flags.no_durable)->group("");  // for the benchmark
}

Options options_from(const Flags& flags) {
  Options options;
  ServerSettings& server = options.server;
  server.data = flags.data.empty() ? default_data_folder() : std::filesystem::path(flags.data);
  if (!flags.http.empty()) server.http = address_from(flags.http, net::default_http_port);
  if (!flags.listen.empty()) server.listen = address_from(flags.listen, net::default_worker_port);
  server.token = !flags.token.empty()        ? flags.token
                 : !flags.token_file.empty() ? token_from_file(flags.token_file)
                                             : environment("TESSERA_TOKEN");
  server.insecure = flags.insecure;
  server.public_url = flags.public_url;
  server.pool_threads = flags.pool_threads;
  server.durable = !flags.no_durable;
  server.preparation_timeout = flags.preparation_timeout;
  if (!flags.film_memory.empty())
    server.film_memory = size_from(flags.film_memory, "--film-memory");
  server.keep_jobs = time_from(flags.keep_jobs, "--keep-jobs");
  if (!flags.disk_limit.empty()) server.disk_limit = size_from(flags.disk_limit, "--disk-limit");
  if (!flags.cache_size.empty()) server.blob_cache = size_from(flags.cache_size, "--cache-size");
  options.log_level = log::level_from(flags.log_level);
  check(server);
  return options;
}

}  // namespace

std::filesystem::path default_data_folder() {
  const std::filesystem::path state = environment("XDG_STATE_HOME");
  if (state.is_absolute()) return state / "tessera";
  const std::filesystem::path home = environment("HOME");
  if (home.is_absolute()) return home / ".local" / "state" / "tessera";
  return "tessera-data";
}

ParsedOptions parse_options(int argc, const char* const* argv) {
  CLI::App app(
      "The coordinator of a Tessera farm: takes jobs over HTTP, hands their tiles to workers and "
      "keeps what comes back.");
  Flags flags;
  declare(app, flags);
  ParsedOptions out;
  try {
    app.parse(argc, argv);
    out.options = options_from(flags);
  } catch (const CLI::Success& asked) {  // --help, --version
    app.exit(asked);
  } catch (const CLI::ParseError& error) {
    app.exit(error);
    out.exit_code = 2;
  } catch (const Error& error) {
    std::cerr << "tessera-server: " << error.what() << "\n";
    out.exit_code = exit_code(error.kind());
  }
  return out;
}

}  // namespace tessera::server
