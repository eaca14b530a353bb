#pragma once
#include <cstddef>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "client/job_options.hpp"
#include "client/vary.hpp"

/// From a command line to the grid of jobs that it asks for. Pure.
namespace tessera::client {

/// A value that a scene gets in place of the one in its file.
struct SceneEdit {
  std::string path;  ///< see value_at
  Json value;
};

struct WedgeCell {
  std::size_t column = 0, row = 0, block = 0;
  std::vector<std::size_t> values;  ///< of each axis, which of its values
  JobOptions job;                   ///< with the values of those axes that are a job's parameters
  std::size_t scene = 0;            ///< which of the plan's scenes
};

/// One job for each combination of values. The first axis gives the columns from left to right, the
/// second the rows from top to bottom; the further ones together give blocks of such a grid, one
/// below the other, the last axis changing from each block to the next.
struct WedgePlan {
  std::vector<Vary> axes;
  std::size_t columns = 1, rows = 1, blocks = 1;
  std::vector<std::vector<SceneEdit>> scenes;  ///< each scene that is needed, once; without edits
                                               ///< it is the file as it stands
  std::vector<WedgeCell> cells;                ///< row by row, block by block
};

constexpr std::size_t wedge_cells_most = 1024;

/// A parameter that a job has is taken for the job's, under the name of its flag ("light_samples",
/// "light-samples" too) or its path in a scene ("render.samples"); any other is a path in the
/// scene. Throws Error{bad_input} that names the `--vary` at fault: one that is there twice, one
/// that a flag fixes, a value of the wrong kind, more than wedge_cells_most jobs.
WedgePlan plan_wedge(const JobOptions& job, std::vector<Vary> axes);

/// "samples=4 light_samples=16".
std::string text_of(const WedgePlan& plan, const WedgeCell& cell);
/// {"samples": 4, "light_samples": 16}.
Json parameters_of(const WedgePlan& plan, const WedgeCell& cell);
/// A file name for each cell's EXR, no two the same, of letters, digits and "._+=,-":
/// "samples=4,light_samples=16.exr".
std::vector<std::string> exr_names(const WedgePlan& plan);

/// Applies edits to a scene's JSON, in their order. Throws Error{bad_input} that names the
/// `--vary`.
void apply(Json& scene, const std::vector<SceneEdit>& edits);

}  // namespace tessera::client
