#include "server/store/checkpoint_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <cstring>
#include <string_view>

#include "common/base/crc32c.hpp"
#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/log.hpp"
#include "server/store/damaged.hpp"

namespace tessera::server {

namespace {

static_assert(std::endian::native == std::endian::little);
constexpr std::string_view extension = ".checkpoint";
constexpr std::string_view magic = "TSRACKPT";
constexpr std::uint32_t version = 1;
constexpr std::size_t header_size = 32;
constexpr std::size_t record_head = 16;
/// A tile of 512 by 512 has 28 MiB.
constexpr std::uint64_t record_most = 64 * limits::MiB;

std::array<std::byte, header_size> header_of(JobId job, std::int32_t frame) {
  std::array<std::byte, header_size> header{};
  std::memcpy(header.data(), magic.data(), magic.size());
  std::memcpy(header.data() + 8, &version, sizeof version);
  std::memcpy(header.data() + 12, &frame, sizeof frame);
  std::memcpy(header.data() + 16, &job, sizeof job);
  return header;
}

template <class T>
void put(std::span<std::byte> bytes, std::size_t at, const T& value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

std::uint32_t word(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

}  // namespace

// ---- writing ----

CheckpointWriter::CheckpointWriter(Disk& disk, const std::filesystem::path& file, bool durable,
                                   std::atomic<std::uint64_t>& bytes, const Checkpoint& empty)
    : disk_(disk), durable_(durable), made_(empty), file_(disk.create(file)), bytes_(bytes) {
  try {
    file_->write_at(header_of(made_.job, made_.frame), 0);
  } catch (...) {
    discard();
    throw;
  }
  made_.bytes = header_size;
}

CheckpointWriter::~CheckpointWriter() {
  if (!finished_) discard();
}

void CheckpointWriter::discard() noexcept {
  try {
    disk_.remove(file_->path());
  } catch (const std::exception& error) {
    log::warn("{}", error.what());  // the next start removes it
    count_what_stays();
  }
}

void CheckpointWriter::count_what_stays() noexcept {
  try {
    bytes_ += disk_.open(file_->path())->size();
  } catch (const std::exception& error) {
    log::debug("{}", error.what());  // it is gone, or nothing can be read any more
  }
}

void CheckpointWriter::append(std::uint32_t tile, std::uint32_t passes,
                              std::span<const std::byte> content) {
  assert(made_.tiles.empty() || made_.tiles.back().tile < tile);
  std::array<std::byte, record_head> head{};
  put(head, 0, static_cast<std::uint32_t>(content.size()));
  put(head, 8, tile);
  put(head, 12, passes);
  put(head, 4, crc32c(content, crc32c(std::span<const std::byte>(head).subspan(8))));
  std::vector<iovec> pieces{{head.data(), head.size()},
                            {const_cast<std::byte*>(content.data()), content.size()}};
  file_->write_at(pieces, made_.bytes);
  made_.tiles.push_back({tile, passes, made_.bytes, head.size() + content.size()});
  made_.bytes += made_.tiles.back().length;
}

Checkpoint CheckpointWriter::finish() {
  if (durable_) {
    file_->sync();
    disk_.sync_folder(file_->path().parent_path());
  }
  finished_ = true;
  bytes_ += made_.bytes;
  return made_;
}

// ---- the folder ----

CheckpointFiles::CheckpointFiles(Disk& disk, std::filesystem::path folder, bool durable)
    : disk_(disk), folder_(std::move(folder)), durable_(durable) {
  for (const std::uint64_t number : numbers()) {
    last_ = std::max(last_.load(), number);
    Found& found = found_[number];
    try {
      found.bytes = size_of(number);
      bytes_ += found.bytes;
    } catch (const Error& error) {
      found.unseen = error.what();
    }
  }
}

std::unique_ptr<CheckpointWriter> CheckpointFiles::begin(JobId job, std::int32_t frame) {
  const std::uint64_t number = ++last_;
  Checkpoint empty;
  empty.job = job;
  empty.frame = frame;
  empty.number = number;
  return std::make_unique<CheckpointWriter>(disk_, path_of(number), durable_, bytes_, empty);
}

std::vector<std::byte> CheckpointFiles::read(const CheckpointPlace& place) const {
  const auto file = open_named(disk_, path_of(place.number));
  const auto fail = [&](const char* what) {
    throw DamagedError(fmt::format("{} at {}: {}", file->path().string(), place.offset, what));
  };
  if (place.length < record_head || place.length > record_most ||
      place.offset + place.length > file->size())
    fail("the checkpoint has no such record");
  std::array<std::byte, header_size> header{};
  file->read_at(header, 0);
  if (std::memcmp(header.data(), magic.data(), magic.size()) != 0 || word(header, 8) != version)
    fail("this is no checkpoint of this version");
  std::vector<std::byte> record(place.length);
  file->read_at(record, place.offset);
  const std::span<const std::byte> all(record);
  if (word(all, 0) != place.length - record_head)
    fail("the checkpoint's record has another length than the index says");
  if (word(all, 4) != crc32c(all.subspan(8))) fail("the checkpoint is damaged: its CRC differs");
  record.erase(record.begin(), record.begin() + record_head);
  return record;
}

std::set<std::uint64_t> CheckpointFiles::numbers() const {
  return numbered_files(disk_, folder_, extension);
}

std::uint64_t CheckpointFiles::size_of(std::uint64_t number) const {
  try {
    return disk_.size_of(path_of(number));
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::not_found) throw;
    return 0;
  }
}

std::filesystem::path CheckpointFiles::path_of(std::uint64_t number) const {
  return folder_ / fmt::format("{:08}{}", number, extension);
}

void CheckpointFiles::remove(std::uint64_t number) {
  std::uint64_t size = 0;
  try {
    size = size_of(number);
    disk_.remove(path_of(number));
    bytes_ -= size;
  } catch (const Error& error) {
    log::warn("{}", error.what());  // the next start removes it, unless it is gone all the same
    if (is_gone(number)) bytes_ -= size;
  }
}

bool CheckpointFiles::is_gone(std::uint64_t number) const noexcept {
  try {
    return !numbers().contains(number);
  } catch (const std::exception&) {
    return false;  // nothing can be read any more
  }
}

}  // namespace tessera::server
