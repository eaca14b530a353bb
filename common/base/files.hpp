#pragma once
#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// Writes `bytes` so that whoever opens `file` finds the old content or the new one, whole, also
/// after a power cut: into a temporary name in the same folder, synced, renamed, the folder synced.
/// The folder must exist. Throws Error{failed} with the file's name; then the old file stands
/// untouched and nothing is left beside it.
void write_file_atomically(const std::filesystem::path& file, std::span<const std::byte> bytes);
void write_file_atomically(const std::filesystem::path& file, std::string_view text);

/// The whole file. Throws Error{not_found, failed, or too_large if it has more than `most` bytes}
/// with the file's name; the size is checked before anything is allocated, and again while reading.
std::vector<std::byte> read_file(const std::filesystem::path& file, std::size_t most);
/// The same as text; nothing is converted.
std::string read_text_file(const std::filesystem::path& file, std::size_t most);

}  // namespace tessera
