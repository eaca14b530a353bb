#include <fmt/format.h>
#include <meshoptimizer.h>

#include "common/base/limits.hpp"
#include "common/scene/gltf/accessor.hpp"

namespace tessera::scene::gltf {

namespace {

/// No byte of a packed view stands for more: columns of equal bytes take 2 bits for 256 of them.
constexpr std::uint64_t densest_packing = 1024;

/// What EXT_meshopt_compression says of a buffer view.
struct Packed {
  std::size_t offset = 0, bytes = 0, stride = 0, count = 0;
  int buffer = 0;
  std::string mode, filter;
};

std::size_t size_or(const tinygltf::Value& object, const std::string& key) {
  return static_cast<std::size_t>(std::max(integer_or(object, key, 0), 0));
}

int unpack(const Packed& packed, const unsigned char* from, void* out) {
  if (packed.mode == "ATTRIBUTES")
    return meshopt_decodeVertexBuffer(out, packed.count, packed.stride, from, packed.bytes);
  if (packed.mode == "TRIANGLES")
    return meshopt_decodeIndexBuffer(out, packed.count, packed.stride, from, packed.bytes);
  return meshopt_decodeIndexSequence(out, packed.count, packed.stride, from, packed.bytes);
}

bool fits(const Packed& packed) {
  if (packed.mode == "ATTRIBUTES") {
    if (packed.stride % 4 != 0) return false;
    if (packed.filter == "OCTAHEDRAL") return packed.stride == 4 || packed.stride == 8;
    return packed.filter != "QUATERNION" || packed.stride == 8;
  }
  const bool index_size = packed.stride == 2 || packed.stride == 4;
  return index_size && packed.filter == "NONE" &&
         (packed.mode != "TRIANGLES" || packed.count % 3 == 0);
}

void apply_filter(const Packed& packed, void* out) {
  if (packed.filter == "OCTAHEDRAL")
    meshopt_decodeFilterOct(out, packed.count, packed.stride);
  else if (packed.filter == "QUATERNION")
    meshopt_decodeFilterQuat(out, packed.count, packed.stride);
  else if (packed.filter == "EXPONENTIAL")
    meshopt_decodeFilterExp(out, packed.count, packed.stride);
}

}  // namespace

const std::vector<std::byte>& Accessors::decompressed(int view, const tinygltf::Value& meshopt) {
  const auto found = decompressed_.find(view);
  if (found != decompressed_.end()) return found->second;
  const std::string place = fmt::format("/bufferViews/{}/extensions/EXT_meshopt_compression", view);
  const Packed packed{.offset = size_or(meshopt, "byteOffset"),
                      .bytes = size_or(meshopt, "byteLength"),
                      .stride = size_or(meshopt, "byteStride"),
                      .count = size_or(meshopt, "count"),
                      .buffer = integer_or(meshopt, "buffer", 0),
                      .mode = text_or(meshopt, "mode", ""),
                      .filter = text_or(meshopt, "filter", "NONE")};
  if (!fits(packed))
    asset_.fail(place, fmt::format("mode {} and filter {} do not go with a stride of {}",
                                   packed.mode, packed.filter, packed.stride));
  const std::size_t most = asset_.model.bufferViews[static_cast<std::size_t>(view)].byteLength;
  if (packed.count * packed.stride > most || most > limits::gltf_unpacked)
    asset_.fail(place, fmt::format("{} elements of {} bytes; the buffer view has {} bytes, and {} "
                                   "is the most",
                                   packed.count, packed.stride, most, limits::gltf_unpacked));
  const std::uint64_t there = asset_.buffer_bytes[static_cast<std::size_t>(packed.buffer)];
  if (packed.offset > there || packed.bytes > there - packed.offset)
    asset_.fail(place, fmt::format("{} bytes from {} on; /buffers/{} has {}", packed.bytes,
                                   packed.offset, packed.buffer, there));
  if (packed.count * packed.stride / densest_packing > packed.bytes)
    asset_.fail(place, fmt::format("{} elements of {} bytes cannot be in {} bytes: it is cut off",
                                   packed.count, packed.stride, packed.bytes));
  std::vector<std::byte> from(packed.bytes);
  read_bytes(packed.buffer, packed.offset, from);
  spend(packed.count * packed.stride, place);
  decompressed_bytes_ += packed.count * packed.stride;
  std::vector<std::byte> out(packed.count * packed.stride);
  if (unpack(packed, reinterpret_cast<const unsigned char*>(from.data()), out.data()) != 0)
    asset_.fail(place, "its bytes cannot be unpacked: they are damaged, or of a later version");
  apply_filter(packed, out.data());
  return decompressed_.emplace(view, std::move(out)).first->second;
}

}  // namespace tessera::scene::gltf
