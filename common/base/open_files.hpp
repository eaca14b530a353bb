#pragma once
#include <cstdint>

namespace tessera {

/// Lets this process have as many files open as it may without more rights: its soft limit becomes
/// its hard one. Gives the limit that holds from here on; UINT64_MAX if there is none.
std::uint64_t raise_open_files_limit();

}  // namespace tessera
