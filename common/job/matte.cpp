#include "common/job/matte.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>
#include <utility>

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

namespace {
bool is_short(const MatteNames& names) {
  // So that nothing is made that is far too large.
  std::size_t least = 0;
  for (const auto* list : {&names.objects, &names.materials})
    for (const std::string& name : *list) {
      least += name.size() + 2;
      if (least > limits::matte_names_bytes) return false;
    }
  return to_json(names).dump().size() <= limits::matte_names_bytes;
}

std::string without_manifest(std::string_view layer, std::string_view reason) {
  return fmt::format(
      "{} comes without a manifest, as {}: its ids can be picked in the picture, not by name",
      layer, reason);
}
}  // namespace

bool can_stand(const MatteNames& names) {
  return are_utf8(names.objects) && are_utf8(names.materials) && is_short(names);
}

FittingNames fitting(MatteNames names) {
  FittingNames out{.names = std::move(names), .left_out = {}};
  const auto leave_out = [&](std::vector<std::string>& list, std::string_view reason) {
    if (list.empty()) return;
    const bool objects = &list == &out.names.objects;
    const Aov layer = objects ? Aov::crypto_object : Aov::crypto_material;
    out.left_out.push_back(
        without_manifest(aov_table()[static_cast<std::size_t>(layer)].name, reason));
    list.clear();
  };
  for (auto* list : {&out.names.objects, &out.names.materials})
    if (!are_utf8(*list)) leave_out(*list, "a name is not UTF-8");
  if (is_short(out.names)) return out;
  const auto reason = [](std::string_view whose) {
    return fmt::format("{} are more than the {} KiB that a job may carry of them", whose,
                       limits::matte_names_bytes / limits::KiB);
  };
  const bool objects_fit = is_short({.objects = out.names.objects, .materials = {}});
  const bool materials_fit = is_short({.objects = {}, .materials = out.names.materials});
  if (materials_fit || !objects_fit) {
    leave_out(out.names.objects,
              reason(objects_fit ? "its names and those of materials together" : "its names"));
  }
  if (!materials_fit) leave_out(out.names.materials, reason("its names"));
  return out;
}

std::vector<std::string> mattes_without_names(std::span<const std::string> aovs,
                                              const MatteNames& names) {
  std::vector<std::string> out;
  for (const AovUse& use : aov_uses(aovs)) {
    const bool objects = use.aov == Aov::crypto_object && names.objects.empty();
    const bool materials = use.aov == Aov::crypto_material && names.materials.empty();
    if (objects || materials) out.push_back(use.name);
  }
  return out;
}

void check(const MatteNames& names) {
  if (!can_stand(names))
    throw Error(ErrorKind::bad_input,
                fmt::format("expected names in UTF-8, at most {} KiB of JSON",
                            limits::matte_names_bytes / limits::KiB),
                {.key = "cryptomatte"});
}

nlohmann::json to_json(const MatteNames& names) {
  nlohmann::json out = nlohmann::json::object();
  if (!names.objects.empty()) out["objects"] = names.objects;
  if (!names.materials.empty()) out["materials"] = names.materials;
  return out;
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
