#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "common/base/digest.hpp"

/// The manifest that names a scene and all its files by digest. Pure.
namespace tessera::assets {

struct BundleFile {
  Digest digest;
  std::uint64_t size = 0;  ///< bytes
  /// Where it lies on a disk that the machines share, an absolute path; empty: it is a blob.
  std::string location = {};
  bool operator==(const BundleFile&) const = default;
};

/// Paths are relative to the folder that the bundle stands for, with "/" between their parts.
struct Bundle {
  std::string scene;                        ///< the root scene file's path; one of `files`
  std::map<std::string, BundleFile> files;  ///< by path, in byte order
  bool operator==(const Bundle&) const = default;
};

/// Checks the limits, every path and that the scene is there. Throws Error{bad_input} that names
/// the path.
void check(const Bundle& bundle);
/// Throws Error{bad_input} unless the path is relative, at most limits::bundle_path bytes, without
/// empty parts, ".", "..", backslashes, control characters or a drive letter.
void check_path(std::string_view path);
/// The same of an absolute path, which must begin with "/".
void check_location(std::string_view path);

/// {"files":{PATH:{"sha256":…,"size":…},…},"scene":PATH,"version":1}, keys sorted, no blanks: the
/// same bundle is always the same bytes. A file that is no blob has its "location" too.
std::string canonical_json(const Bundle& bundle);
/// SHA-256 of canonical_json: the name of the bundle, and of the blob that holds it.
Digest digest_of_bundle(const Bundle& bundle);
/// Reads and checks. `name` is what errors call the file.
Bundle bundle_from_json(std::string_view text, std::string_view name = "bundle");

/// The digests of the files that are blobs, each once, sorted.
std::vector<Digest> blobs_of(const Bundle& bundle);
/// Bytes of all files, each digest counted once.
std::uint64_t total_size(const Bundle& bundle);
/// Bytes of its blobs.
std::uint64_t blob_size(const Bundle& bundle);

}  // namespace tessera::assets
