#include "server/store/whole_file.hpp"

#include <string>

#include "common/base/error.hpp"

namespace tessera::server {

namespace {

void remove_if_there(Disk& disk, const std::filesystem::path& file) {
  try {
    disk.remove(file);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::not_found) throw;
  }
}

}  // namespace

void write_whole(Disk& disk, const std::filesystem::path& file, bool durable,
                 const std::function<void(DiskFile&)>& write) {
  const std::filesystem::path folder = file.parent_path();
  make_folder(disk, folder.parent_path(), durable);
  make_folder(disk, folder, durable);
  const std::filesystem::path part = file.string() + std::string(part_suffix);
  remove_if_there(disk, part);
  try {
    const auto out = disk.create(part);
    write(*out);
    if (durable) out->sync();
    disk.rename(part, file);
  } catch (...) {
    try {
      remove_if_there(disk, part);
    } catch (const Error&) {
      // The next attempt, or the next start, removes it.
    }
    throw;
  }
  if (durable) disk.sync_folder(folder);
}

}  // namespace tessera::server
