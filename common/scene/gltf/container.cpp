#include "common/scene/gltf/container.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <array>
#include <cstring>

#include "common/base/error.hpp"
#include "common/base/file.hpp"
#include "common/base/limits.hpp"
#include "common/scene/read_file.hpp"

namespace tessera::scene::gltf {

namespace {

constexpr std::uint32_t magic = 0x46546c67;       // "glTF"
constexpr std::uint32_t json_chunk = 0x4e4f534a;  // "JSON"
constexpr std::uint32_t bin_chunk = 0x004e4942;   // "BIN"
constexpr std::uint64_t header_bytes = 12, chunk_header_bytes = 8;

template <std::size_t Count>
std::array<std::uint32_t, Count> words_at(const File& file, std::uint64_t offset) {
  std::array<std::uint32_t, Count> out{};
  file.read_at(std::as_writable_bytes(std::span(out)), offset);
  return out;
}

class Glb {
 public:
  Glb(const File& file, const std::string& name) : file_(file), name_(name), size_(file.size()) {}

  Container read() {
    if (size_ < header_bytes + chunk_header_bytes) fail(fmt::format("{} bytes are none", size_));
    const auto [first, version, length] = words_at<3>(file_, 0);
    if (version != 2) fail(fmt::format("version {}; only 2 can be read", version));
    if (length > size_)
      fail(fmt::format("its header says {} bytes, and the file has {}: it is cut off", length,
                       size_));
    size_ = length;
    const Chunk json = chunk_at(header_bytes);
    if (json.type != json_chunk) fail("its first chunk is not JSON");
    if (json.size > limits::scene_json_bytes)
      throw Error(
          ErrorKind::too_large,
          fmt::format("{} bytes of JSON; {} is the most", json.size, limits::scene_json_bytes),
          {.file = name_, .key = {}});
    Container out;
    out.json.resize(json.size);
    file_.read_at(std::as_writable_bytes(std::span(out.json)), json.offset);
    const std::uint64_t behind = (json.offset + json.size + 3) / 4 * 4;
    if (behind + chunk_header_bytes <= size_) {
      const Chunk binary = chunk_at(behind);
      if (binary.type == bin_chunk && binary.size > 0)
        out.binary = FileRange{.file = file_.path(), .offset = binary.offset, .size = binary.size};
    }
    return out;
  }

 private:
  struct Chunk {
    std::uint32_t type = 0;
    std::uint64_t offset = 0, size = 0;
  };

  [[noreturn]] void fail(const std::string& what) const {
    throw Error(ErrorKind::bad_input, "not a good .glb file: " + what, {.file = name_, .key = {}});
  }
  [[nodiscard]] Chunk chunk_at(std::uint64_t offset) const {
    const auto [length, type] = words_at<2>(file_, offset);
    const Chunk out{.type = type, .offset = offset + chunk_header_bytes, .size = length};
    if (out.offset + out.size > size_)
      fail(fmt::format("a chunk of {} bytes at {} ends beyond the file's {}", out.size, offset,
                       size_));
    return out;
  }

  const File& file_;
  const std::string& name_;
  std::uint64_t size_;
};

}  // namespace

Container read_container(const std::filesystem::path& path, const std::string& name) {
  const File file(path, O_RDONLY);
  if (file.size() >= 4 && words_at<1>(file, 0)[0] == magic) return Glb(file, name).read();
  return {.json = read_file(path, name, limits::scene_json_bytes), .binary = std::nullopt};
}

}  // namespace tessera::scene::gltf
