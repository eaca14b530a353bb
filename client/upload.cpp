#include "client/upload.hpp"

#include <fmt/format.h>

#include <charconv>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/error.hpp"

namespace tessera::client {

namespace {

constexpr std::size_t digests_a_question = 10'000;  // well within what a JSON body may have
constexpr int attempts_most = 5;

std::set<Digest> missing(Server& server, const std::vector<Digest>& digests) {
  std::set<Digest> out;
  for (std::size_t first = 0; first < digests.size(); first += digests_a_question) {
    Json list = Json::array();
    const std::size_t last = std::min(first + digests_a_question, digests.size());
    for (std::size_t i = first; i < last; ++i) list.push_back(digests[i].hex());
    Json question = Json::object();
    question["digests"] = std::move(list);
    const Json answer = server.post("/v1/blobs/missing", question);
    ObjectReader in(answer, "");
    for (const Json& one : in.required("missing"))
      if (const auto digest =
              one.is_string() ? Digest::from_hex(one.get<std::string>()) : std::nullopt)
        out.insert(*digest);
  }
  return out;
}

std::string target_of(const Digest& digest) { return "/v1/blobs/" + digest.hex(); }

std::uint64_t offset_in(const net::HttpResponse& response) {
  const std::string text = response.header("Upload-Offset");
  std::uint64_t offset = 0;
  std::from_chars(text.data(), text.data() + text.size(), offset);
  return offset;
}

/// How much of a broken-off upload the server kept; nothing if it has the whole.
std::optional<std::uint64_t> kept(Server& server, const Digest& digest) {
  net::HttpRequest request;
  request.method = "HEAD";
  request.target = target_of(digest);
  request.errors_throw = false;
  const net::HttpResponse response = server.send(std::move(request));
  if (response.status == 200) return std::nullopt;
  if (response.status == 404) return offset_in(response);
  throw Error(
      response.status == 401 || response.status == 403 ? ErrorKind::refused : ErrorKind::failed,
      fmt::format("the server answers {} to a question for a blob", response.status));
}

/// `progress` is told how much of the file is there.
void send_file(Server& server, const Digest& digest, const std::filesystem::path& file,
               std::uint64_t size, const std::function<void(std::uint64_t)>& progress) {
  for (int attempt = 1;; ++attempt) {
    try {
      const auto offset = kept(server, digest);
      if (!offset) return;
      const std::uint64_t from = std::min(*offset, size);
      net::HttpRequest request;
      request.method = "PUT";
      request.target = target_of(digest);
      request.headers.emplace_back("Content-Type", "application/octet-stream");
      request.headers.emplace_back("Upload-Offset", std::to_string(from));
      request.headers.emplace_back("Upload-Length", std::to_string(size));
      request.file = net::FileRange{file, from, size - from,
                                    [&, from](std::uint64_t sent) { progress(from + sent); }};
      server.send(std::move(request));
      return;
    } catch (const Error& error) {
      const bool again =
          error.kind() == ErrorKind::unreachable || error.kind() == ErrorKind::conflict;
      if (!again || attempt == attempts_most) throw;
    }
    server.pause(std::chrono::milliseconds(200 << attempt),
                 std::chrono::milliseconds(200 << attempt));
  }
}

void send_text(Server& server, const Digest& digest, const std::string& text) {
  net::HttpRequest request;
  request.method = "PUT";
  request.target = target_of(digest);
  request.headers.emplace_back("Content-Type", "application/octet-stream");
  request.body = text;
  server.send(std::move(request));
}

}  // namespace

void upload(Server& server, const SceneAssets& scene, const UploadProgress& progress) {
  const std::string manifest = assets::canonical_json(scene.bundle);
  std::vector<Digest> digests = assets::digests_of(scene.bundle);
  digests.push_back(scene.digest);
  const std::set<Digest> lacking = missing(server, digests);

  std::map<Digest, const scene::UsedFile*>
      files;  // each digest once, in an order that does not change
  std::uint64_t total = 0, done = 0;
  for (const scene::UsedFile& used : scene.files) {
    const assets::BundleFile& entry = scene.bundle.files.at(used.path);
    if (lacking.contains(entry.digest) && files.emplace(entry.digest, &used).second)
      total += entry.size;
  }
  for (const auto& [digest, used] : files) {
    const std::uint64_t size = scene.bundle.files.at(used->path).size;
    progress(done, total);
    try {
      send_file(server, digest, used->file, size,
                [&](std::uint64_t there) { progress(done + there, total); });
    } catch (const Error& error) {
      if (error.kind() != ErrorKind::bad_input) throw;
      throw Error(ErrorKind::failed,
                  fmt::format("{}: the server refuses it ({}); was it changed meanwhile?",
                              used->file.string(), error.message()));
    }
    done += size;
  }
  if (!files.empty()) progress(done, total);
  if (lacking.contains(scene.digest)) send_text(server, scene.digest, manifest);
}

}  // namespace tessera::client
