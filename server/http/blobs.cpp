#include "common/assets/blob_store.hpp"

#include <fmt/format.h>

#include <charconv>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "server/http/blob_parts.hpp"
#include "server/http/handlers.hpp"

namespace tessera::server {

namespace {

struct ByteRange {
  std::uint64_t first = 0;
  std::uint64_t length = 0;
};

std::optional<std::uint64_t> number_of(std::string_view text) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// RFC 9110, 14.1.2, one range of bytes. Nothing if it is not understood (the whole is sent then);
/// a length of 0 if nothing of it lies within `size`.
std::optional<ByteRange> range_of(std::string_view field, std::uint64_t size) {
  if (field.substr(0, 6) != "bytes=") return std::nullopt;
  field.remove_prefix(6);
  const std::size_t dash = field.find('-');
  if (dash == std::string_view::npos) return std::nullopt;
  const std::string_view last_text = field.substr(dash + 1);
  const auto last = number_of(last_text);
  if (dash == 0) {
    if (!last) return std::nullopt;
    const std::uint64_t length = std::min(*last, size);
    return ByteRange{size - length, length};
  }
  const auto first = number_of(field.substr(0, dash));
  if (!first || (!last && !last_text.empty()) || (last && *last < *first)) return std::nullopt;
  if (*first >= size) return ByteRange{0, 0};
  return ByteRange{*first, std::min(last.value_or(size - 1), size - 1) - *first + 1};
}

HttpFields blob_fields(const std::string& etag) {
  return {{"Content-Type", "application/octet-stream"},
          {"ETag", etag},
          {"Accept-Ranges", "bytes"},
          {"Cache-Control", "public, max-age=31536000, immutable"}};
}

/// What is here counts as used: whoever asks is about to name it in a job.
Json lacking(assets::BlobStore& blobs, const std::vector<Digest>& digests) {
  blobs.touch(digests);
  Json missing = Json::array();
  for (const Digest& digest : blobs.missing(digests)) missing.push_back(digest.hex());
  return missing;
}

}  // namespace

Digest blob_digest(const Call& call) {
  const auto digest = Digest::from_hex(call.values.front());
  if (!digest)
    throw Error(ErrorKind::bad_input, "expected a SHA-256 as 64 hexadecimal digits",
                {.key = "sha256"});
  return *digest;
}

boost::asio::awaitable<BlobState> blob_state(ApiContext& api, const Digest& digest) {
  const std::function<BlobState()> look = [&blobs = api.blobs, digest] {
    const auto size = blobs.size(digest);
    return BlobState{size, size ? 0 : blobs.partial_size(digest)};
  };
  co_return co_await on_files<BlobState>(api, look);
}

HandlerResult blobs_missing(Call& call) {
  const Json body = co_await json_body(call);
  ObjectReader in(body, "");
  const Json& list = in.required("digests");
  in.finish();
  if (!list.is_array() || list.size() > limits::bundle_files)
    in.fail("digests",
            fmt::format("expected an array of at most {} digests", limits::bundle_files));
  std::vector<Digest> digests;
  digests.reserve(list.size());
  for (const Json& one : list) {
    const auto digest =
        one.is_string() ? Digest::from_hex(one.get_ref<const std::string&>()) : std::nullopt;
    if (!digest)
      in.fail(fmt::format("digests[{}]", digests.size()),
              "expected a SHA-256 as 64 hexadecimal digits");
    digests.push_back(*digest);
  }
  const std::function<Json()> look = [&blobs = call.api.blobs, &digests] {
    return lacking(blobs, digests);
  };
  Json answer = Json::object();
  answer["missing"] = co_await on_files<Json>(call.api, look);
  co_return json_response(answer);
}

HandlerResult head_blob(Call& call) {
  const Digest digest = blob_digest(call);
  const BlobState state = co_await blob_state(call.api, digest);
  HttpResponse response;
  if (!state.size) {
    response = problem(404, "this blob is not here");
    response.fields.emplace_back("Upload-Offset", std::to_string(state.partial));
    co_return response;
  }
  response.fields = blob_fields("\"" + digest.hex() + "\"");
  response.body = FileSlice{call.api.blobs.path(digest), 0, *state.size};
  co_return response;
}

HandlerResult get_blob(Call& call) {
  const Digest digest = blob_digest(call);
  const BlobState state = co_await blob_state(call.api, digest);
  if (!state.size) throw Error(ErrorKind::not_found, "this blob is not here", {.key = "sha256"});
  const std::string etag = "\"" + digest.hex() + "\"";
  HttpResponse response;
  response.fields = blob_fields(etag);
  if (none_match_names(call.request, etag)) {
    response.status = 304;
    co_return response;
  }
  FileSlice slice{call.api.blobs.path(digest), 0, *state.size};
  if (const auto asked = call.request.field("range")) {
    if (const auto range = range_of(*asked, slice.length)) {
      if (range->length == 0) {
        response = problem(416, fmt::format("the blob has {} bytes", slice.length));
        response.fields.emplace_back("Content-Range", fmt::format("bytes */{}", slice.length));
        co_return response;
      }
      response.status = 206;
      response.fields.emplace_back("Content-Range",
                                   fmt::format("bytes {}-{}/{}", range->first,
                                               range->first + range->length - 1, slice.length));
      slice.offset = range->first;
      slice.length = range->length;
    }
  }
  response.body = std::move(slice);
  co_return response;
}

}  // namespace tessera::server
