#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/scene/read_file.hpp"
#include "common/scene/scene_file.hpp"

namespace tessera::scene {

namespace fs = std::filesystem;

std::string checked_path(std::string_view path) {
  const auto refuse = [&](std::string_view why) {
    throw Error(ErrorKind::bad_input,
                fmt::format("\"{}\" {}; a scene's files lie in its folder or below",
                            excerpt(path, 200), why));
  };
  if (path.empty()) refuse("names no file");
  if (path.size() > limits::bundle_path) refuse("is too long a path");
  if (path.front() == '/') refuse("is an absolute path");
  if (path.find('\\') != std::string_view::npos)
    refuse("has a backslash in it (parts are divided by /)");
  if (std::any_of(path.begin(), path.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
    refuse("has a control character in it");
  std::string out;
  while (!path.empty()) {
    const std::size_t end = std::min(path.find('/'), path.size());
    const std::string_view part = path.substr(0, end);
    if (part == "..") refuse("leads outside of the scene's folder");
    if (!part.empty() && part != ".") {
      if (!out.empty()) out += '/';
      out += part;
    }
    if (end + 1 == path.size()) refuse("names a folder, not a file");
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  if (out.empty()) refuse("names no file");
  return out;
}

FolderFiles::FolderFiles(const fs::path& folder)
    : folder_(folder.empty() ? fs::path(".") : folder) {}

std::string FolderFiles::shown(const std::string& path) const {
  return folder_ == "." ? path : (folder_ / path).string();
}

fs::path FolderFiles::locate(const std::string& path) const {
  const std::string checked = checked_path(path);
  std::error_code error;
  const fs::path root = fs::canonical(folder_, error);
  if (error) throw Error(ErrorKind::not_found, fmt::format("no folder \"{}\"", folder_.string()));
  fs::path file = fs::canonical(root / checked, error);
  if (error) throw Error(ErrorKind::not_found, fmt::format("no file \"{}\"", shown(checked)));
  const auto [end, at] = std::mismatch(root.begin(), root.end(), file.begin(), file.end());
  if (end != root.end())
    throw Error(
        ErrorKind::bad_input,
        fmt::format("\"{}\" is a link that leads outside of the scene's folder", shown(checked)));
  if (!fs::is_regular_file(file, error))
    throw Error(ErrorKind::bad_input, fmt::format("\"{}\" is not a plain file", shown(checked)));
  return file;
}

BundleFiles::BundleFiles(std::map<std::string, fs::path> files) : files_(std::move(files)) {}

std::string BundleFiles::shown(const std::string& path) const { return path; }

fs::path BundleFiles::locate(const std::string& path) const {
  const std::string checked = checked_path(path);
  const auto found = files_.find(checked);
  if (found == files_.end())
    throw Error(ErrorKind::not_found, fmt::format("no file \"{}\" in the bundle", checked));
  return found->second;
}

std::string read_file(const fs::path& file, const std::string& name, std::size_t most) {
  const Place place{.file = name, .key = {}};
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  if (error)
    throw Error(ErrorKind::not_found, fmt::format("no such file ({})", error.message()), place);
  if (size > most)
    throw Error(ErrorKind::too_large, fmt::format("{} bytes; {} is the most", size, most), place);
  std::ifstream in(file, std::ios::binary);
  std::string text(static_cast<std::size_t>(size), '\0');
  if (!in || !in.read(text.data(), static_cast<std::streamsize>(text.size())))
    throw Error(ErrorKind::failed, "cannot be read", place);
  return text;
}

}  // namespace tessera::scene
