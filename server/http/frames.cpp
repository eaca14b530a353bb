#include <fmt/format.h>

#include <charconv>
#include <cmath>

#include "common/base/error.hpp"
#include "server/http/handlers.hpp"

namespace tessera::server {

namespace {

template <class Number>
std::optional<Number> number_of(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

struct FrameOfJob {
  JobStatus status;
  std::int32_t frame = 0;
  std::string etag;
};

/// Versions count within one film; the epoch keeps those of before a start apart.
std::string etag_of(const ApiContext& api, std::uint64_t version) {
  return fmt::format("\"{}-{}\"", api.coordinator.epoch(), version);
}

/// The frames as people write them, cut where that is long.
std::string excerpt_of(const FrameList& frames) {
  constexpr std::size_t most = 200;
  std::string text = text_of(frames);
  if (text.size() > most) text = text.substr(0, text.rfind(',', most)) + ",…";
  return text;
}

FrameOfJob frame_of(const Call& call) {
  FrameOfJob out{job_of(call), 0, {}};
  const FrameList& frames = out.status.plan->spec.frames;
  const auto frame = number_of<std::int32_t>(call.values[1]);
  const auto version = frame && frames.contains(*frame)
                           ? call.api.coordinator.version(out.status.view.id, *frame)
                           : std::nullopt;
  if (!version)
    throw Error(ErrorKind::not_found,
                fmt::format("job {} has no frame \"{}\": it has {}", out.status.view.id,
                            call.values[1].substr(0, 64), excerpt_of(frames)),
                {.key = "frame"});
  out.frame = *frame;
  out.etag = etag_of(call.api, *version);
  return out;
}

HttpResponse not_modified(const std::string& etag) {
  HttpResponse response;
  response.status = 304;
  response.fields = {{"ETag", etag}, {"Cache-Control", "no-cache"}};
  return response;
}

HttpResponse picture_response(const Call& call, Picture picture, std::string_view type) {
  HttpResponse response;
  response.fields = {{"Content-Type", std::string(type)},
                     {"ETag", etag_of(call.api, picture.version)},
                     {"Cache-Control", "no-cache"},
                     {"Tessera-Version", std::to_string(picture.version)}};
  response.body = std::move(picture.bytes);
  return response;
}

/// A name for people who save the picture: letters, digits and "-._" of the job's name, and the
/// frame.
std::string file_name(const FrameOfJob& asked, std::string_view suffix) {
  std::string name = asked.status.plan->spec.name;
  for (char& c : name) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
                       c == '-' || c == '.';
    if (!plain) c = '_';
  }
  return fmt::format("inline; filename=\"{}.{:04}.{}\"", name, asked.frame, suffix);
}

}  // namespace

HandlerResult frame_exr(Call& call) {
  const FrameOfJob asked = frame_of(call);
  if (none_match_names(call.request, asked.etag)) co_return not_modified(asked.etag);
  Picture picture = co_await call.api.coordinator.exr(asked.status.view.id, asked.frame);
  HttpResponse response = picture_response(call, std::move(picture), "image/x-exr");
  response.fields.emplace_back("Content-Disposition", file_name(asked, "exr"));
  co_return response;
}

HandlerResult frame_png(Call& call) {
  const FrameOfJob asked = frame_of(call);
  const std::string_view text = call.target.parameter("exposure").value_or("0");
  const auto stops = number_of<double>(text);
  if (!stops || !(std::abs(*stops) <= 64))
    throw Error(ErrorKind::bad_input, "expected a number of stops from -64 to 64",
                {.key = "exposure"});
  if (none_match_names(call.request, asked.etag)) co_return not_modified(asked.etag);
  Picture picture = co_await call.api.coordinator.png(asked.status.view.id, asked.frame, *stops);
  HttpResponse response = picture_response(call, std::move(picture), "image/png");
  response.fields.emplace_back("Content-Disposition", file_name(asked, "png"));
  co_return response;
}

HandlerResult frame_tiles(Call& call) {
  const FrameOfJob asked = frame_of(call);
  const auto since = number_of<std::uint64_t>(call.target.parameter("since").value_or("0"));
  if (!since)
    throw Error(ErrorKind::bad_input, "expected a version: a whole number, at least 0",
                {.key = "since"});
  if (none_match_names(call.request, asked.etag)) co_return not_modified(asked.etag);
  Picture picture = co_await call.api.coordinator.tiles(asked.status.view.id, asked.frame, *since);
  co_return picture_response(call, std::move(picture), "application/octet-stream");
}

}  // namespace tessera::server
