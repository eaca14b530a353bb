#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

using Json = nlohmann::json;

/// Parses JSON that came from outside: no doubled keys, no nesting deeper than limits::json_depth,
/// nothing behind it. Throws Error{bad_input} with `name`, line and column. (The library's own
/// parse lets doubled keys pass.)
Json parse_json(std::string_view text, std::string_view name);

/// Reads the members of one JSON object by name, and then insists that there were no others. Every
/// error names the key's path. Numbers must be finite.
class ObjectReader {
 public:
  /// `path` is where the object stands, e.g. "film"; empty for the root. Throws if `json` is no
  /// object.
  ObjectReader(const Json& json, std::string path);

  [[nodiscard]] bool has(std::string_view key) const;
  /// The member itself; throws if it is lacking.
  const Json& required(std::string_view key);
  /// The member, or nullptr.
  const Json* optional(std::string_view key);

  std::string text(std::string_view key);
  std::string text_or(std::string_view key, std::string fallback);
  bool boolean_or(std::string_view key, bool fallback);
  /// A whole number within [low, high].
  std::int64_t integer(std::string_view key, std::int64_t low, std::int64_t high);
  std::int64_t integer_or(std::string_view key, std::int64_t low, std::int64_t high,
                          std::int64_t fallback);
  double number(std::string_view key, double low, double high);
  double number_or(std::string_view key, double low, double high, double fallback);

  /// Throws if the object has a member that nothing above asked for; names the nearest that was.
  void finish() const;

  [[nodiscard]] std::string path_of(std::string_view key) const;
  [[noreturn]] void fail(std::string_view key, const std::string& message) const;

 private:
  const Json& json_;
  std::string path_;
  std::vector<std::string> asked_;
};

}  // namespace tessera
