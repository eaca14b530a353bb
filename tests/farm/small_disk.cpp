#include "tests/farm/small_disk.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <stdexcept>
#include <thread>

namespace tessera::farm_test {

SmallDisk::SmallDisk(std::size_t bytes)
    : holder_({"/usr/bin/unshare", "--user", "--map-root-user", "--mount", "/bin/sh", "-c",
               "mount -t tmpfs -o size=" + std::to_string(bytes) +
                   " tmpfs \"$0\" && echo mounted "
                   "&& exec sleep 3600",
               mount_.path().string()},
              logs_ / "holder") {
  const auto end = std::chrono::steady_clock::now() + Seconds(20);
  while (holder_.output() != "mounted\n") {
    if (!holder_.running() || std::chrono::steady_clock::now() > end)
      throw std::runtime_error(
          "a tmpfs in a user namespace cannot be had here, and the tests of full disks need one "
          "(configure with -DTESSERA_TEST_FULL_DISK=OFF to leave them out): " +
          holder_.errors());
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

std::vector<std::string> SmallDisk::inside() const {
  return {"/usr/bin/nsenter", "--preserve-credentials",     "--user", "--mount",
          "--target",         std::to_string(holder_.pid())};
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

void SmallDisk::make_room() const { std::filesystem::remove(ballast()); }

}  // namespace tessera::farm_test
