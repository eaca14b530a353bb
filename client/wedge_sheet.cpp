#include "client/wedge_sheet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

namespace tessera::client {

namespace {

std::vector<std::string> labels_of(const Vary& axis) {
  std::vector<std::string> out;
  for (const Json& value : axis.values) out.push_back(value_text(value));
  return out;
}

std::string counted(std::int64_t count, std::string_view one) {
  return fmt::format("{} {}{}", count, one, count == 1 ? "" : "s");
}

std::string note_of(const WedgePlan& plan, const RenderSettings& render, const Look& look) {
  std::string out;
  const auto varied = [&](std::string_view name) {
    return std::any_of(plan.axes.begin(), plan.axes.end(),
                       [&](const Vary& axis) { return axis.parameter == name; });
  };
  const auto add = [&](std::string_view name, const std::string& words) {
    if (!varied(name)) out += fmt::format("{}{}", out.empty() ? "" : " · ", words);
  };
  if (!varied("width") && !varied("height"))
    add("size", fmt::format("{} × {}", render.width, render.height));
  add("samples", counted(render.samples, "sample"));
  add("light_samples", counted(render.light_samples, "light sample"));
  add("integrator", render.integrator);
  add("sampler", render.sampler);
  add("filter", render.filter);
  add("bounces", counted(render.bounces, "bounce"));
  add("seed", fmt::format("seed {}", render.seed));
  if (look.view == image::View::filmic) add("", "filmic");
  if (look.exposure != 0)
    add("", fmt::format("exposure {:+g} stop{}", look.exposure,
                        look.exposure == 1 || look.exposure == -1 ? "" : "s"));
  return out;
}

/// "integrator = path, seed = 3": what the third and further axes are in a block.
std::string heading_of(const WedgePlan& plan, const WedgeCell& cell) {
  std::string out;
  for (std::size_t axis = 2; axis < plan.axes.size(); ++axis)
    out += fmt::format("{}{} = {}", axis == 2 ? "" : ", ", plan.axes[axis].parameter,
                       value_text(plan.axes[axis].values[cell.values[axis]]));
  return out;
}

}  // namespace

SheetContent content_of(const WedgePlan& plan, const PreparedWedge& prepared, int cell_width,
                        const Look& look) {
  SheetContent out;
  out.title = prepared.scene_name;
  out.note = note_of(plan, prepared.jobs.front().render, look);
  out.column_name = plan.axes[0].parameter;
  out.columns = labels_of(plan.axes[0]);
  out.rows = {""};
  if (plan.axes.size() > 1) {
    out.row_name = plan.axes[1].parameter;
    out.rows = labels_of(plan.axes[1]);
  }
  for (const WedgeCell& cell : plan.cells)
    if (cell.column == 0 && cell.row == 0) out.blocks.push_back(heading_of(plan, cell));
  for (const JobSpec& job : prepared.jobs) {
    const Rect window = job.render.window();
    const PictureSize size = fitted({window.width, window.height}, cell_width);
    out.cell_width = std::max(out.cell_width, size.width);
    out.cell_height = std::max(out.cell_height, size.height);
  }
  return out;
}

}  // namespace tessera::client
