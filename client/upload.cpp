#include "client/upload.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/awaitable.hpp>
#include <charconv>
#include <map>
#include <nlohmann/json.hpp>
#include <set>

#include "common/base/error.hpp"

namespace tessera::client {

namespace asio = boost::asio;

namespace {

constexpr std::size_t digests_a_question = 10'000;  // well within what a JSON body may have
constexpr std::size_t uploads_at_once = 4;
constexpr int attempts_most = 5;  // that bring nothing further, one after another
constexpr std::uint64_t worth_asking = 256 * limits::KiB;  // whether a part of it is kept

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

net::HttpRequest request_for(const char* method, const Digest& digest) {
  net::HttpRequest request;
  request.method = method;
  request.target = "/v1/blobs/" + digest.hex();
  return request;
}

std::uint64_t offset_in(const net::HttpResponse& response) {
  const std::string text = response.header("Upload-Offset");
  std::uint64_t offset = 0;
  std::from_chars(text.data(), text.data() + text.size(), offset);
  return offset;
}

/// One file that goes over.
struct Upload {
  Digest digest;
  std::filesystem::path file;
  std::uint64_t size = 0;
  std::uint64_t there = 0;  ///< bytes of it that the server has, as far as is known
};

net::HttpRequest put_from(const Upload& upload, std::uint64_t offset) {
  constexpr std::uint64_t hashed_a_second = 50'000'000;  // by a slow server, before it answers
  net::HttpRequest request = request_for("PUT", upload.digest);
  request.headers.emplace_back("Content-Type", "application/octet-stream");
  request.headers.emplace_back("Upload-Offset", std::to_string(offset));
  request.headers.emplace_back("Upload-Length", std::to_string(upload.size));
  request.time += std::chrono::seconds(upload.size / hashed_a_second);
  return request;
}

/// Files on their way to the server, several at once.
class Uploads {
 public:
  Uploads(std::vector<Upload> files, const UploadProgress& progress)
      : files_(std::move(files)), progress_(progress) {
    // The small ones last: they fill what room there is beside a large one's end.
    std::sort(files_.begin(), files_.end(), [](const Upload& a, const Upload& b) {
      return std::pair(b.size, a.digest) < std::pair(a.size, b.digest);
    });
    for (const Upload& file : files_) total_ += file.size;
  }

  void send(Server& server) {
    if (files_.empty()) return;
    report();
    server.concurrently(
        std::min(uploads_at_once, files_.size()),
        [this](net::HttpClients& all, net::HttpClient& client) { return send_some(all, client); });
    report();
  }

  [[nodiscard]] UploadSummary summary() const { return {.files = files_.size(), .bytes = sent_}; }

 private:
  asio::awaitable<void> send_some(net::HttpClients& all, net::HttpClient& client) {
    while (next_ < files_.size() && !all.cancelled()) {
      Upload& upload = files_[next_++];
      co_await send_whole(all, client, upload);
    }
  }

  asio::awaitable<void> send_whole(net::HttpClients& all, net::HttpClient& client, Upload& upload) {
    bool ask = upload.size >= worth_asking;
    for (int attempt = 1;; ++attempt) {
      const std::uint64_t before = upload.there;
      const std::exception_ptr trouble = co_await try_once(client, upload, ask);
      if (!trouble) co_return;
      if (upload.there > before) attempt = 1;
      ask = true;
      if (attempt == attempts_most) std::rethrow_exception(trouble);
      co_await all.pause(std::chrono::milliseconds(200 << attempt));
    }
  }

  /// Gives what went wrong where another attempt may bring more.
  asio::awaitable<std::exception_ptr> try_once(net::HttpClient& client, Upload& upload, bool ask) {
    try {
      std::optional<std::uint64_t> offset = 0;
      if (ask) offset = co_await kept(client, upload.digest);
      if (offset) co_await send_from(client, upload, std::min(*offset, upload.size));
      there(upload, upload.size);
      co_return nullptr;
    } catch (const Error& error) {
      if (error.kind() == ErrorKind::bad_input)
        throw Error(ErrorKind::failed,
                    fmt::format("{}: the server refuses it ({}); was it changed meanwhile?",
                                upload.file.string(), error.message()));
      if (error.kind() != ErrorKind::unreachable && error.kind() != ErrorKind::conflict) throw;
      co_return std::current_exception();
    }
  }

  /// How much of a broken-off upload the server kept; nothing if it has the whole.
  asio::awaitable<std::optional<std::uint64_t>> kept(net::HttpClient& client, Digest digest) {
    net::HttpRequest request = request_for("HEAD", digest);
    request.errors_throw = false;
    const net::HttpResponse response = co_await client.send(std::move(request));
    if (response.status == 200) co_return std::nullopt;
    if (response.status == 404) co_return offset_in(response);
    throw Error(
        response.status == 401 || response.status == 403 ? ErrorKind::refused : ErrorKind::failed,
        fmt::format("the server answers {} to a question for a blob", response.status));
  }

  asio::awaitable<void> send_from(net::HttpClient& client, Upload& upload, std::uint64_t offset) {
    there(upload, offset);
    net::HttpRequest request = put_from(upload, offset);
    net::FileRange range{upload.file, offset, upload.size - offset, {}};
    range.sent = [this, &upload, offset](std::uint64_t sent) {
      sent_ += offset + sent - upload.there;
      there(upload, offset + sent);
    };
    request.file = std::move(range);
    co_await client.send(std::move(request));
  }

  void there(Upload& upload, std::uint64_t bytes) {
    done_ = done_ - upload.there + bytes;
    upload.there = bytes;
    report();
  }
  void report() const { progress_(done_, total_); }

  std::vector<Upload> files_;
  const UploadProgress& progress_;
  std::size_t next_ = 0;
  std::uint64_t done_ = 0, total_ = 0, sent_ = 0;
};

}  // namespace

UploadSummary upload(Server& server, const SceneAssets& scene, const UploadProgress& progress) {
  std::vector<Digest> digests = assets::blobs_of(scene.bundle);
  digests.push_back(scene.digest);
  const std::set<Digest> lacking = missing(server, digests);

  std::map<Digest, Upload> files;  // each digest once
  for (const scene::UsedFile& used : scene.files) {
    const assets::BundleFile& entry = scene.bundle.files.at(used.path);
    if (lacking.contains(entry.digest))
      files.try_emplace(entry.digest, Upload{entry.digest, used.file, entry.size});
  }
  std::vector<Upload> list;
  for (auto& [digest, file] : files) list.push_back(std::move(file));
  Uploads uploads(std::move(list), progress);
  uploads.send(server);

  UploadSummary summary = uploads.summary();
  if (lacking.contains(scene.digest)) {
    net::HttpRequest request = request_for("PUT", scene.digest);
    request.headers.emplace_back("Content-Type", "application/octet-stream");
    request.body = assets::canonical_json(scene.bundle);
    ++summary.files;
    summary.bytes += request.body.size();
    server.send(std::move(request));
  }
  return summary;
}

}  // namespace tessera::client
