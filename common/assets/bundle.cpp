#include "common/assets/bundle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/base/error.hpp"
#include "common/base/json.hpp"
#include "common/base/limits.hpp"

namespace tessera::assets {

namespace {
[[noreturn]] void bad(std::string_view path, const std::string& message) {
  throw Error(ErrorKind::bad_input, message, {.key = fmt::format("files.{}", path.substr(0, 256))});
}
}  // namespace

void check_path(std::string_view path) {
  if (path.empty()) bad(path, "a file of a bundle has a path; this one is empty");
  if (path.size() > limits::bundle_path)
    bad(path,
        fmt::format("a path has at most {} bytes, found {}", limits::bundle_path, path.size()));
  for (const char c : path) {
    if (static_cast<unsigned char>(c) < 0x20 || c == '\x7f')
      bad("?", "a path has no control characters");
    if (c == '\\') bad(path, "the parts of a path are divided by \"/\", found \"\\\"");
  }
  if (path.front() == '/')
    bad(path, "expected a path relative to the scene, found an absolute one");
  if (path.size() >= 2 && path[1] == ':')
    bad(path, "expected a path relative to the scene, found a drive letter");
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('/', begin), path.size());
    const std::string_view part = path.substr(begin, end - begin);
    if (part.empty()) bad(path, "a path has no empty part");
    if (part == "." || part == "..") bad(path, fmt::format("a path has no part \"{}\"", part));
    begin = end + 1;
  }
}

void check_location(std::string_view path) {
  if (path.empty() || path.front() != '/')
    bad(path, "expected an absolute path as a file's location");
  check_path(path.substr(1));
}

void check(const Bundle& bundle) {
  if (bundle.files.size() > limits::bundle_files)
    throw Error(ErrorKind::bad_input, fmt::format("a bundle has at most {} files, found {}",
                                                  limits::bundle_files, bundle.files.size()));
  for (const auto& [path, file] : bundle.files) {
    check_path(path);
    if (!file.location.empty()) check_location(file.location);
    if (file.size > limits::blob_bytes)
      bad(path,
          fmt::format("a file has at most {} bytes, found {}", limits::blob_bytes, file.size));
  }
  // A path that is a file cannot be a folder too: the files could not stand on a disk together.
  for (const auto& [path, file] : bundle.files)
    for (std::size_t slash = path.find('/'); slash != std::string::npos;
         slash = path.find('/', slash + 1))
      if (bundle.files.contains(path.substr(0, slash)))
        bad(path, fmt::format("\"{}\" is a file of the bundle, and cannot be a folder too",
                              path.substr(0, slash)));
  if (!bundle.files.contains(bundle.scene))
    throw Error(ErrorKind::bad_input,
                fmt::format("the scene \"{}\" is not among the files", bundle.scene),
                {.key = "scene"});
}

std::string canonical_json(const Bundle& bundle) {
  Json files = Json::object();
  for (const auto& [path, file] : bundle.files) {
    files[path] = {{"sha256", file.digest.hex()}, {"size", file.size}};
    if (!file.location.empty()) files[path]["location"] = file.location;
  }
  const Json json = {{"version", 1}, {"scene", bundle.scene}, {"files", std::move(files)}};
  return json.dump();  // keys are kept sorted
}

Digest digest_of_bundle(const Bundle& bundle) { return digest_of(canonical_json(bundle)); }

Bundle bundle_from_json(std::string_view text, std::string_view name) {
  if (text.size() > limits::bundle_json_bytes)
    throw Error(ErrorKind::too_large,
                fmt::format("a bundle has at most {} bytes", limits::bundle_json_bytes),
                {.file = std::string(name)});
  const Json json = parse_json(text, name);
  ObjectReader in(json, "");
  in.integer("version", 1, 1);
  Bundle bundle;
  bundle.scene = in.text("scene");
  const Json& files = in.required("files");
  if (!files.is_object())
    in.fail("files", fmt::format("expected an object, found {}", files.type_name()));
  if (files.size() > limits::bundle_files)
    in.fail("files", fmt::format("a bundle has at most {} files, found {}", limits::bundle_files,
                                 files.size()));
  for (const auto& [path, value] : files.items()) {
    check_path(path);
    ObjectReader file(value, in.path_of("files") + "." + path);
    const auto digest = Digest::from_hex(file.text("sha256"));
    if (!digest) file.fail("sha256", "expected a SHA-256 as 64 hexadecimal digits");
    const auto size = static_cast<std::uint64_t>(
        file.integer("size", 0, static_cast<std::int64_t>(limits::blob_bytes)));
    std::string location;
    if (file.optional("location") != nullptr) {
      location = file.text("location");
      check_location(location);
    }
    file.finish();
    bundle.files.emplace(path, BundleFile{*digest, size, std::move(location)});
  }
  in.finish();
  check(bundle);
  return bundle;
}

std::vector<Digest> blobs_of(const Bundle& bundle) {
  std::vector<Digest> digests;
  for (const auto& [path, file] : bundle.files)
    if (file.location.empty()) digests.push_back(file.digest);
  std::sort(digests.begin(), digests.end());
  digests.erase(std::unique(digests.begin(), digests.end()), digests.end());
  return digests;
}

namespace {
std::uint64_t size_of(const Bundle& bundle, bool blobs_alone) {
  std::map<Digest, std::uint64_t> sizes;
  for (const auto& [path, file] : bundle.files)
    if (!blobs_alone || file.location.empty()) sizes[file.digest] = file.size;
  std::uint64_t total = 0;
  for (const auto& [digest, size] : sizes) total += size;
  return total;
}
}  // namespace

std::uint64_t total_size(const Bundle& bundle) { return size_of(bundle, false); }
std::uint64_t blob_size(const Bundle& bundle) { return size_of(bundle, true); }

}  // namespace tessera::assets
