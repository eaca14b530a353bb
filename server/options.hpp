#pragma once
#include <optional>
#include <string>

#include "common/base/log.hpp"
#include "server/server.hpp"

namespace tessera::server {

struct Options {
  ServerSettings server;
  log::Level log_level = log::Level::info;
};

/// What the command line and the environment say. Gives an exit code instead where there is nothing
/// to start: 0 after --help and --version, 2 after wrong usage, which it has said on standard
/// error.
struct ParsedOptions {
  std::optional<Options> options;
  int exit_code = 0;
};
ParsedOptions parse_options(int argc, const char* const* argv);

/// Where data is kept unless --data says otherwise: $XDG_STATE_HOME/tessera, or
/// ~/.local/state/tessera, or tessera-data here.
std::filesystem::path default_data_folder();

}  // namespace tessera::server
