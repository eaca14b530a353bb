#pragma once
#include <cstddef>
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <span>
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
/// True if they may stand in a job: UTF-8, and to_json(names).dump(), with all its quotes, commas
/// and escapes, has at most limits::matte_names_bytes.
bool can_stand(const MatteNames& names);

struct FittingNames {
  MatteNames names;
  std::vector<std::string> left_out;  ///< for a person: a sentence for each list that is not there
};
/// What of the names can stand in a job. A list with a name that is not UTF-8 is left out; of two
/// that are too much together objects' are, or where that does not help materials', or both.
FittingNames fitting(MatteNames names);

/// Those of a job's AOVs that are Cryptomattes for which `names` has nothing: they come without a
/// manifest. Throws as aov_uses() does.
std::vector<std::string> mattes_without_names(std::span<const std::string> aovs,
                                              const MatteNames& names);

/// Throws Error{bad_input} at `cryptomatte` unless they can stand in a job.
void check(const MatteNames& names);
/// A list without a name is left away.
nlohmann::json to_json(const MatteNames& names);
/// {"objects", "materials"}, each an array of names or lacking.
MatteNames matte_names_from(const nlohmann::json& json, const std::string& path);

}  // namespace tessera
