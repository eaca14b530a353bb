#include "tests/sim/disk/sim_vfs.hpp"

#include <sqlite3.h>

#include <array>
#include <cstring>
#include <map>
#include <new>
#include <utility>
#include <vector>

#include "tests/sim/disk/sim_disk.hpp"

namespace tessera::sim {

namespace {

struct OpenFile;

/// What the connections of one process share of one file.
struct Shared {
  int readers = 0;  // with a lock of SHARED or more
  const OpenFile* reserved = nullptr;
  const OpenFile* exclusive = nullptr;
  int mapped = 0;
  std::vector<std::unique_ptr<std::array<std::byte, 32768>>> memory;
  std::array<int, SQLITE_SHM_NLOCK> readers_of{};
  std::array<const OpenFile*, SQLITE_SHM_NLOCK> writer_of{};
};

struct Vfs : sqlite3_vfs {
  SimDisk* disk = nullptr;
  Random random{1};
  std::string name;
  std::map<Inode*, std::shared_ptr<Shared>> shared;
};

struct OpenFile : sqlite3_file {
  Vfs* vfs = nullptr;
  std::string path;
  SimDisk::InodePtr inode;
  std::shared_ptr<Shared> shared;
  int level = SQLITE_LOCK_NONE;
  bool mapped = false;
  bool temporary = false;
  bool fresh = false;  // its name is not yet certain: the next sync makes it so
  bool removed_at_close = false;
};

OpenFile& file_of(sqlite3_file* file) { return *static_cast<OpenFile*>(file); }
Vfs& vfs_of(sqlite3_vfs* vfs) { return *static_cast<Vfs*>(vfs); }

int code_of(SimDisk::Done done, int failed) {
  if (done == SimDisk::Done::yes) return SQLITE_OK;
  return done == SimDisk::Done::full ? SQLITE_FULL : failed;
}

// ---- bytes ----

int close_file(sqlite3_file* handle) {
  OpenFile& file = file_of(handle);
  if (file.removed_at_close) static_cast<void>(file.vfs->disk->unlink(file.path));
  file.~OpenFile();
  return SQLITE_OK;
}

int read_file(sqlite3_file* handle, void* to, int count, sqlite3_int64 from) {
  const OpenFile& file = file_of(handle);
  if (file.vfs->disk->dead()) return SQLITE_IOERR_READ;
  const auto& bytes = file.inode->bytes();
  const auto offset = static_cast<std::size_t>(from);
  const auto wanted = static_cast<std::size_t>(count);
  const std::size_t there = offset < bytes.size() ? std::min(wanted, bytes.size() - offset) : 0;
  if (there > 0) std::memcpy(to, bytes.data() + offset, there);
  if (there == wanted) return SQLITE_OK;
  std::memset(static_cast<std::byte*>(to) + there, 0, wanted - there);
  return SQLITE_IOERR_SHORT_READ;
}

int write_file(sqlite3_file* handle, const void* from, int count, sqlite3_int64 offset) {
  OpenFile& file = file_of(handle);
  const std::span bytes(static_cast<const std::byte*>(from), static_cast<std::size_t>(count));
  if (file.temporary) {
    file.inode->write(static_cast<std::uint64_t>(offset), bytes);
    return SQLITE_OK;
  }
  return code_of(
      file.vfs->disk->write(*file.inode, file.path, static_cast<std::uint64_t>(offset), bytes),
      SQLITE_IOERR_WRITE);
}

int truncate_file(sqlite3_file* handle, sqlite3_int64 size) {
  OpenFile& file = file_of(handle);
  if (file.temporary) {
    file.inode->truncate(static_cast<std::uint64_t>(size));
    return SQLITE_OK;
  }
  return code_of(file.vfs->disk->truncate(*file.inode, file.path, static_cast<std::uint64_t>(size)),
                 SQLITE_IOERR_TRUNCATE);
}

int sync_file(sqlite3_file* handle, int) {
  OpenFile& file = file_of(handle);
  if (file.temporary) return SQLITE_OK;
  const int code = code_of(file.vfs->disk->sync(*file.inode, file.path), SQLITE_IOERR_FSYNC);
  if (code != SQLITE_OK || !file.fresh) return code;
  // As SQLite's own does for journals that it has made.
  const std::string folder = std::filesystem::path(file.path).parent_path().string();
  if (file.vfs->disk->settle(folder) != SimDisk::Done::yes) return SQLITE_IOERR_DIR_FSYNC;
  file.fresh = false;
  return SQLITE_OK;
}

int file_size(sqlite3_file* handle, sqlite3_int64* size) {
  if (file_of(handle).vfs->disk->dead()) return SQLITE_IOERR_FSTAT;
  *size = static_cast<sqlite3_int64>(file_of(handle).inode->bytes().size());
  return SQLITE_OK;
}

int file_control(sqlite3_file*, int, void*) { return SQLITE_NOTFOUND; }
int sector_size(sqlite3_file*) { return 4096; }
int device_characteristics(sqlite3_file*) { return SQLITE_IOCAP_POWERSAFE_OVERWRITE; }

// ---- locks of the file ----

int lock_file(sqlite3_file* handle, int level) {
  OpenFile& file = file_of(handle);
  Shared& shared = *file.shared;
  if (level <= file.level) return SQLITE_OK;
  if (shared.exclusive != nullptr && shared.exclusive != &file) return SQLITE_BUSY;
  if (level == SQLITE_LOCK_SHARED) {
    ++shared.readers;
  } else {
    if (shared.reserved != nullptr && shared.reserved != &file) return SQLITE_BUSY;
    if (level == SQLITE_LOCK_EXCLUSIVE) {
      if (shared.readers > 1) return SQLITE_BUSY;
      shared.exclusive = &file;
    }
    shared.reserved = &file;
  }
  file.level = level;
  return SQLITE_OK;
}

int unlock_file(sqlite3_file* handle, int level) {
  OpenFile& file = file_of(handle);
  Shared& shared = *file.shared;
  if (level >= file.level) return SQLITE_OK;
  if (shared.reserved == &file) shared.reserved = nullptr;
  if (shared.exclusive == &file) shared.exclusive = nullptr;
  if (level == SQLITE_LOCK_NONE) --shared.readers;
  file.level = level;
  return SQLITE_OK;
}

int check_reserved(sqlite3_file* handle, int* result) {
  *result = file_of(handle).shared->reserved != nullptr ? 1 : 0;
  return SQLITE_OK;
}

// ---- the memory that connections share ----

int map_memory(sqlite3_file* handle, int region, int size, int extend, void volatile** at) {
  OpenFile& file = file_of(handle);
  Shared& shared = *file.shared;
  const auto index = static_cast<std::size_t>(region);
  if (!std::exchange(file.mapped, true)) ++shared.mapped;
  *at = nullptr;
  if (static_cast<std::size_t>(size) != sizeof(*shared.memory[0])) return SQLITE_IOERR_SHMMAP;
  if (index >= shared.memory.size() && extend == 0) return SQLITE_OK;
  while (index >= shared.memory.size())
    shared.memory.push_back(std::make_unique<std::array<std::byte, 32768>>());
  *at = shared.memory[index]->data();
  return SQLITE_OK;
}

int lock_memory(sqlite3_file* handle, int first, int count, int flags) {
  const OpenFile& file = file_of(handle);
  Shared& shared = *file.shared;
  const bool exclusive = (flags & SQLITE_SHM_EXCLUSIVE) != 0;
  const auto each = [&](auto what) {
    for (int i = first; i < first + count; ++i) what(static_cast<std::size_t>(i));
  };
  if ((flags & SQLITE_SHM_UNLOCK) != 0) {
    each([&](std::size_t i) {
      if (exclusive && shared.writer_of.at(i) == &file) shared.writer_of.at(i) = nullptr;
      if (!exclusive) --shared.readers_of.at(i);
    });
    return SQLITE_OK;
  }
  bool free = true;
  each([&](std::size_t i) {
    free =
        free && shared.writer_of.at(i) == nullptr && (!exclusive || shared.readers_of.at(i) == 0);
  });
  if (!free) return SQLITE_BUSY;
  each([&](std::size_t i) {
    if (exclusive)
      shared.writer_of.at(i) = &file;
    else
      ++shared.readers_of.at(i);
  });
  return SQLITE_OK;
}

void memory_barrier(sqlite3_file*) {}
int unmap_memory(sqlite3_file* handle, int) {
  OpenFile& file = file_of(handle);
  // As with SQLite's own: whoever comes first finds none, and recovers what the log says.
  if (std::exchange(file.mapped, false) && --file.shared->mapped == 0) file.shared->memory.clear();
  return SQLITE_OK;
}

const sqlite3_io_methods methods{2,
                                 close_file,
                                 read_file,
                                 write_file,
                                 truncate_file,
                                 sync_file,
                                 file_size,
                                 lock_file,
                                 unlock_file,
                                 check_reserved,
                                 file_control,
                                 sector_size,
                                 device_characteristics,
                                 map_memory,
                                 lock_memory,
                                 memory_barrier,
                                 unmap_memory,
                                 nullptr,
                                 nullptr};

// ---- names ----

int open_file(sqlite3_vfs* handle, const char* name, sqlite3_file* at, int flags, int* out_flags) {
  Vfs& vfs = vfs_of(handle);
  at->pMethods = nullptr;
  SimDisk& disk = *vfs.disk;
  if (disk.dead()) return SQLITE_CANTOPEN;
  SimDisk::InodePtr inode;
  bool fresh = false;
  if (name == nullptr) {
    inode = std::make_shared<Inode>();
  } else {
    inode = disk.find(name);
    if (!inode) {
      if ((flags & SQLITE_OPEN_CREATE) == 0) return SQLITE_CANTOPEN;
      SimDisk::Done done = SimDisk::Done::yes;
      inode = disk.make(name, done);
      if (done != SimDisk::Done::yes) return SQLITE_CANTOPEN;
      fresh = (flags & (SQLITE_OPEN_MAIN_JOURNAL | SQLITE_OPEN_WAL)) != 0;
    }
  }
  auto* file = new (at) OpenFile;
  file->pMethods = &methods;
  file->vfs = &vfs;
  file->path = name != nullptr ? name : "";
  file->inode = inode;
  file->temporary = name == nullptr;
  file->fresh = fresh;
  file->removed_at_close = name != nullptr && (flags & SQLITE_OPEN_DELETEONCLOSE) != 0;
  auto& shared = vfs.shared[inode.get()];
  if (!shared) shared = std::make_shared<Shared>();
  file->shared = shared;
  if (out_flags != nullptr) *out_flags = flags;
  return SQLITE_OK;
}

int delete_file(sqlite3_vfs* handle, const char* name, int sync_folder) {
  SimDisk& disk = *vfs_of(handle).disk;
  if (disk.dead()) return SQLITE_IOERR_DELETE;
  if (!disk.find(name)) return SQLITE_IOERR_DELETE_NOENT;
  const int code = code_of(disk.unlink(name), SQLITE_IOERR_DELETE);
  if (code != SQLITE_OK || sync_folder == 0) return code;
  return code_of(disk.settle(std::filesystem::path(name).parent_path().string()),
                 SQLITE_IOERR_DIR_FSYNC);
}

int access_file(sqlite3_vfs* handle, const char* name, int flags, int* result) {
  if (vfs_of(handle).disk->dead()) return SQLITE_IOERR_ACCESS;
  const SimDisk::InodePtr inode = vfs_of(handle).disk->find(name);
  // As SQLite's own: an empty file is none where existence is asked for.
  *result = inode && (flags != SQLITE_ACCESS_EXISTS || !inode->bytes().empty()) ? 1 : 0;
  return SQLITE_OK;
}

int full_path(sqlite3_vfs*, const char* name, int size, char* to) {
  sqlite3_snprintf(size, to, "%s", name);
  return SQLITE_OK;
}

int randomness(sqlite3_vfs* handle, int size, char* to) {
  for (int i = 0; i < size; ++i) to[i] = static_cast<char>(vfs_of(handle).random.next());
  return size;
}

int sleep_none(sqlite3_vfs*, int microseconds) { return microseconds; }
int current_time(sqlite3_vfs*, sqlite3_int64* milliseconds) {
  *milliseconds = 212'000'000'000'000;
  return SQLITE_OK;
}
int current_day(sqlite3_vfs*, double* day) {
  *day = 2453700;
  return SQLITE_OK;
}
int last_error(sqlite3_vfs*, int, char*) { return 0; }

}  // namespace

std::shared_ptr<sqlite3_vfs> make_vfs(SimDisk& disk, const std::string& name) {
  auto vfs = std::make_shared<Vfs>();
  vfs->disk = &disk;
  vfs->name = name;
  vfs->iVersion = 2;
  vfs->szOsFile = sizeof(OpenFile);
  vfs->mxPathname = 512;
  vfs->zName = vfs->name.c_str();
  vfs->xOpen = open_file;
  vfs->xDelete = delete_file;
  vfs->xAccess = access_file;
  vfs->xFullPathname = full_path;
  vfs->xRandomness = randomness;
  vfs->xSleep = sleep_none;
  vfs->xCurrentTime = current_day;
  vfs->xCurrentTimeInt64 = current_time;
  vfs->xGetLastError = last_error;
  return vfs;
}

void forget_locks(sqlite3_vfs& vfs) { vfs_of(&vfs).shared.clear(); }

}  // namespace tessera::sim
