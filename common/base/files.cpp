#include "common/base/files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "common/base/error.hpp"
#include "common/base/random.hpp"

namespace tessera {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const char* what, int code, const fs::path& file) {
  const ErrorKind kind =
      code == ENOENT || code == ENOTDIR ? ErrorKind::not_found : ErrorKind::failed;
  throw Error(kind, fmt::format("{}: {}", what, std::strerror(code)), {.file = file.string()});
}

class Descriptor {
 public:
  Descriptor(const fs::path& file, int flags)
      : number_(::open(file.c_str(), flags | O_CLOEXEC, 0666)) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  [[nodiscard]] bool is_open() const { return number_ >= 0; }
  [[nodiscard]] int number() const { return number_; }

 private:
  int number_;
};

/// 0, or the system's error code.
int write_all(int descriptor, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return errno;
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
  return 0;
}

/// A pipe or a device keeps its name: it is written to, never renamed over.
bool takes_bytes_as_they_come(const fs::path& file) {
  std::error_code problem;
  const auto status = fs::status(file, problem);
  return fs::exists(status) && !fs::is_regular_file(status);
}

void sync_folder(const fs::path& folder) {
  const Descriptor directory(folder, O_RDONLY | O_DIRECTORY);
  if (!directory.is_open()) fail("cannot open the folder to sync it", errno, folder);
  // Some file systems cannot sync a folder, and say EINVAL; the rename is then as safe as they make
  // it.
  if (::fsync(directory.number()) != 0 && errno != EINVAL)
    fail("cannot sync the folder", errno, folder);
}

}  // namespace

void write_file_atomically(const fs::path& named, std::span<const std::byte> bytes) {
  if (takes_bytes_as_they_come(named)) {
    const Descriptor out(named, O_WRONLY);
    const int problem = out.is_open() ? write_all(out.number(), bytes) : errno;
    if (problem != 0)
      throw Error(ErrorKind::failed, std::strerror(problem), {.file = named.string()});
    return;
  }
  std::error_code no_link;
  const fs::path canonical =
      fs::canonical(named, no_link);  // a link stays, what it names is replaced
  const fs::path file = no_link ? named : canonical;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const fs::path temporary =
      folder / fmt::format(".{}.{}", file.filename().string(), random_hex(6));
  int problem = 0;
  {
    const Descriptor out(temporary, O_WRONLY | O_CREAT | O_EXCL);
    if (!out.is_open())
      throw Error(ErrorKind::failed, fmt::format("cannot be written: {}", std::strerror(errno)),
                  {.file = named.string()});
    problem = write_all(out.number(), bytes);
    if (problem == 0 && ::fsync(out.number()) != 0) problem = errno;
  }
  if (problem == 0 && ::rename(temporary.c_str(), file.c_str()) != 0) problem = errno;
  if (problem != 0) {
    ::unlink(temporary.c_str());
    throw Error(ErrorKind::failed, fmt::format("cannot be written: {}", std::strerror(problem)),
                {.file = named.string()});
  }
  sync_folder(folder);
}

void write_file_atomically(const fs::path& file, std::string_view text) {
  write_file_atomically(file, std::as_bytes(std::span(text.data(), text.size())));
}

namespace {

template <class Container>
Container read_whole(const fs::path& file, std::size_t most) {
  const Descriptor in(file, O_RDONLY);
  if (!in.is_open()) fail("cannot be opened", errno, file);
  struct stat status {};
  if (::fstat(in.number(), &status) != 0) fail("cannot be read", errno, file);
  if (S_ISDIR(status.st_mode)) fail("cannot be read", EISDIR, file);
  const auto too_large = [&] {
    return Error(ErrorKind::too_large,
                 fmt::format("has more than the {} bytes that it may have", most),
                 {.file = file.string()});
  };
  const auto told = static_cast<std::size_t>(std::max<off_t>(0, status.st_size));
  if (told > most) throw too_large();
  Container bytes;
  std::size_t size = 0;
  bytes.resize(told);
  for (;;) {
    if (size == bytes.size()) {
      // At the told size one more byte is asked for: a pipe tells none, and a file may grow while
      // it is read.
      char next = 0;
      const ssize_t more = ::read(in.number(), &next, 1);
      if (more < 0 && errno == EINTR) continue;
      if (more < 0) fail("reading failed", errno, file);
      if (more == 0) return bytes;
      if (size + 1 > most) throw too_large();
      bytes.resize(std::min(most, std::max<std::size_t>(size + 4096, size + size / 2)));
      std::memcpy(bytes.data() + size++, &next, 1);
      continue;
    }
    const ssize_t got = ::read(in.number(), bytes.data() + size, bytes.size() - size);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail("reading failed", errno, file);
    size += static_cast<std::size_t>(got);
    if (got == 0) {
      bytes.resize(size);
      return bytes;
    }
  }
}

}  // namespace

std::vector<std::byte> read_file(const fs::path& file, std::size_t most) {
  return read_whole<std::vector<std::byte>>(file, most);
}

std::string read_text_file(const fs::path& file, std::size_t most) {
  return read_whole<std::string>(file, most);
}

}  // namespace tessera
