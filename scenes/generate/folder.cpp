#include "scenes/generate/folder.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"

namespace tessera::generate {

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    throw Error(ErrorKind::failed,
                fmt::format("{} cannot be made: {}", folder.string(), error.message()));
}

}  // namespace tessera::generate
