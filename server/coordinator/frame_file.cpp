#include "server/coordinator/frame_file.hpp"

#include <fmt/format.h>

#include <charconv>
#include <system_error>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "common/image/picture.hpp"
#include "server/store/whole_file.hpp"

namespace tessera::server {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view prefix = "frame-";
constexpr std::string_view suffix = ".exr";

/// Bytes straight to a file.
class FileSink : public image::ByteSink {
 public:
  explicit FileSink(DiskFile& file) : file_(file) {}
  void append(std::span<const std::byte> bytes) override {
    file_.write_at(bytes, end_);
    end_ += bytes.size();
  }
  void replace(std::size_t offset, std::span<const std::byte> bytes) override {
    file_.write_at(bytes, offset);
  }

 private:
  DiskFile& file_;
  std::uint64_t end_ = 0;
};

void remove_leftover(Disk& disk, const fs::path& file) {
  try {
    disk.remove(file);
  } catch (const Error& error) {
    log::warn("{}", error.what());
  }
}

}  // namespace

fs::path job_folder(const fs::path& data, JobId job) { return data / "jobs" / std::to_string(job); }

fs::path frame_path(const fs::path& data, JobId job, std::int32_t frame) {
  return job_folder(data, job) / fmt::format("{}{:04}{}", prefix, frame, suffix);
}

std::set<std::int32_t> frames_on_disk(const fs::path& data, JobId job, Disk& disk) {
  std::set<std::int32_t> frames;
  const fs::path folder = job_folder(data, job);
  std::vector<std::string> names;
  try {
    names = disk.names(folder);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::not_found) throw;
  }
  for (const std::string& name : names) {
    if (name.ends_with(part_suffix)) remove_leftover(disk, folder / name);
    if (!name.starts_with(prefix) || !name.ends_with(suffix)) continue;
    std::int32_t frame = 0;
    const char* const last = name.data() + name.size() - suffix.size();
    const auto [end, error] = std::from_chars(name.data() + prefix.size(), last, frame);
    if (error == std::errc() && end == last) frames.insert(frame);
  }
  return frames;
}

void settle_frames(const fs::path& data, JobId job, Disk& disk) {
  if (frames_on_disk(data, job, disk).empty()) return;
  const fs::path folder = job_folder(data, job);
  for (const fs::path& each : {folder, folder.parent_path(), data}) disk.sync_folder(each);
}

void write_whole(const fs::path& file, bool durable, const WriteContent& write) {
  write_whole(*system_disk(), file, durable, [&](DiskFile& out) {
    FileSink sink(out);
    write(sink);
  });
}

void write_frame_exr(const fs::path& file, bool durable, const FilmSnapshot& film,
                     const image::Metadata& metadata) {
  write_whole(file, durable,
              [&](image::ByteSink& sink) { image::write_exr(FilmRows(film), metadata, sink); });
}

std::vector<std::byte> encode_frame_exr(const FilmSnapshot& film, const image::Metadata& metadata) {
  return image::encode_exr(FilmRows(film), metadata);
}

std::vector<std::byte> encode_frame_png(const FilmSnapshot& film, double exposure_stops) {
  const Rect& window = film.grid.window();
  return image::encode_png(window.width, window.height, resolve_rgba(film), exposure_stops);
}

std::int64_t samples_of_file(const fs::path& file) {
  try {
    const image::Metadata header = image::read_exr_header(file);
    const auto* samples = header.find("tessera.samples");
    const auto* whole = samples != nullptr ? std::get_if<std::int32_t>(samples) : nullptr;
    return whole != nullptr ? *whole : 0;
  } catch (const Error&) {
    return 0;
  }
}

void require_kept(const fs::path& file) {
  std::error_code unreadable;
  if (!fs::exists(file, unreadable))
    throw Error(ErrorKind::failed, "the finished picture was written and is no longer there",
                {.file = file.string()});
}

std::vector<std::byte> png_of_file(const fs::path& file, double exposure_stops) {
  const image::ExrImage exr = image::read_exr_file(file);
  std::vector<float> rgb;
  rgb.reserve(3 * exr.plane("R").size());
  for (const char* name : {"R", "G", "B"})
    rgb.insert(rgb.end(), exr.plane(name).begin(), exr.plane(name).end());
  return image::encode_png(exr.width, exr.height, rgb, exposure_stops);
}

FilmSnapshot film_of_file(const fs::path& file, const TileGrid& grid, std::uint64_t version) {
  const image::ExrImage exr = image::read_exr_file(file);
  const Rect& all = grid.window();
  if (exr.width != all.width || exr.height != all.height)
    throw Error(ErrorKind::failed, "is not of the film's size", {.file = file.string()});
  FilmSnapshot film{grid, version, {}, std::vector<std::uint64_t>(grid.count(), version)};
  const std::array<std::span<const float>, 4> planes{exr.plane("R"), exr.plane("G"), exr.plane("B"),
                                                     exr.plane("A")};
  for (std::uint32_t index = 0; index < grid.count(); ++index) {
    auto tile = std::make_shared<FilmTile>(empty_film_tile(grid.tile(index)));
    tile->passes = 1;
    tile->samples = {1, 0};  // so that the sums are the means themselves
    const Rect& window = tile->window;
    for (std::size_t c = 0; c < planes.size(); ++c) {
      double* out = tile->sums.data() + c * tile->pixels();
      for (int y = window.y; y < window.y + window.height; ++y)
        for (int x = window.x; x < window.x + window.width; ++x)
          *out++ = static_cast<double>(
              planes[c][static_cast<std::size_t>(y - all.y) * static_cast<std::size_t>(exr.width) +
                        static_cast<std::size_t>(x - all.x)]);
    }
    film.tiles.push_back(std::move(tile));
  }
  return film;
}

}  // namespace tessera::server
