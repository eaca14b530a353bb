#include "common/base/files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>
#include <system_error>

#include "common/base/error.hpp"
#include "common/base/file.hpp"
#include "common/base/random.hpp"

namespace tessera {

namespace {

namespace fs = std::filesystem;

/// A pipe or a device keeps its name: it is written to, never renamed over.
bool takes_bytes_as_they_come(const fs::path& file) {
  std::error_code problem;
  const auto status = fs::status(file, problem);
  return fs::exists(status) && !fs::is_regular_file(status);
}

/// What befell a file is told of the name that was asked for.
[[noreturn]] void fail(const Error& error, const fs::path& named) {
  throw Error(ErrorKind::failed, error.message(), {.file = named.string()});
}

}  // namespace

void write_file_atomically(const fs::path& named, std::span<const std::byte> bytes) {
  constexpr mode_t all = 0666;  // less the umask
  if (takes_bytes_as_they_come(named)) {
    try {
      File(named, O_WRONLY).write(bytes);
    } catch (const Error& error) {
      fail(error, named);
    }
    return;
  }
  std::error_code problem;
  const fs::path canonical =
      fs::canonical(named, problem);  // a link stays, what it names is replaced
  const fs::path file = problem ? named : canonical;
  const fs::path folder = file.has_parent_path() ? file.parent_path() : fs::path(".");
  const fs::path temporary =
      folder / fmt::format(".{}.{}", file.filename().string(), random_hex(6));
  try {
    File out(temporary, O_WRONLY | O_CREAT | O_EXCL, all);
    out.write_at(bytes, 0);
    out.sync();
    fs::rename(temporary, file, problem);
    if (problem) throw Error(kind_of(problem), "cannot be renamed to: " + problem.message());
  } catch (const Error& error) {
    fs::remove(temporary, problem);
    fail(error, named);
  }
  sync_folder(folder);
}

void write_file_atomically(const fs::path& file, std::string_view text) {
  write_file_atomically(file, std::as_bytes(std::span(text.data(), text.size())));
}

namespace {

template <class Container>
Container read_whole(const fs::path& file, std::size_t most) {
  const File in(file, O_RDONLY);
  const auto too_large = [&] {
    return Error(ErrorKind::too_large,
                 fmt::format("has more than the {} bytes that it may have", most),
                 {.file = file.string()});
  };
  std::error_code unknown;
  if (fs::is_directory(file, unknown))
    throw Error(ErrorKind::failed, "cannot be read: it is a folder", {.file = file.string()});
  const std::uint64_t told = in.size();
  if (told > most) throw too_large();
  Container bytes;
  std::size_t size = 0;
  bytes.resize(told);
  for (;;) {
    const auto room = std::as_writable_bytes(std::span(bytes)).subspan(size);
    if (room.empty()) {
      // At the told size one more byte is asked for: a pipe tells none, and a file may grow while
      // it is read.
      std::array<std::byte, 1> next{};
      if (in.read_some(next) == 0) return bytes;
      if (size + 1 > most) throw too_large();
      bytes.resize(std::min(most, std::max<std::size_t>(size + 4096, size + size / 2)));
      std::memcpy(bytes.data() + size++, next.data(), next.size());
      continue;
    }
    const std::size_t got = in.read_some(room);
    size += got;
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
