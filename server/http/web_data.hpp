#pragma once
#include <cstddef>
#include <span>

namespace tessera::server {

struct WebData {
  const char* name;
  const char* bytes;
  std::size_t size;
};

/// Every file of the page; the definition is written by embed.cmake.
std::span<const WebData> web_data();

}  // namespace tessera::server
