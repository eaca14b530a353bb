#pragma once
#include <string_view>

namespace tessera {

/// The commit that this was built from, "-dirty" behind it if the tree had changes; "unversioned"
/// outside git.
std::string_view build_commit();
/// Compiler, its version, build type, sanitizers and the flags that decide bits.
std::string_view build_flags();
/// The release, as MAJOR.MINOR.PATCH.
std::string_view version();

}  // namespace tessera
