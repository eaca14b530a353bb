#pragma once
#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <string_view>
#include <vector>

/// Cryptomatte's names for things (J. Friedman and A. Jones, "Fully automatic ID mattes with
/// support for motion blur and transparency", 2015, and its specification 1.2).
namespace tessera {

/// How many of the things that a pixel's samples saw a film keeps, …
constexpr std::size_t matte_slots = 16;
/// … and how many of these, the first, a picture shows.
constexpr std::size_t matte_ranks = 6;

/// MurmurHash3_32 of the name's bytes, seed 0.
std::uint32_t matte_hash(std::string_view name);
/// The hash's bits as a float; where that would be 0, denormal, infinite or no number, with the
/// lowest bit of the exponent turned around.
float matte_id(std::string_view name);
/// The id's bits, 8 hexadecimal digits: as a manifest has them.
std::string matte_hex(std::string_view name);

/// What a job's scene has, for manifests: known to who submits it. Empty: no manifest.
struct MatteNames {
  std::vector<std::string> objects, materials;
  bool operator==(const MatteNames&) const = default;
  [[nodiscard]] bool empty() const { return objects.empty() && materials.empty(); }
};
/// True if they may stand in a job, which travels whole to each worker: UTF-8, and together no
/// longer than 96 KiB as JSON.
bool can_travel(const MatteNames& names);

/// Throws Error{bad_input} at `cryptomatte` unless they can travel.
void check(const MatteNames& names);
nlohmann::json to_json(const MatteNames& names);
/// {"objects", "materials"}, each an array of names or lacking.
MatteNames matte_names_from(const nlohmann::json& json, const std::string& path);

}  // namespace tessera
