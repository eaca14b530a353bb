#pragma once
#include <vector>

#include "client/job_options.hpp"
#include "common/assets/bundle.hpp"
#include "common/scene/scene_file.hpp"

namespace tessera::client {

/// A job that is ready to be posted, and the bytes that it needs.
struct PreparedJob {
  JobSpec spec;
  assets::Bundle bundle;
  std::vector<scene::UsedFile> files;  ///< the scene's, where they are on this machine
};

/// The manifest of a scene's files: hashes each.
assets::Bundle bundle_of(const std::vector<scene::UsedFile>& files);

/// Reads the scene and all that it uses, whatever is wrong in it being an error here, and hashes
/// the files.
PreparedJob prepare(const JobOptions& options);

}  // namespace tessera::client
