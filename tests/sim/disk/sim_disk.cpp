#include "tests/sim/disk/sim_disk.hpp"

#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>

#include "common/base/error.hpp"
#include "tests/sim/disk/sim_vfs.hpp"

namespace tessera::sim {

namespace fs = std::filesystem;

namespace {

std::string folder_of(const std::string& file) {
  return file.substr(0, std::max<std::size_t>(1, file.rfind('/')));
}

}  // namespace

SimDisk::SimDisk(std::uint64_t seed) : faults(Random(seed ^ 0x5eed)), random_(seed) {
  static std::uint64_t count = 0;
  vfs_name_ = fmt::format("simulated-{}", ++count);
  vfs_ = make_vfs(*this, vfs_name_);
  sqlite3_vfs_register(vfs_.get(), 0);
  const auto root = std::make_shared<Inode>();
  names_["/"] = safe_["/"] = root;
}

SimDisk::~SimDisk() { sqlite3_vfs_unregister(vfs_.get()); }

// ---- faults ----

void SimDisk::die(bool power) {
  dead_ = true;
  power_lost_ = power_lost_ || power;
}

void SimDisk::kill() {
  if (dead_) return;
  faults.count(Fault::kill);
  die(false);
}

void SimDisk::cut_power() {
  if (!dead_) faults.count(Fault::power);
  die(true);
}

bool SimDisk::commit_point() { return !dead_ && (reach(Point::commit, ""), !dead_); }

Fault SimDisk::reach(Point point, const std::string& file) {
  const Fault fault = faults.reach(point);
  if (watch) watch(faults.points(), point, fault, file);
  if (fault == Fault::kill || fault == Fault::power) die(fault == Fault::power);
  return fault;
}

void SimDisk::power_on() {
  if (power_lost_) {
    CutWeather weather;
    weather.kind = static_cast<CutWeather::Kind>(random_.whole(0, 3));
    weather.kept = random_.between(0.05, 0.95);
    weather.garbage = random_.chance(0.5);
    lose_names(weather);
    std::set<Inode*> seen;  // a file may have two names on its way from one to the other
    for (const auto& [name, inode] : names_)
      if (seen.insert(inode.get()).second) sectors_lost_ += inode->cut(weather, random_);
  }
  held_.clear();
  forget_locks(*vfs_);
  dead_ = power_lost_ = false;
}

void SimDisk::lose_names(const CutWeather& weather) {
  for (const auto& [folder, changes] : unsynced_) {
    bool ended = false;
    for (const NameChange& change : changes) {
      bool keep = weather.kind == CutWeather::Kind::kept;
      if (weather.kind == CutWeather::Kind::any) keep = random_.chance(weather.kept);
      if (weather.kind == CutWeather::Kind::in_order) {
        ended = ended || !random_.chance(weather.kept);
        keep = !ended;
      }
      // A name cannot be taken from a file that never came to have it.
      if (keep && (change.from.empty() || safe_.contains(change.from))) apply(safe_, change);
    }
  }
  unsynced_.clear();
  // What stands in a folder that is gone is gone, too.
  for (auto name = safe_.begin(); name != safe_.end();)
    name = safe_.contains(folder_of(name->first)) ? std::next(name) : safe_.erase(name);
  names_ = safe_;
}

void SimDisk::apply(Names& names, const NameChange& change) {
  if (!change.from.empty()) names.erase(change.from);
  if (!change.to.empty()) names[change.to] = change.made;
}

SimDisk::Done SimDisk::change(Point point, const std::string& file, NameChange change) {
  if (dead_) return Done::failed;
  const Fault fault = reach(point, file);
  // Whether it was done before the process ended, or failed, nobody can say.
  const bool done = fault == Fault::none || random_.chance(0.3);
  if (done) {
    apply(names_, change);
    unsynced_[folder_of(file)].push_back(std::move(change));
  }
  return fault == Fault::none ? Done::yes : Done::failed;
}

// ---- files by their inode ----

SimDisk::InodePtr SimDisk::find(const std::string& file) const {
  const auto found = names_.find(file);
  return found == names_.end() ? nullptr : found->second;
}

SimDisk::InodePtr SimDisk::make(const std::string& file, Done& done) {
  auto inode = std::make_shared<Inode>();
  done = change(Point::create, file, {"", file, inode});
  return inode;
}

SimDisk::Done SimDisk::unlink(const std::string& file) {
  return change(Point::remove, file, {file, "", nullptr});
}

SimDisk::Done SimDisk::write(Inode& inode, const std::string& file, std::uint64_t offset,
                             std::span<const std::byte> bytes) {
  if (dead_) return Done::failed;
  const Fault fault = reach(Point::write, file);
  if (fault == Fault::none) {
    inode.write(offset, bytes);
    return Done::yes;
  }
  // A full disk takes not all of it; otherwise, who knows.
  const auto size = static_cast<std::int64_t>(bytes.size());
  const auto part =
      random_.whole(0, fault == Fault::full ? std::max<std::int64_t>(size, 1) - 1 : size);
  inode.write(offset, bytes.first(static_cast<std::size_t>(part)));
  return fault == Fault::full ? Done::full : Done::failed;
}

SimDisk::Done SimDisk::truncate(Inode& inode, const std::string& file, std::uint64_t size) {
  if (dead_) return Done::failed;
  const Fault fault = reach(Point::truncate, file);
  if (fault == Fault::none || random_.chance(0.3)) inode.truncate(size);
  return fault == Fault::none ? Done::yes : Done::failed;
}

SimDisk::Done SimDisk::sync(Inode& inode, const std::string& file) {
  if (dead_) return Done::failed;
  const Fault fault = reach(Point::sync, file);
  if (fault == Fault::none) inode.sync();
  if (fault == Fault::error) inode.fail_sync(random_);
  return fault == Fault::none ? Done::yes : Done::failed;
}

SimDisk::Done SimDisk::settle(const std::string& folder) {
  if (dead_) return Done::failed;
  const Fault fault = reach(Point::sync_folder, folder);
  if (fault != Fault::none) return Done::failed;
  for (const NameChange& change : unsynced_[folder]) apply(safe_, change);
  unsynced_.erase(folder);
  return Done::yes;
}

std::uint64_t SimDisk::bytes_in(const fs::path& folder, std::string_view suffix) const {
  std::uint64_t sum = 0;
  for (const auto& [name, inode] : names_)
    if (name.ends_with(suffix) && folder_of(name) == folder.string()) sum += inode->bytes().size();
  return sum;
}

void require_done(SimDisk::Done done, const std::string& file, const char* what) {
  if (done == SimDisk::Done::yes) return;
  throw Error(
      ErrorKind::failed,
      fmt::format("cannot be {}: {}", what,
                  done == SimDisk::Done::full ? "No space left on device" : "Input/output error"),
      {.file = file});
}

}  // namespace tessera::sim
