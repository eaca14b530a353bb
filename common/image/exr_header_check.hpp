#pragma once
#include <cstddef>
#include <span>
#include <string>

namespace tessera::image {

/// Goes over an EXR file's headers as they stand: every attribute has the length that its type
/// wants, and lies within the file. OpenEXR takes memory for what a length says before it looks
/// whether that is there, and reads some types without looking at their length at all, so that what
/// comes next is anything. Throws Error{bad_input} at `name`.
void check_exr_header(std::span<const std::byte> exr, const std::string& name);

}  // namespace tessera::image
