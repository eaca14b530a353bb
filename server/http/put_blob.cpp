#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "common/assets/blob_store.hpp"
#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "server/coordinator/coordinator.hpp"
#include "server/http/blob_parts.hpp"
#include "server/http/handlers.hpp"

namespace tessera::server {

namespace {

constexpr std::size_t piece_bytes = 128 * limits::KiB;

std::optional<std::uint64_t> number_field(const HttpRequest& request, std::string_view name) {
  const auto text = request.field(name);
  if (!text) return std::nullopt;
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
  if (error != std::errc() || end != text->data() + text->size())
    throw Error(ErrorKind::bad_input, "expected a whole number of bytes",
                {.key = std::string(name)});
  if (value > limits::blob_bytes)
    throw Error(ErrorKind::too_large,
                fmt::format("a blob has at most {} bytes", limits::blob_bytes),
                {.key = std::string(name)});
  return value;
}

/// What came of one piece. `kept`: bytes of the partial file now. Not `fits`: the piece would leave
/// a gap.
struct Appended {
  std::uint64_t kept = 0;
  bool fits = true;
};

/// Adds what the partial file does not have yet of the bytes at `position`. Others may be sending
/// the same blob: what they have brought meanwhile is skipped, and the digest at the end judges all
/// of it.
Appended append_piece(assets::BlobStore& blobs, const Digest& digest, std::uint64_t position,
                      std::span<const std::byte> bytes) {
  for (int attempt = 0;; ++attempt) {
    const std::uint64_t kept = blobs.partial_size(digest);
    if (position > kept) return {kept, false};
    const std::uint64_t known = kept - position;
    if (known >= bytes.size() && !(bytes.empty() && kept == 0)) return {kept, true};
    try {
      return {blobs.append(digest, kept, bytes.subspan(static_cast<std::size_t>(known))), true};
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::conflict || attempt == 8) throw;
    }
  }
}

HttpResponse stored(unsigned status, const Digest& digest, std::uint64_t size) {
  HttpResponse response = json_response({{"sha256", digest.hex()}, {"size", size}}, status);
  if (status == 201) response.fields.emplace_back("Location", "/v1/blobs/" + digest.hex());
  return response;
}

HttpResponse at_offset(HttpResponse response, std::uint64_t offset) {
  response.fields.emplace_back("Upload-Offset", std::to_string(offset));
  return response;
}

HttpResponse kept_part(const Digest& digest, std::uint64_t received) {
  return at_offset(json_response({{"sha256", digest.hex()}, {"received", received}}, 202),
                   received);
}

/// How an upload ended: which answer it gets.
struct Upload {
  std::uint64_t position = 0;  ///< after the last byte of the body
  std::optional<std::uint64_t> gap_at;
};

/// What is coming must leave the jobs that are here their reserve.
void refuse_beyond_room(const Call& call, std::uint64_t coming) {
  if (const std::string reason = call.api.coordinator.lacks_room(coming); !reason.empty())
    throw Error(ErrorKind::no_room, reason);
}

boost::asio::awaitable<Upload> receive(Call& call, const Digest& digest, std::uint64_t offset,
                                       std::uint64_t most) {
  Upload upload{offset, std::nullopt};
  std::vector<std::byte> buffer(piece_bytes);
  for (bool first = true;; first = false) {
    const std::size_t size =
        call.request.body == nullptr ? 0 : co_await call.request.body->read(buffer);
    if (size == 0 && !first) break;
    call.api.counters.blob_bytes_received += size;
    if (size > most - upload.position)
      throw Error(ErrorKind::too_large,
                  fmt::format("the body goes beyond the {} bytes that the blob may have", most));
    refuse_beyond_room(call, size);
    const std::span<const std::byte> piece = std::span(buffer).first(size);
    const std::function<Appended()> work = [&blobs = call.api.blobs, digest, at = upload.position,
                                            piece] {
      return append_piece(blobs, digest, at, piece);
    };
    const Appended appended = co_await on_files<Appended>(call.api, work);
    if (!appended.fits) {
      upload.gap_at = appended.kept;
      break;
    }
    upload.position += size;
    if (size == 0) break;
  }
  co_return upload;
}

/// An empty text if the blob now stands under its name, else why not.
std::string finished(assets::BlobStore& blobs, const Digest& digest) {
  try {
    blobs.finish(digest);
    return {};
  } catch (const Error& error) {
    if (blobs.has(digest)) return {};  // another who sent the same blob was the one to finish it
    if (error.kind() != ErrorKind::bad_input) throw;
    return error.message();
  }
}

}  // namespace

HandlerResult put_blob(Call& call) {
  const Digest digest = blob_digest(call);
  const std::uint64_t offset = number_field(call.request, "upload-offset").value_or(0);
  const auto total = number_field(call.request, "upload-length");
  const auto coming = call.request.body == nullptr ? 0 : call.request.body->length().value_or(0);
  const std::uint64_t most = total.value_or(limits::blob_bytes);
  if (offset > most || coming > most - offset)
    throw Error(ErrorKind::too_large,
                fmt::format("{} bytes at {} go beyond the {} bytes that the blob may have", coming,
                            offset, most));

  // Also what is here already is as good as new: a job that names it may be about to come.
  const std::function<BlobState()> renew = [&blobs = call.api.blobs, digest] {
    return BlobState{blobs.renew(digest), 0};
  };
  BlobState before = co_await on_files<BlobState>(call.api, renew);
  if (before.size) co_return stored(200, digest, *before.size);
  refuse_beyond_room(call, total ? *total - offset : coming);
  const Upload upload = co_await receive(call, digest, offset, most);
  if (upload.gap_at) {
    before = co_await blob_state(call.api, digest);
    if (before.size) co_return stored(200, digest, *before.size);
    const std::string detail =
        fmt::format("{} bytes of this blob are kept, and the body begins at {}", *upload.gap_at,
                    upload.position);
    co_return at_offset(problem(409, detail), *upload.gap_at);
  }
  if (total && upload.position < *total) co_return kept_part(digest, upload.position);
  const std::function<std::string()> finish = [&blobs = call.api.blobs, digest] {
    return finished(blobs, digest);
  };
  const std::string refusal = co_await on_files<std::string>(call.api, finish);
  if (!refusal.empty()) co_return at_offset(problem(422, refusal), 0);
  co_return stored(201, digest, upload.position);
}

}  // namespace tessera::server
