#pragma once
#include <cstddef>
#include <filesystem>

namespace tessera::generate {

/// Writes lake.json to the folder, which is made if it is not there: `lanterns` paper lanterns, a
/// sphere that emits each, afloat on a lake at night and rising from it. The same arguments give
/// the same bytes. Throws Error{failed} with the file's name.
void write_lake(const std::filesystem::path& folder, std::size_t lanterns);

}  // namespace tessera::generate
