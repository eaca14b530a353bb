#pragma once
#include <filesystem>
#include <functional>
#include <string_view>

#include "server/store/disk.hpp"

namespace tessera::server {

/// What a file is called until it is whole. One that a killed process left is of no meaning.
constexpr std::string_view part_suffix = ".part";

/// Under a temporary name in the same folder (which is made, and its parent, where they are
/// lacking), then renamed. If `durable` it survives a power cut from here on. Throws Error with the
/// file's name, or what `write` throws; what stood there before stands then still, or, where the
/// last sync failed, the new one may.
void write_whole(Disk& disk, const std::filesystem::path& file, bool durable,
                 const std::function<void(DiskFile&)>& write);

}  // namespace tessera::server
