#include "server/store/journal.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstring>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/log.hpp"
#include "server/store/damaged.hpp"
#include "server/store/journal_record.hpp"

namespace tessera::server {
namespace {

constexpr std::string_view extension = ".segment";
constexpr std::string_view magic = "TSRAJRNL";
constexpr std::uint32_t version = 1;
constexpr std::size_t header_size = 16;
/// Where the file system cannot bypass its page cache, what was appended last stays in it. Of the
/// rest nobody reads before a restart: dropped, its memory takes the next results, at a fraction of
/// the cost of memory that the system has to find anew.
constexpr std::uint64_t kept_in_memory = 16 * limits::MiB;
constexpr std::size_t record_most = limits::wire_body + 4 * limits::KiB;

std::array<std::byte, header_size> segment_header() {
  std::array<std::byte, header_size> header{};
  std::memcpy(header.data(), magic.data(), magic.size());
  std::memcpy(header.data() + magic.size(), &version, sizeof version);
  return header;
}

}  // namespace

Journal::Journal(Disk& disk, std::filesystem::path folder, bool durable,
                 std::uint64_t segment_bytes)
    : disk_(disk), folder_(std::move(folder)), durable_(durable), segment_bytes_(segment_bytes) {
  const auto present = segments();
  if (!present.empty()) number_ = *present.rbegin();
  recount();
}

/// After a failure only the disk knows what there is.
void Journal::recount() {
  std::uint64_t bytes = 0;
  try {
    for (const std::uint64_t segment : segments()) bytes += size_of(segment);
  } catch (const Error& error) {
    log::warn("{}; the journal's size is not known", error.what());
    return;
  }
  bytes_ = bytes;
}

void Journal::seal() {
  file_.reset();
  recount();
}

std::filesystem::path Journal::path_of(std::uint64_t segment) const {
  return folder_ / fmt::format("{:08}{}", segment, extension);
}

std::set<std::uint64_t> Journal::segments() const {
  return numbered_files(disk_, folder_, extension);
}

std::uint64_t Journal::size_of(std::uint64_t segment) const {
  return disk_.open(path_of(segment))->size();
}

void Journal::begin_segment() {
  if (file_ && durable_) file_->drop_cached(cached_, end_);
  file_.reset();
  ++number_;
  std::uint64_t end = 0;
  try {
    auto fresh = disk_.create(path_of(number_));
    blocks_.start(*fresh, 0);
    blocks_.add(segment_header());
    end = blocks_.finish();
    if (durable_) {
      fresh->sync();
      disk_.sync_folder(folder_);
    }
    file_ = std::move(fresh);
  } catch (const Error&) {
    remove(number_);  // a full disk is not to be filled with beginnings
    recount();
    throw;
  }
  if (durable_) file_->bypass_cache();
  end_ = last_ = end;
  cached_ = 0;
  bytes_ += end;
}

std::vector<ResultPlace> Journal::append(std::span<const NewResult> batch) {
  if (!file_ || end_ >= segment_bytes_) begin_segment();
  std::vector<ResultPlace> places;
  places.reserve(batch.size());
  last_ = end_;
  std::uint64_t at = end_;
  try {
    blocks_.start(*file_, end_);
    for (const NewResult& result : batch) {
      const std::vector<std::byte> head = record_head(result.info, result.exr);
      blocks_.add(head);
      blocks_.add(result.exr);
      places.push_back({number_, at, head.size() + result.exr.size()});
      at += places.back().length;
    }
    at = blocks_.finish();
  } catch (const Error&) {
    undo();
    throw;
  }
  try {
    if (durable_) file_->sync();
  } catch (const Error&) {
    seal();  // which pages reached the disk cannot be known
    throw;
  }
  bytes_ += at - end_;
  end_ = at;
  drop_what_is_old();
  return places;
}

void Journal::drop_what_is_old() {
  if (!durable_ || end_ < cached_ + 2 * kept_in_memory) return;
  file_->drop_cached(cached_, end_ - kept_in_memory);
  cached_ = end_ - kept_in_memory;
}

void Journal::undo() {
  bytes_ -= end_ - last_;
  end_ = last_;
  try {
    file_->truncate(end_);
  } catch (const Error& error) {
    log::warn("{}; its bytes past {} are of no meaning", error.what(), end_);
    seal();
  }
}

StoredResult Journal::read(const ResultPlace& place) const {
  const auto file = open_named(disk_, path_of(place.segment));
  if (place.length < record_prefix || place.length > record_most ||
      place.offset + place.length > file->size()) {
    throw DamagedError(fmt::format("{} has no record of {} bytes at {}", file->path().string(),
                                   place.length, place.offset));
  }
  std::array<std::byte, header_size> header{};
  file->read_at(header, 0);
  if (header != segment_header())
    throw DamagedError(file->path().string() + " is no journal segment of this version");
  std::vector<std::byte> bytes(place.length);
  file->read_at(bytes, place.offset);
  try {
    return parse_record(bytes);
  } catch (const Error& error) {
    throw DamagedError(
        fmt::format("{} at {}: {}", file->path().string(), place.offset, error.message()));
  }
}

void Journal::remove(std::uint64_t segment) {
  if (file_ && segment == number_) return;
  try {
    const std::uint64_t size = size_of(segment);
    disk_.remove(path_of(segment));
    bytes_ -= size;
  } catch (const Error& error) {
    if (error.kind() == ErrorKind::not_found) return;
    log::warn("{}; the next start tries again", error.what());
    recount();
  }
}

}  // namespace tessera::server
