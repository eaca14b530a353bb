#pragma once
#include <filesystem>

namespace tessera::generate {

/// Does nothing if it is there. Throws Error{failed} with the folder's name.
void make_folder(const std::filesystem::path& folder);

}  // namespace tessera::generate
