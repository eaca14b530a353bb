#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "common/base/build_info.hpp"
#include "common/base/error.hpp"
#include "common/base/files.hpp"
#include "server/coordinator/frame_file.hpp"
#include "server/coordinator/impl.hpp"

/// Pictures as bytes: from a frame's film while it is under way, from its file afterwards.
namespace tessera::server {

namespace {

using Bytes = std::vector<std::byte>;

/// A film that has no news for anyone.
FilmSnapshot unchanged(const TileGrid& grid, std::uint64_t version) {
  const std::size_t count = grid.count();
  return {grid, version, std::vector<std::shared_ptr<const FilmTile>>(count),
          std::vector<std::uint64_t>(count, version)};
}

}  // namespace

boost::asio::awaitable<Picture> CoordinatorImpl::exr(JobId id, std::int32_t frame) {
  return picture({PictureKey::Form::exr, id, frame, 0, 0});
}

boost::asio::awaitable<Picture> CoordinatorImpl::png(JobId id, std::int32_t frame,
                                                     double exposure_stops) {
  return picture({PictureKey::Form::png, id, frame, exposure_stops, 0});
}

boost::asio::awaitable<Picture> CoordinatorImpl::tiles(JobId id, std::int32_t frame,
                                                       std::uint64_t since) {
  return picture({PictureKey::Form::tiles, id, frame, 0, since});
}

std::optional<std::uint64_t> CoordinatorImpl::version(JobId id, std::int32_t frame) const {
  const Job* job = find(id);
  if (!job || !job->plan->spec.frames.contains(frame)) return std::nullopt;
  if (job->files.contains(frame)) return final_version(*job);
  const FrameFilm* film = films_.find(id, frame);
  return film ? film->version() : job->version_base;
}

std::optional<std::int64_t> CoordinatorImpl::samples(JobId id, std::int32_t frame) const {
  const Job* job = find(id);
  if (!job || !job->plan->spec.frames.contains(frame)) return std::nullopt;
  return job->samples_of(frame);
}

boost::asio::awaitable<Picture> CoordinatorImpl::picture(PictureKey key) {
  if (!std::isfinite(key.exposure))
    throw Error(ErrorKind::bad_input, "expected a finite number of stops", {.key = "exposure"});
  known(key.job);
  const auto at_least = version(key.job, key.frame);
  if (!at_least)
    throw Error(ErrorKind::not_found, fmt::format("job {} has no frame {}", key.job, key.frame));
  if (stopping_) throw Error(ErrorKind::failed, "the coordinator stops");
  PictureCache::Make make = [this, key](PictureCache::Done done) {
    crew_.start("a picture", make_picture(key, std::move(done)));
  };
  co_return co_await pictures_.get(key, *at_least, std::move(make));
}

boost::asio::awaitable<void> CoordinatorImpl::make_picture(PictureKey key,
                                                           PictureCache::Done done) {
  std::exception_ptr error;
  Picture picture;
  try {
    picture = co_await produce(key);
  } catch (const std::exception&) {
    error = std::current_exception();
  }
  done(error, std::move(picture));
}

boost::asio::awaitable<Picture> CoordinatorImpl::produce(PictureKey key) {
  const Job& job = known(key.job);
  const std::shared_ptr<const JobPlan> plan = job.plan;
  const bool is_exr = key.form == PictureKey::Form::exr;
  boost::asio::thread_pool& lane = is_exr ? files_ : previews_;
  std::function<Bytes()> encode;
  Picture picture;
  if (job.files.contains(key.frame)) {
    const std::filesystem::path file = frame_path(settings_.data, key.job, key.frame);
    picture.version = final_version(job);
    encode = [key, file, plan, version = picture.version] {
      require_kept(file);
      if (key.form == PictureKey::Form::exr)
        return read_file(file, std::numeric_limits<std::size_t>::max());
      if (key.form == PictureKey::Form::png) return png_of_file(file, key.exposure);
      if (key.since >= version)
        return encode_changed_tiles(unchanged(plan->grid, version), key.since);
      return encode_changed_tiles(film_of_file(file, plan->grid, version), key.since);
    };
  } else {
    const image::Metadata metadata = metadata_for(job, key.frame);
    FilmSnapshot film;
    if (films_.find(key.job, key.frame)) {
      film = co_await films_.snapshot(key.job, key.frame);
    } else if (job.owed) {
      throw Error(
          ErrorKind::unreachable,
          fmt::format("job {} has ended, and its picture of frame {} is not written yet{}{}",
                      key.job, key.frame, job.trouble.empty() ? "" : ": ", job.trouble));
    } else if (job.ended) {
      throw Error(ErrorKind::not_found,
                  fmt::format("job {} ended without a picture of frame {}", key.job, key.frame));
    } else {
      film =
          Film(plan->grid, job.version_base, image::layout_of(plan->spec.render.aovs)).snapshot();
    }
    picture.version = film.version;
    auto shared = std::make_shared<const FilmSnapshot>(std::move(film));
    encode = [key, shared, metadata] {
      if (key.form == PictureKey::Form::exr) return encode_frame_exr(*shared, metadata);
      if (key.form == PictureKey::Form::png) return encode_frame_png(*shared, key.exposure);
      return encode_changed_tiles(*shared, key.since);
    };
  }
  picture.bytes = std::make_shared<const Bytes>(co_await on<Bytes>(lane, encode));
  co_return picture;
}

image::Metadata CoordinatorImpl::metadata_for(const Job& job, std::int32_t frame) const {
  JobSpec spec = job.plan->spec;
  spec.render.samples = job.samples_of(frame);
  image::Metadata metadata = image::metadata_of(spec, frame);
  metadata.set("tessera.build", std::string(build_commit()));
  if (job.build) metadata.set("tessera.worker_build", job.build->hex());
  const JobStatus status = status_of(job);
  metadata.set("tessera.render_seconds", status.render_seconds);
  metadata.set("tessera.cpu_seconds", status.cpu_seconds);
  image::set_date(metadata, unix_millis_now());
  return metadata;
}

}  // namespace tessera::server
