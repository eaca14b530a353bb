#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

#include "common/base/limits.hpp"

namespace tessera::scene {

constexpr std::size_t obj_bytes_most = 8 * limits::GiB;

/// A whole file. Throws Error{not_found, too_large or failed}, with the file called `name`.
std::string read_file(const std::filesystem::path& file, const std::string& name, std::size_t most);

}  // namespace tessera::scene
