#pragma once
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "common/assets/bundle.hpp"
#include "common/base/descriptor.hpp"
#include "common/base/error.hpp"

/// Files on disks that machines share, which jobs name by path instead of uploading them.
namespace tessera::agent {

/// This machine cannot read a file that a job names; others may.
class FileNotHere : public Error {
 public:
  using Error::Error;
};

/// A file as it was when it was looked at.
struct FileStamp {
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t modified = 0, changed = 0;  ///< nanoseconds since the epoch
  bool operator==(const FileStamp&) const = default;
};

/// One that is open: it stays the file that was checked, whatever takes its name.
class SharedFile {
 public:
  SharedFile(Descriptor descriptor, std::filesystem::path location);

  /// A path that opens it, for this process, as long as this lives.
  [[nodiscard]] std::filesystem::path path() const { return descriptor_.path(); }
  [[nodiscard]] const std::filesystem::path& location() const { return location_; }
  [[nodiscard]] FileStamp stamp() const;
  /// Throws Error{bad_input} if it was written to since this was made.
  void check_unchanged() const;

 private:
  Descriptor descriptor_;
  std::filesystem::path location_;
  FileStamp opened_;
};

class SharedFiles {
 public:
  /// Jobs may name files that lie beneath these folders, and no others. Throws Error{bad_input} for
  /// one that is no absolute path.
  explicit SharedFiles(std::vector<std::filesystem::path> roots);

  /// Opens the file at the entry's location and reads it through, unless it was before and is as it
  /// was. Told now and then how many bytes are read. Nothing if `stop` was asked for. Throws
  /// FileNotHere if it lies, or a link in its path leads, beneath none of the roots, or if it
  /// cannot be opened; nothing of it is read then. Throws Error{bad_input} if its bytes are others
  /// than the entry says.
  std::optional<SharedFile> open(const assets::BundleFile& entry,
                                 const std::function<void(std::uint64_t)>& on_bytes,
                                 const std::stop_token& stop);

 private:
  struct Checked {
    FileStamp stamp;
    Digest digest;
    bool operator==(const Checked&) const = default;
  };
  [[nodiscard]] SharedFile open_beneath(const std::filesystem::path& location) const;

  std::vector<std::filesystem::path> roots_;
  std::map<std::string, Checked> checked_;  ///< by location
};

}  // namespace tessera::agent
