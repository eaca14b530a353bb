#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::scene::gltf {

/// The bytes of a data URI ("data:…;base64,…" or with %XX), or nothing if `uri` is none. Throws
/// Error{bad_input} without a place where it cannot be decoded.
std::optional<std::vector<std::byte>> decode_data_uri(std::string_view uri);

/// A relative reference as a path: %XX decoded. Throws Error{bad_input} without a place for a URI
/// with a scheme, or a % without two digits.
std::string path_of_uri(std::string_view uri);

}  // namespace tessera::scene::gltf
