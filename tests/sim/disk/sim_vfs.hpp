#pragma once
#include <memory>
#include <string>

struct sqlite3_vfs;

namespace tessera::sim {

class SimDisk;

/// SQLite's way to the simulated disk: files, their locks, and the memory that the connections of
/// one process share. To be registered by its name; unregister it before the disk goes.
std::shared_ptr<sqlite3_vfs> make_vfs(SimDisk& disk, const std::string& name);

/// The process has ended: its locks and its shared memory are gone.
void forget_locks(sqlite3_vfs& vfs);

}  // namespace tessera::sim
