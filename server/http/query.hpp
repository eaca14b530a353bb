#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

/// The parts of a request's target. Pure.
namespace tessera::server {

/// `text` with its %XX undone; nothing if one is broken or makes a control character.
std::optional<std::string> percent_decoded(std::string_view text);

struct Target {
  std::vector<std::string> segments;  ///< of the path, decoded: "/v1/jobs" has two; "/" has none
  std::vector<std::pair<std::string, std::string>> query;

  [[nodiscard]] std::optional<std::string_view> parameter(std::string_view name) const;
  [[nodiscard]] std::string path() const;
};

/// Throws Error{bad_input}: not in origin form, a broken escape, a parameter twice.
Target parse_target(std::string_view target);

}  // namespace tessera::server
