#include "common/scene/gltf/accessor.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <type_traits>

#include "common/base/limits.hpp"

namespace tessera::scene::gltf {

namespace {

std::string accessor_place(int accessor) { return fmt::format("/accessors/{}", accessor); }

std::size_t size_of_component(int type) {
  return static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(type)));
}

/// By way of a signed number where it is of 32 unsigned bits, for which there is an instruction:
/// for vectors of unsigned ones g++ puts two halves together by a contracted one. Its product is
/// exact, but the house's test tells none from another.
template <class To, class From>
To converted(From value) {
  if constexpr (std::is_same_v<From, std::uint32_t> && std::is_floating_point_v<To>)
    return static_cast<To>(static_cast<std::int64_t>(value));
  return static_cast<To>(value);
}

/// One number; integers that stand for fractions become them.
template <class From, class To>
To number_from(const std::byte* at, bool normalized) {
  From value;
  std::memcpy(&value, at, sizeof value);
  if constexpr (std::is_floating_point_v<To> && std::is_integral_v<From>) {
    if (normalized)
      return std::max(converted<To>(value) / converted<To>(std::numeric_limits<From>::max()),
                      To{-1});
  }
  return converted<To>(value);
}

struct Elements {
  const std::byte* first = nullptr;
  std::size_t stride = 0, components = 0;
  bool normalized = false;
};

template <class From, class To>
void convert_all(const Elements& from, std::size_t count, To* out) {
  for (std::size_t i = 0; i < count; ++i)
    for (std::size_t k = 0; k < from.components; ++k)
      *out++ =
          number_from<From, To>(from.first + i * from.stride + k * sizeof(From), from.normalized);
}

template <class To>
void convert(int type, const Elements& from, std::size_t count, To* out) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return convert_all<std::int8_t>(from, count, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return convert_all<std::uint8_t>(from, count, out);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return convert_all<std::int16_t>(from, count, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return convert_all<std::uint16_t>(from, count, out);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return convert_all<std::uint32_t>(from, count, out);
    default:
      if constexpr (std::is_same_v<To, float>) convert_all<float>(from, count, out);
  }
}

}  // namespace

std::size_t Accessors::components(int accessor) const {
  return static_cast<std::size_t>(
      tinygltf::GetNumComponentsInType(static_cast<uint32_t>(of(accessor).type)));
}

Accessors::Accessors(const Asset& asset) : asset_(asset), budget_(limits::gltf_made) {
  for (const std::uint64_t bytes : asset.buffer_bytes) budget_ += bytes * limits::gltf_made_ratio;
}

void Accessors::spend(std::uint64_t bytes, const std::string& place) {
  if (bytes > budget_)
    throw Error(ErrorKind::too_large,
                fmt::format("the file unpacks to more than {} MiB and {} times its buffers",
                            limits::gltf_made / limits::MiB, limits::gltf_made_ratio),
                {.file = asset_.name, .key = place});
  budget_ -= bytes;
}

void Accessors::check(int accessor, std::size_t wanted, const std::string& place) {
  const tinygltf::Accessor& from = of(accessor);
  if (components(accessor) != wanted)
    asset_.fail(place, fmt::format("expected an accessor of {} numbers an element; {} has {}",
                                   wanted, accessor_place(accessor), components(accessor)));
  const bool matrix = from.type >= 0x20 && from.type < 0x40;
  if (matrix && from.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT)
    asset_.fail(
        place, fmt::format("expected matrices of floats; {} has others", accessor_place(accessor)));
  if (unpacked_.contains(accessor)) {
    return spend(std::uint64_t{count(accessor)} * wanted * sizeof(float), accessor_place(accessor));
  }
  const std::size_t most = from.bufferView < 0 ? limits::gltf_zeros : limits::mesh_vertices;
  if (from.count > most)
    throw Error(ErrorKind::too_large, fmt::format("{} elements; {} is the most", from.count, most),
                {.file = asset_.name, .key = accessor_place(accessor) + "/count"});
  spend(std::uint64_t{from.count} * wanted * sizeof(float), accessor_place(accessor));
}

void Accessors::check_integers(int accessor, const std::string& place) const {
  const int type = of(accessor).componentType;
  if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE &&
      type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
      type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
    asset_.fail(place, fmt::format("expected an accessor of unsigned integers; {} has others",
                                   accessor_place(accessor)));
}

void Accessors::read(int accessor, float* out) {
  read_all(accessor, out);
  const std::size_t size = count(accessor) * components(accessor);
  const float* const bad = std::find_if(out, out + size, [](float x) { return !std::isfinite(x); });
  if (bad != out + size)
    asset_.fail(accessor_place(accessor),
                fmt::format("element {} holds a number that is not finite",
                            static_cast<std::size_t>(bad - out) / components(accessor)));
}

