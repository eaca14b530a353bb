#include "common/net/token.hpp"

#include "common/base/random.hpp"

namespace tessera::net {

std::string new_token() { return random_hex(32); }

std::string_view bearer_token(std::string_view authorization) {
  constexpr std::string_view scheme = "bearer ";
  if (authorization.size() <= scheme.size()) return {};
  for (std::size_t i = 0; i < scheme.size(); ++i) {
    const char c = authorization[i];
    if ((c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c) != scheme[i]) return {};
  }
  std::string_view token = authorization.substr(scheme.size());
  while (token.starts_with(' ')) token.remove_prefix(1);
  while (token.ends_with(' ')) token.remove_suffix(1);
  return token;
}

bool token_admits(std::string_view wanted, std::string_view shown) {
  return wanted.empty() || equal_secrets(wanted, shown);
}

}  // namespace tessera::net
