#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <set>
#include <vector>

#include "common/image/metadata.hpp"
#include "common/image/picture.hpp"
#include "common/job/job_spec.hpp"
#include "server/film/film.hpp"
#include "server/store/disk.hpp"

/// Final pictures on disk: DATA/jobs/ID/frame-####.exr. Everything here blocks: it is called from
/// the pool, or at the start.
namespace tessera::server {

std::filesystem::path job_folder(const std::filesystem::path& data, JobId job);
std::filesystem::path frame_path(const std::filesystem::path& data, JobId job, std::int32_t frame);
/// The samples that the picture's job had, as the file says; 0 if it does not.
std::int64_t samples_of_file(const std::filesystem::path& file);
/// The frames that have a file. Temporary files of a killed coordinator are removed.
std::set<std::int32_t> frames_on_disk(const std::filesystem::path& data, JobId job,
                                      Disk& disk = *system_disk());

/// Makes their names certain: a killed coordinator may have given a file its name without a sync.
/// To be called before anything is let go because the files are there.
void settle_frames(const std::filesystem::path& data, JobId job, Disk& disk = *system_disk());

using WriteContent = std::function<void(image::ByteSink&)>;
/// server/store/whole_file.hpp says what it promises.
void write_whole(const std::filesystem::path& file, bool durable, const WriteContent& write);

/// Throws Error (failed, with the place) if a file that was written is there no more: whoever asks
/// for its picture did not name something that never was.
void require_kept(const std::filesystem::path& file);

/// The film's final picture.
void write_frame_exr(const std::filesystem::path& file, bool durable, const FilmSnapshot& film,
                     const image::Metadata& metadata);
std::vector<std::byte> encode_frame_exr(const FilmSnapshot& film, const image::Metadata& metadata);
std::vector<std::byte> encode_frame_png(const FilmSnapshot& film, double exposure_stops);
std::vector<std::byte> png_of_file(const std::filesystem::path& file, double exposure_stops);
/// The file's picture as a film whose every tile changed at `version`: R, G, B, A alone.
FilmSnapshot film_of_file(const std::filesystem::path& file, const TileGrid& grid,
                          std::uint64_t version);

}  // namespace tessera::server