void Accessors::read(int accessor, std::uint32_t* out) { read_all(accessor, out); }

template <class To>
void Accessors::read_all(int accessor, To* out) {
  const tinygltf::Accessor& from = of(accessor);
  const std::size_t size = size_of_component(from.componentType) * components(accessor);
  if (const auto found = unpacked_.find(accessor); found != unpacked_.end()) {
    const Unpacked& unpacked = found->second;
    convert(unpacked.component_type,
            Elements{.first = unpacked.bytes.data(),
                     .stride = size_of_component(unpacked.component_type) * components(accessor),
                     .components = components(accessor),
                     .normalized = from.normalized},
            unpacked.count, out);
    return;
  }
  if (from.bufferView >= 0) {
    const Raw bytes = raw({.view = from.bufferView,
                           .offset = from.byteOffset,
                           .count = from.count,
                           .size = size,
                           .place = accessor_place(accessor)});
    convert(from.componentType,
            Elements{.first = bytes.first,
                     .stride = bytes.stride,
                     .components = components(accessor),
                     .normalized = from.normalized},
            from.count, out);
  }
  if (from.sparse.isSparse) read_sparse(accessor, out);
}

template <class To>
void Accessors::read_sparse(int accessor, To* out) {
  const tinygltf::Accessor& from = of(accessor);
  const std::string place = accessor_place(accessor) + "/sparse";
  const auto changed = static_cast<std::uint64_t>(from.sparse.count);
  if (changed > from.count)
    asset_.fail(place + "/count",
                fmt::format("{} elements are to change, and there are {}", changed, from.count));
  const Raw at = raw({.view = from.sparse.indices.bufferView,
                      .offset = static_cast<std::uint64_t>(from.sparse.indices.byteOffset),
                      .count = changed,
                      .size = size_of_component(from.sparse.indices.componentType),
                      .place = place + "/indices"});
  std::vector<std::uint32_t> indices(changed);
  convert(from.sparse.indices.componentType,
          Elements{.first = at.first, .stride = at.stride, .components = 1}, changed,
          indices.data());
  const std::size_t size = size_of_component(from.componentType) * components(accessor);
  const Raw values = raw({.view = from.sparse.values.bufferView,
                          .offset = static_cast<std::uint64_t>(from.sparse.values.byteOffset),
                          .count = changed,
                          .size = size,
                          .place = place + "/values"});
  for (std::size_t i = 0; i < changed; ++i) {
    if (indices[i] >= from.count)
      asset_.fail(place + "/indices", fmt::format("index {} is beyond the accessor's {} elements",
                                                  indices[i], from.count));
    convert(from.componentType,
            Elements{.first = values.first + i * values.stride,
                     .stride = values.stride,
                     .components = components(accessor),
                     .normalized = from.normalized},
            1, out + indices[i] * components(accessor));
  }
}

Accessors::Raw Accessors::raw(const Run& run) {
  const tinygltf::BufferView& view = asset_.model.bufferViews[static_cast<std::size_t>(run.view)];
  const std::string view_place = fmt::format("/bufferViews/{}", run.view);
  Raw out;
  out.stride = view.byteStride != 0 ? view.byteStride : run.size;
  if (out.stride < run.size)
    asset_.fail(view_place + "/byteStride",
                fmt::format("{} bytes; an element of {} has {}", out.stride, run.place, run.size));
  const std::uint64_t needed = (run.count - 1) * out.stride + run.size;
  if (run.offset > view.byteLength || needed > view.byteLength - run.offset)
    asset_.fail(run.place, fmt::format("its {} elements need {} bytes from {} on; {} has {}",
                                       run.count, needed, run.offset, view_place, view.byteLength));
  if (const auto* meshopt = extension(view.extensions, "EXT_meshopt_compression")) {
    const std::vector<std::byte>& whole = decompressed(run.view, *meshopt);
    if (run.offset + needed > whole.size())
      asset_.fail(run.place, fmt::format("ends beyond what {} unpacks to", view_place));
    out.first = whole.data() + run.offset;
    return out;
  }
  out.held.resize(needed);
  read_bytes(view.buffer, view.byteOffset + run.offset, out.held);
  out.first = out.held.data();
  return out;
}

void Accessors::read_bytes(int buffer, std::uint64_t offset, std::span<std::byte> out) {
  const Bytes& bytes = asset_.buffers[static_cast<std::size_t>(buffer)];
  if (const auto* range = std::get_if<FileRange>(&bytes)) {
    File& file = open_[buffer];
    if (!file.is_open()) file = File(range->file, O_RDONLY);
    file.read_at(out, range->offset + offset);
  } else {
    const auto first = std::get<1>(bytes)->begin() + static_cast<std::ptrdiff_t>(offset);
    std::copy_n(first, out.size(), out.begin());
  }
}

}  // namespace tessera::scene::gltf
