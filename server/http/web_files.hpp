#pragma once
#include <string>
#include <string_view>

/// The page's files, compiled in from server/web.
namespace tessera::server {

struct WebFile {
  std::string_view name;
  std::string_view text;
  std::string_view type;  ///< media type
  std::string etag;       ///< quoted
};

/// nullptr if there is none of this name.
const WebFile* find_web_file(std::string_view name);

}  // namespace tessera::server
