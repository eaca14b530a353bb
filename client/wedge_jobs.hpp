#pragma once
#include <string>
#include <vector>

#include "client/memory_file.hpp"
#include "client/prepare.hpp"
#include "client/wedge_plan.hpp"

namespace tessera::client {

/// What a wedge's jobs need, before anything is sent.
struct PreparedWedge {
  std::string scene_name;             ///< or the file's
  std::vector<MemoryFile> edited;     ///< scene files that are not on disk as they are rendered
  std::vector<SceneAssets> scenes;    ///< one for each of the plan's
  std::vector<JobSpec> jobs;          ///< one for each of the plan's cells
  std::vector<std::string> warnings;  ///< of the scenes and the jobs, each once
};

/// Reads the scene, makes and checks each edited version of it, and hashes all files. Throws
/// Error{bad_input} that says with which values what is wrong.
PreparedWedge prepare_wedge(const WedgePlan& plan);

}  // namespace tessera::client
