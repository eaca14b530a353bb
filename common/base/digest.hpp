#pragma once
#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace tessera {

/// A SHA-256: the name of a blob, a scene, a plan, a build.
struct Digest {
  std::array<std::uint8_t, 32> bytes{};

  auto operator<=>(const Digest&) const = default;
  /// 64 lower-case hexadecimal digits.
  [[nodiscard]] std::string hex() const;
  /// From 64 hexadecimal digits of either case; nothing else.
  static std::optional<Digest> from_hex(std::string_view text);
};

/// SHA-256 of a stream of bytes (FIPS 180-4), by OpenSSL.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;

  void update(std::span<const std::byte> bytes);
  void update(std::string_view text);
  /// The digest of all bytes so far; the object must not be used afterwards.
  Digest finish();

 private:
  struct Context;
  std::unique_ptr<Context> context_;
};

Digest digest_of(std::span<const std::byte> bytes);
Digest digest_of(std::string_view text);
/// Reads the file in pieces. Throws Error{not_found or failed} with the file's name.
Digest digest_of_file(const std::filesystem::path& file);

}  // namespace tessera

template <>
struct std::hash<tessera::Digest> {
  std::size_t operator()(const tessera::Digest& digest) const noexcept {
    std::size_t value = 0;
    for (std::size_t i = 0; i < sizeof value; ++i) value = value << 8 | digest.bytes[i];
    return value;
  }
};
