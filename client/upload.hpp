#pragma once
#include <cstdint>
#include <functional>

#include "client/prepare.hpp"
#include "client/server.hpp"

namespace tessera::client {

/// Told of what goes over: bytes that were lacking at the server, and those that are there now.
using UploadProgress = std::function<void(std::uint64_t done, std::uint64_t total)>;

/// Asks which of the scene's blobs the server lacks, and sends those alone; one that broke off goes
/// on where it broke off.
void upload(Server& server, const SceneAssets& scene, const UploadProgress& progress);

}  // namespace tessera::client
