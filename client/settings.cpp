#include "client/settings.hpp"

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/files.hpp"
#include "common/base/json.hpp"
#include "common/base/limits.hpp"

namespace tessera::client {

namespace {
std::optional<std::string> variable(const char* name) {
  const char* const value = std::getenv(name);
  if (value == nullptr || *value == '\0') return std::nullopt;
  return std::string(value);
}

std::optional<std::string> first_of(const std::optional<std::string>& a,
                                    const std::optional<std::string>& b,
                                    const std::optional<std::string>& c) {
  return a ? a : b ? b : c;
}
}  // namespace

Settings settle(const GivenSettings& flags, const GivenSettings& environment,
                const GivenSettings& config, bool json) {
  Settings out;
  out.json = json;
  out.server = first_of(flags.server, environment.server, config.server).value_or(out.server);
  out.named = flags.server         ? NamedBy::flag
              : environment.server ? NamedBy::environment
              : config.server      ? NamedBy::config
                                   : NamedBy::nobody;
  out.token = first_of(flags.token, environment.token, config.token).value_or("");
  if (out.server.find("://") == std::string::npos) out.server = "http://" + out.server;
  return out;
}

GivenSettings environment_settings() {
  return {variable("TESSERA_SERVER"), variable("TESSERA_TOKEN")};
}

std::filesystem::path config_file() {
  if (const auto folder = variable("XDG_CONFIG_HOME"))
    return std::filesystem::path(*folder) / "tessera" / "config.json";
  if (const auto home = variable("HOME"))
    return std::filesystem::path(*home) / ".config" / "tessera" / "config.json";
  return {};
}

GivenSettings config_settings(const std::filesystem::path& file) {
  std::error_code error;
  if (file.empty() || !std::filesystem::exists(file, error)) return {};
  const Json json = parse_json(read_text_file(file, limits::MiB), file.string());
  try {
    ObjectReader in(json, "");
    GivenSettings out;
    if (in.optional("server") != nullptr) out.server = in.text("server");
    if (in.optional("token") != nullptr) out.token = in.text("token");
    in.finish();
    return out;
  } catch (const Error& wrong) {
    Place place = wrong.place();
    place.file = file.string();
    throw Error(wrong.kind(), wrong.message(), place);
  }
}

}  // namespace tessera::client
