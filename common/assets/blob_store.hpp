#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "common/assets/eviction.hpp"
#include "common/base/digest.hpp"

namespace tessera::assets {

/// Blobs on disk: DIR/ab/cdef…, named by their SHA-256. A name stands only over whole, checked
/// bytes: blobs are written under another name and renamed. Thread-safe; two processes may share a
/// folder.
class BlobStore {
 public:
  /// Makes the folder if it is not there. `durable`: a blob that was finished survives a power cut
  /// (fsync); a cache does without. Throws Error{failed} that names the folder.
  explicit BlobStore(std::filesystem::path folder, bool durable = true);
  ~BlobStore();
  BlobStore(const BlobStore&) = delete;
  BlobStore& operator=(const BlobStore&) = delete;

  // ---- looking ----
  [[nodiscard]] bool has(const Digest& digest) const;
  /// Those of `digests` that are not here, in the same order.
  [[nodiscard]] std::vector<Digest> missing(std::span<const Digest> digests) const;
  /// Where the blob is, or would be.
  [[nodiscard]] std::filesystem::path path(const Digest& digest) const;
  /// Bytes; nullopt if it is not here.
  [[nodiscard]] std::optional<std::uint64_t> size(const Digest& digest) const;
  /// The whole blob. Throws Error{not_found}; Error{too_large} if it has more than `most` bytes.
  [[nodiscard]] std::string read(const Digest& digest, std::size_t most) const;
  /// Reads the file again: true if its bytes are what its name says; if not, it is removed.
  bool verify(const Digest& digest);

  // ---- an upload that can be resumed: one partial file per digest ----
  /// Bytes of the partial file; 0 if there is none.
  [[nodiscard]] std::uint64_t partial_size(const Digest& digest) const;
  /// Adds bytes at `offset`, which must be partial_size(): else Error{conflict} that says what it
  /// is. Two who upload the same blob thus help each other. Error{too_large} beyond
  /// limits::blob_bytes. Gives the new partial size.
  std::uint64_t append(const Digest& digest, std::uint64_t offset,
                       std::span<const std::byte> bytes);
  /// The partial file is whole: checks its digest and gives it its name. Error{bad_input} if the
  /// bytes are others, and the partial file is gone then. Nothing happens if the blob is here
  /// already.
  void finish(const Digest& digest);
  /// Removes partial and temporary files that were not touched for this long.
  void remove_partials(std::int64_t older_than_seconds);

  /// A whole blob at once.
  Digest put(std::span<const std::byte> bytes);

  /// A blob that is fetched in one go, under a temporary name of its own. Dropped without commit()
  /// it leaves nothing.
  class Writer {
   public:
    ~Writer();
    Writer(Writer&&) noexcept;
    Writer& operator=(Writer&&) = delete;
    /// Error{too_large} beyond limits::blob_bytes; Error{failed} where the disk refuses.
    void write(std::span<const std::byte> bytes);
    [[nodiscard]] std::uint64_t size() const;
    /// Error{bad_input} if the digest of all that was written is not the one asked for.
    void commit();

   private:
    friend class BlobStore;
    struct State;
    explicit Writer(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
  };
  Writer writer(const Digest& digest);

  // ---- a cache: pins and eviction ----
  /// While it lives, no process evicts these blobs.
  class Pin {
   public:
    ~Pin();

   private:
    friend class BlobStore;
    Pin(BlobStore& store, std::uint64_t number) : store_(store), number_(number) {}
    BlobStore& store_;
    std::uint64_t number_;
  };
  /// Pins them whether they are here or not yet, and marks them as used now. The store must outlive
  /// the pin.
  std::unique_ptr<Pin> pin(std::vector<Digest> digests);
  struct Evicted {
    std::uint64_t blobs = 0, bytes = 0;  ///< that were removed
    std::uint64_t left = 0;              ///< bytes of those that were not
  };
  /// Removes the least recently used blobs, but none that any process has pinned, until those left
  /// have at most `most` bytes.
  Evicted evict(std::uint64_t most);

  // ---- a server's store: what nobody needs goes ----
  /// Marks those that are here as used now: what is there afterwards is not collected for as long
  /// as what was just uploaded.
  void touch(std::span<const Digest> digests);
  /// … one, and gives its size; nullopt if it is not here.
  std::optional<std::uint64_t> renew(const Digest& digest);
  /// Bytes of all blobs and partial uploads.
  [[nodiscard]] std::uint64_t bytes() const;
  /// The same of the blobs that are not among `needed`, and of uploads that broke off.
  Evicted collect(const std::set<Digest>& needed, const EvictionRule& rule);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace tessera::assets
