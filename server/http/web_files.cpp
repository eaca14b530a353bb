#include "server/http/web_files.hpp"

#include <algorithm>
#include <vector>

#include "common/base/digest.hpp"
#include "server/http/web_data.hpp"

namespace tessera::server {

namespace {
std::string_view type_of(std::string_view name) {
  if (name.ends_with(".html")) return "text/html; charset=utf-8";
  if (name.ends_with(".css")) return "text/css; charset=utf-8";
  if (name.ends_with(".js")) return "text/javascript; charset=utf-8";
  if (name.ends_with(".svg")) return "image/svg+xml";
  return "application/octet-stream";
}

std::vector<WebFile> make_files() {
  std::vector<WebFile> files;
  for (const WebData& data : web_data()) {
    const std::string_view text(data.bytes, data.size);
    files.push_back(
        {data.name, text, type_of(data.name), "\"" + digest_of(text).hex().substr(0, 32) + "\""});
  }
  return files;
}
}  // namespace

const WebFile* find_web_file(std::string_view name) {
  static const std::vector<WebFile> files = make_files();
  const auto found = std::find_if(files.begin(), files.end(),
                                  [&](const WebFile& file) { return file.name == name; });
  return found == files.end() ? nullptr : &*found;
}

}  // namespace tessera::server
