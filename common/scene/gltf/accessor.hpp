#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "common/base/file.hpp"
#include "common/scene/gltf/asset.hpp"

namespace tessera::scene::gltf {

/// Reads accessors: interleaved, normalised, sparse, compressed. Each reading takes just the bytes
/// that it needs from the file. Throws Error{bad_input} with a JSON pointer where an accessor or
/// its buffer views reach beyond what is there, have another type than is wanted, or hold numbers
/// that are not finite; checked before anything is allocated.
class Accessors {
 public:
  explicit Accessors(const Asset& asset);

  /// Counts bytes that the file makes in memory. Throws Error{too_large} at `place` when a small
  /// file has made too many, before they are: the same few bytes, or none, may be named any number
  /// of times.
  void spend(std::uint64_t bytes, const std::string& place);
  /// Bytes that may still be made, and those that are kept here for all readings to come.
  [[nodiscard]] std::uint64_t budget() const { return budget_ + decompressed_bytes_; }
  /// All that was spent since the budget was `before` has been let go of, but for `bytes` and what
  /// is kept here.
  void keep_only(std::uint64_t before, std::uint64_t bytes, const std::string& place) {
    budget_ = before - decompressed_bytes_;
    spend(bytes, place);
  }

  /// From here on the accessors of `primitive` have what KHR_draco_mesh_compression says, if it
  /// does; those of the primitive before it no longer do. True if so: then indices are of a list of
  /// triangles. `place` is the primitive's.
  bool unpack_mesh(const tinygltf::Primitive& primitive, const std::string& place);

  [[nodiscard]] std::size_t count(int accessor) const;
  /// Numbers in each element: 1 for SCALAR, 16 for MAT4.
  [[nodiscard]] std::size_t components(int accessor) const;

  /// As numbers, normalised integers as 0…1 or −1…1. `place` is what names the accessor.
  template <std::size_t Size>
  std::vector<std::array<float, Size>> vectors(int accessor, const std::string& place) {
    check(accessor, Size, place);
    std::vector<std::array<float, Size>> out(count(accessor));
    read(accessor, reinterpret_cast<float*>(out.data()));
    return out;
  }
  std::vector<float> scalars(int accessor, const std::string& place) {
    check(accessor, 1, place);
    std::vector<float> out(count(accessor));
    read(accessor, out.data());
    return out;
  }
  /// Elements one after another, whatever their size.
  std::vector<float> numbers(int accessor, const std::string& place) {
    check(accessor, components(accessor), place);
    std::vector<float> out(count(accessor) * components(accessor));
    read(accessor, out.data());
    return out;
  }
  /// Unsigned integers that are not normalised.
  template <std::size_t Size>
  std::vector<std::array<std::uint32_t, Size>> integers(int accessor, const std::string& place) {
    check(accessor, Size, place);
    check_integers(accessor, place);
    std::vector<std::array<std::uint32_t, Size>> out(count(accessor));
    read(accessor, reinterpret_cast<std::uint32_t*>(out.data()));
    return out;
  }

 private:
  [[nodiscard]] const tinygltf::Accessor& of(int accessor) const {
    return asset_.model.accessors[static_cast<std::size_t>(accessor)];
  }
  void check(int accessor, std::size_t components, const std::string& place);
  void check_integers(int accessor, const std::string& place) const;
  void read(int accessor, float* out);
  void read(int accessor, std::uint32_t* out);
  template <class To>
  void read_all(int accessor, To* out);
  template <class To>
  void read_sparse(int accessor, To* out);

  /// `count` elements of `size` bytes, `stride` apart (0: as the view says, or packed), from
  /// `offset` in a view on.
  struct Run {
    int view = 0;
    std::uint64_t offset = 0, count = 0, size = 0;
    std::string place;
  };
  struct Raw {
    std::vector<std::byte> held;
    const std::byte* first = nullptr;
    std::size_t stride = 0;
  };
  Raw raw(const Run& run);
  /// They must be there.
  void read_bytes(int buffer, std::uint64_t offset, std::span<std::byte> out);
  const std::vector<std::byte>& decompressed(int view, const tinygltf::Value& meshopt);

  /// What stands in for an accessor's own bytes.
  struct Unpacked {
    int component_type = 0;
    std::size_t count = 0;
    std::vector<std::byte> bytes;
  };

  const Asset& asset_;
  std::uint64_t budget_;              ///< bytes that may still be made
  std::map<int, Unpacked> unpacked_;  ///< by accessor
  std::map<int, File> open_;
  std::map<int, std::vector<std::byte>> decompressed_;
  std::uint64_t decompressed_bytes_ = 0;
};

}  // namespace tessera::scene::gltf
