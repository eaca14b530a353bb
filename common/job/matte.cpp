#include "common/job/matte.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/json.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/job/aovs.hpp"

namespace tessera {

namespace {
static_assert(std::endian::native == std::endian::little);

std::uint32_t mixed(std::uint32_t block) {
  return std::rotl(block * 0xcc9e2d51U, 15) * 0x1b873593U;
}

bool are_utf8(const std::vector<std::string>& names) {
  return std::all_of(names.begin(), names.end(), [](const auto& name) { return is_utf8(name); });
}
}  // namespace

// Austin Appleby's MurmurHash3_x86_32.
std::uint32_t matte_hash(std::string_view name) {
  constexpr std::size_t block_bytes = sizeof(std::uint32_t);
  std::uint32_t hash = 0;
  std::size_t at = 0;
  for (; at + block_bytes <= name.size(); at += block_bytes) {
    std::uint32_t block = 0;
    std::memcpy(&block, name.data() + at, block_bytes);
    hash = std::rotl(hash ^ mixed(block), 13) * 5 + 0xe6546b64U;
  }
  std::uint32_t tail = 0;
  for (std::size_t i = name.size(); i > at; --i)
    tail = tail << 8 | static_cast<unsigned char>(name[i - 1]);
  hash ^= mixed(tail);
  hash ^= static_cast<std::uint32_t>(name.size());
  hash = (hash ^ hash >> 16) * 0x85ebca6bU;
  hash = (hash ^ hash >> 13) * 0xc2b2ae35U;
  return hash ^ hash >> 16;
}

float matte_id(std::string_view name) {
  const std::uint32_t hash = matte_hash(name);
  const std::uint32_t exponent = hash >> 23 & 0xffU;
  const bool unusable = exponent == 0 || exponent == 0xff;
  return std::bit_cast<float>(unusable ? hash ^ 1U << 23 : hash);
}

std::string matte_hex(std::string_view name) {
  return fmt::format("{:08x}", std::bit_cast<std::uint32_t>(matte_id(name)));
}

bool can_travel(const MatteNames& names) {
  constexpr std::size_t most = 96 * limits::KiB;
  std::size_t bytes = 0;
  for (const auto* list : {&names.objects, &names.materials}) {
    for (const std::string& name : *list) bytes += name.size();
    if (bytes > most || !are_utf8(*list)) return false;
  }
  return to_json(names).dump().size() <= most;
}

void check(const MatteNames& names) {
  if (!can_travel(names))
    throw Error(ErrorKind::bad_input, "expected names in UTF-8, at most 96 KiB of JSON",
                {.key = "cryptomatte"});
}

nlohmann::json to_json(const MatteNames& names) {
  return {{"objects", names.objects}, {"materials", names.materials}};
}

MatteNames matte_names_from(const nlohmann::json& json, const std::string& path) {
  MatteNames names;
  ObjectReader in(json, path);
  if (const auto* given = in.optional("objects"))
    names.objects = names_from(*given, in.path_of("objects"));
  if (const auto* given = in.optional("materials"))
    names.materials = names_from(*given, in.path_of("materials"));
  in.finish();
  return names;
}

}  // namespace tessera
