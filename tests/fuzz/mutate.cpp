#include "tests/fuzz/mutate.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace tessera::fuzz {

std::size_t Mutator::below(std::size_t bound) {
  return bound == 0 ? 0 : static_cast<std::size_t>(random_() % bound);
}

std::string Mutator::mutant(const std::string& one, const std::string& other, std::size_t most) {
  std::string out = one;
  const std::size_t changes = 1 + below(4);
  for (std::size_t i = 0; i < changes; ++i) change(out, other);
  if (out.size() > most) out.resize(most);
  return out;
}

void Mutator::change(std::string& bytes, const std::string& other) {
  if (bytes.empty()) {
    bytes.push_back(static_cast<char>(below(256)));
    return;
  }
  const std::size_t at = below(bytes.size());
  const std::size_t length = 1 + below(std::min<std::size_t>(bytes.size() - at, 32));
  switch (below(9)) {
    case 0:
      bytes[at] = static_cast<char>(static_cast<unsigned char>(bytes[at]) ^ (1U << below(8)));
      break;
    case 1:
      bytes[at] = static_cast<char>(below(256));
      break;
    case 2:
      set_field(bytes);
      break;
    case 3:
      set_number(bytes);
      break;
    case 4:
      bytes.resize(at);
      break;
    case 5:
      bytes.erase(at, length);
      break;
    case 6:
      bytes.insert(at, bytes.substr(at, length));
      break;
    case 7:
      bytes.insert(at, length, static_cast<char>(below(256)));
      break;
    default:
      splice(bytes, other);
      break;
  }
}

/// A whole number of one to eight bytes, of either byte order, at the edge of what it can hold.
void Mutator::set_field(std::string& bytes) {
  constexpr std::array<std::uint64_t, 10> edges{
      0, 1, 0x7f, 0x80, 0xff, 0x7fff, 0x7fffffff, 0x80000000, 0xffffffff, ~std::uint64_t{0}};
  const std::size_t size = std::min(std::size_t{1} << below(4), bytes.size());
  const std::size_t at = below(bytes.size() - size + 1);
  const std::uint64_t value = edges[below(edges.size())] - below(2);
  const bool big_endian = below(2) != 0;
  for (std::size_t i = 0; i < size; ++i)
    bytes[at + (big_endian ? size - 1 - i : i)] = static_cast<char>(value >> (8 * i) & 0xff);
}

/// The same for one that is written in digits.
void Mutator::set_number(std::string& bytes) {
  constexpr std::array<std::string_view, 12> edges{
      "0",  "-1", "1",     "255",   "65536", "2147483647", "4294967296", "18446744073709551615",
      "-0", ".5", "1e308", "1e-320"};
  std::size_t at = below(bytes.size());
  const auto is_digit = [&](std::size_t i) {
    return i < bytes.size() && std::isdigit(static_cast<unsigned char>(bytes[i])) != 0;
  };
  while (at < bytes.size() && !is_digit(at)) ++at;
  std::size_t end = at;
  while (is_digit(end)) ++end;
  if (at < end) bytes.replace(at, end - at, edges[below(edges.size())]);
}

/// A piece of another input instead of one here.
void Mutator::splice(std::string& bytes, const std::string& other) {
  if (other.empty()) return;
  const std::size_t from = below(other.size());
  const std::size_t length = 1 + below(other.size() - from);
  const std::size_t at = below(bytes.size());
  bytes.replace(at, below(bytes.size() - at + 1), other, from, length);
}

}  // namespace tessera::fuzz
