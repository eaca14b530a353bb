#include "common/assets/blob_store.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <mutex>
#include <utility>

#include "common/assets/blob_state.hpp"
#include "common/base/error.hpp"
#include "common/base/file.hpp"
#include "common/base/files.hpp"
#include "common/base/limits.hpp"
#include "common/base/random.hpp"

namespace tessera::assets {

namespace fs = std::filesystem;

namespace {
[[noreturn]] void wrong_digest(const Digest& wanted, const Digest& found) {
  throw Error(
      ErrorKind::bad_input,
      fmt::format("the bytes of blob {} have the SHA-256 {}: they were changed or cut on their way",
                  wanted.hex(), found.hex()));
}

void check_size(const Digest& digest, std::uint64_t size) {
  if (size > limits::blob_bytes)
    throw Error(ErrorKind::too_large,
                fmt::format("blob {} has more than the {} bytes that a blob may have", digest.hex(),
                            limits::blob_bytes));
}
}  // namespace

std::shared_ptr<std::mutex> BlobStore::State::mutex_of(const Digest& digest) {
  const std::lock_guard lock(mutex);
  std::erase_if(busy, [](const auto& entry) { return entry.second.use_count() == 1; });
  std::shared_ptr<std::mutex>& found = busy[digest];
  if (!found) found = std::make_shared<std::mutex>();
  return found;
}

void BlobStore::State::give_name(const fs::path& from, const Digest& digest) const {
  const fs::path to = path(digest);
  std::error_code error;
  const bool made = fs::create_directory(to.parent_path(), error);
  if (!error) fs::rename(from, to, error);
  if (error)
    throw Error(kind_of(error), fmt::format("cannot rename the file: {}", error.message()),
                {.file = from.string()});
  if (!durable) return;
  sync_folder(to.parent_path());
  if (made) sync_folder(folder);
}

BlobStore::BlobStore(fs::path folder, bool durable) {
  try {
    for (const char* part : {"partial", "tmp", "pins"}) fs::create_directories(folder / part);
  } catch (const fs::filesystem_error& error) {
    throw Error(ErrorKind::failed,
                fmt::format("cannot make the folder: {}", error.code().message()),
                {.file = folder.string()});
  }
  state_ = std::make_unique<State>(std::move(folder), durable);
}
BlobStore::~BlobStore() = default;

bool BlobStore::has(const Digest& digest) const { return size(digest).has_value(); }

std::vector<Digest> BlobStore::missing(std::span<const Digest> digests) const {
  std::vector<Digest> lacking;
  for (const Digest& digest : digests)
    if (!has(digest)) lacking.push_back(digest);
  return lacking;
}

fs::path BlobStore::path(const Digest& digest) const { return state_->path(digest); }

std::optional<std::uint64_t> BlobStore::size(const Digest& digest) const {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(path(digest), error);
  if (error) return std::nullopt;
  return bytes;
}

std::string BlobStore::read(const Digest& digest, std::size_t most) const {
  return read_text_file(path(digest), most);
}

bool BlobStore::verify(const Digest& digest) {
  const fs::path file = path(digest);
  try {
    if (digest_of_file(file) == digest) return true;
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::not_found) return false;
    throw;
  }
  std::error_code ignored;
  fs::remove(file, ignored);
  return false;
}

std::uint64_t BlobStore::partial_size(const Digest& digest) const {
  std::error_code error;
  const std::uintmax_t bytes = fs::file_size(state_->partial(digest), error);
  return error ? 0 : bytes;
}

std::uint64_t BlobStore::append(const Digest& digest, std::uint64_t offset,
                                std::span<const std::byte> bytes) {
  const auto mutex = state_->mutex_of(digest);
  const std::lock_guard lock(*mutex);
  const std::uint64_t here = partial_size(digest);
  if (offset != here)
    throw Error(ErrorKind::conflict, fmt::format("the upload of blob {} goes on at byte {}, not {}",
                                                 digest.hex(), here, offset));
  check_size(digest, bytes.size());
  check_size(digest, here + bytes.size());
  File file(state_->partial(digest), O_WRONLY | O_CREAT);
  try {
    file.write_at(bytes, here);
  } catch (const Error&) {
    file.truncate(here);  // a full disk leaves no half of a piece
    throw;
  }
  return here + bytes.size();
}

void BlobStore::finish(const Digest& digest) {
  const auto mutex = state_->mutex_of(digest);
  const std::lock_guard lock(*mutex);
  const fs::path partial = state_->partial(digest);
  std::error_code ignored;
  if (renew(digest)) {
    fs::remove(partial, ignored);
    return;
  }
  File file(partial, O_RDWR | O_CREAT);  // an empty blob has no partial file
  const Digest found = digest_of_file(partial);
  if (found != digest) {
    fs::remove(partial, ignored);
    wrong_digest(digest, found);
  }
  fs::last_write_time(partial, fs::file_time_type::clock::now(), ignored);  // whole as of now
  if (state_->durable) file.sync();
  state_->give_name(partial, digest);
}

void BlobStore::remove_partials(std::int64_t older_than_seconds) {
  const auto limit = fs::file_time_type::clock::now() - std::chrono::seconds(older_than_seconds);
  for (const char* part : {"partial", "tmp"})
    for (const fs::directory_entry& entry : fs::directory_iterator(state_->folder / part)) {
      std::error_code error;
      const auto touched = entry.last_write_time(error);
      if (!error && touched <= limit) fs::remove(entry.path(), error);
    }
}

Digest BlobStore::put(std::span<const std::byte> bytes) {
  const Digest digest = digest_of(bytes);
  if (renew(digest)) return digest;
  Writer out = writer(digest);
  out.write(bytes);
  out.commit();
  return digest;
}

// ---- a blob in one go ----
struct BlobStore::Writer::State {
  BlobStore::State& store;
  Digest digest;
  fs::path name;
  File file;
  Sha256 hash;
  std::uint64_t size = 0;
  bool done = false;
};

BlobStore::Writer::Writer(std::unique_ptr<State> state) : state_(std::move(state)) {}
BlobStore::Writer::Writer(Writer&&) noexcept = default;
BlobStore::Writer::~Writer() {
  if (!state_ || state_->done) return;
  std::error_code ignored;
  fs::remove(state_->name, ignored);
}

BlobStore::Writer BlobStore::writer(const Digest& digest) {
  fs::path name = state_->folder / "tmp" / fmt::format("{}.{}", digest.hex(), random_hex(8));
  File file(name, O_WRONLY | O_CREAT | O_EXCL);
  return Writer(std::make_unique<Writer::State>(Writer::State{.store = *state_,
                                                              .digest = digest,
                                                              .name = std::move(name),
                                                              .file = std::move(file),
                                                              .hash = {}}));
}

void BlobStore::Writer::write(std::span<const std::byte> bytes) {
  check_size(state_->digest, bytes.size());
  check_size(state_->digest, state_->size + bytes.size());
  state_->file.write_at(bytes, state_->size);
  state_->hash.update(bytes);
  state_->size += bytes.size();
}

std::uint64_t BlobStore::Writer::size() const { return state_->size; }

void BlobStore::Writer::commit() {
  const Digest found = state_->hash.finish();
  if (found != state_->digest) wrong_digest(state_->digest, found);
  if (state_->store.durable) state_->file.sync();
  state_->store.give_name(state_->name, state_->digest);
  state_->done = true;
}

}  // namespace tessera::assets
