#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

namespace tessera::scene {

/// A whole file. Throws Error{not_found, too_large or failed}, with the file called `name`.
std::string read_file(const std::filesystem::path& file, const std::string& name, std::size_t most);

}  // namespace tessera::scene
