#pragma once
#include <cstdint>
#include <functional>

#include "client/prepare.hpp"
#include "client/server.hpp"

namespace tessera::client {

/// Told of what goes over: bytes that were lacking at the server, and those that are there now.
using UploadProgress = std::function<void(std::uint64_t done, std::uint64_t total)>;

/// What went over.
struct UploadSummary {
  std::size_t files = 0;    ///< of the scene's, the list of them among these
  std::uint64_t bytes = 0;  ///< those sent; what the server kept of an upload before is not
};

/// Asks which of the scene's blobs the server lacks, and sends those alone, several at once; one
/// that broke off goes on where it broke off.
UploadSummary upload(Server& server, const SceneAssets& scene, const UploadProgress& progress);

}  // namespace tessera::client
