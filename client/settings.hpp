#pragma once
#include <filesystem>
#include <optional>
#include <string>

/// Which server to speak to, as who, and how to answer.
namespace tessera::client {

enum class NamedBy { nobody, flag, environment, config };

struct Settings {
  std::string server = "http://127.0.0.1:8420";
  std::string token;
  bool json = false;
  NamedBy named = NamedBy::nobody;  ///< who named the server
};

/// What one source says of them; what is absent is left to the next.
struct GivenSettings {
  std::optional<std::string> server;
  std::optional<std::string> token;
};

/// Flags first, then environment, then the config file, then the defaults. A server without a
/// scheme is http.
Settings settle(const GivenSettings& flags, const GivenSettings& environment,
                const GivenSettings& config, bool json);

/// TESSERA_SERVER and TESSERA_TOKEN; empty ones are as if they were not there.
GivenSettings environment_settings();

/// $XDG_CONFIG_HOME/tessera/config.json, or ~/.config/tessera/config.json; empty without a home.
std::filesystem::path config_file();
/// {"server": URL, "token": TOKEN}, both optional; nothing if there is no such file. Throws
/// Error{bad_input} with the file's name for anything else in it.
GivenSettings config_settings(const std::filesystem::path& file);

}  // namespace tessera::client
