#include "tests/farm/small_disk.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <thread>

namespace tessera::farm_test {

namespace {

/// Root needs no user namespace of its own, and is refused one in some containers.
bool is_root() { return ::geteuid() == 0; }

std::vector<std::string> in_a_new_namespace() {
  if (is_root()) return {"/usr/bin/unshare", "--mount"};
  return {"/usr/bin/unshare", "--user", "--map-root-user", "--mount"};
}

std::vector<std::string> with_small_tmpfs(const std::filesystem::path& mount, std::size_t bytes) {
  std::vector<std::string> all = in_a_new_namespace();
  const std::string script = "mount -t tmpfs -o size=" + std::to_string(bytes) +
                             " tmpfs \"$0\" && echo mounted && exec sleep 3600";
  for (const std::string& word :
       {std::string("/bin/sh"), std::string("-c"), script, mount.string()})
    all.push_back(word);
  return all;
}

}  // namespace

SmallDisk::SmallDisk(std::size_t bytes)
    : holder_(with_small_tmpfs(mount_.path(), bytes), logs_ / "holder") {
  const auto mounted = [this] { return holder_.output() == "mounted\n"; };
  becomes_true([&] { return mounted() || !holder_.running(); }, Seconds(20));
  if (!mounted())
    throw std::runtime_error(
        "a tmpfs in a mount namespace cannot be had here, and the tests of full disks need one "
        "(configure with -DTESSERA_TEST_FULL_DISK=OFF to leave them out): " +
        holder_.errors());
}

std::vector<std::string> SmallDisk::inside() const {
  const std::string target = std::to_string(holder_.pid());
  if (is_root()) return {"/usr/bin/nsenter", "--mount", "--root", "--target", target};
  return {"/usr/bin/nsenter", "--preserve-credentials", "--user", "--mount", "--target", target};
}

std::filesystem::path SmallDisk::ballast() const {
  const std::filesystem::path root = "/proc/" + std::to_string(holder_.pid()) + "/root";
  return root / mount_.path().relative_path() / "ballast";
}

void SmallDisk::fill() const {
  const int file = ::open(ballast().c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
  if (file < 0) throw std::runtime_error("no file on the small disk");
  const std::vector<char> page(4096);
  while (::write(file, page.data(), page.size()) > 0) continue;
  const int problem = errno;
  ::close(file);
  if (problem != ENOSPC) throw std::runtime_error("the small disk does not become full");
}

void SmallDisk::remount(const std::string& options) const {
  std::vector<std::string> command = inside();
  for (const std::string& word :
       {std::string("/bin/mount"), std::string("-o"), options, mount_.path().string()})
    command.push_back(word);
  const Outcome outcome = run(command);
  if (outcome.code != 0) throw std::runtime_error("the small disk's mount: " + outcome.errors);
}

void SmallDisk::make_room() const { std::filesystem::remove(ballast()); }

}  // namespace tessera::farm_test
