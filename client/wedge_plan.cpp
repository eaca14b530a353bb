#include "client/wedge_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "client/job_parameters.hpp"
#include "client/scene_path.hpp"
#include "common/base/error.hpp"
#include "common/base/names.hpp"

namespace tessera::client {

namespace {

[[noreturn]] void fail(const std::string& parameter, const std::string& message) {
  throw Error(ErrorKind::bad_input, message, {.file = {}, .key = "--vary " + excerpt(parameter)});
}

/// An axis, and the job's parameter that it sets; nothing: it is a path in the scene.
struct Target {
  Vary axis;
  const JobParameter* parameter = nullptr;
};

bool say_the_same(std::string_view a, std::string_view b) {
  const auto is_side = [](std::string_view name) { return name == "width" || name == "height"; };
  return a == b || (a == "size" && is_side(b)) || (b == "size" && is_side(a));
}

std::vector<Target> targets_of(const JobOptions& job, std::vector<Vary> axes) {
  std::vector<Target> out;
  for (Vary& axis : axes) {
    const JobParameter* const parameter = find_job_parameter(axis.parameter);
    if (parameter != nullptr && parameter->given(job))
      fail(axis.parameter, "a flag fixes what is to be varied");
    if (parameter != nullptr) axis.parameter = parameter->name;
    for (const Target& other : out)
      if (say_the_same(other.axis.parameter, axis.parameter))
        fail(axis.parameter, "is varied twice");
    out.push_back({std::move(axis), parameter});
  }
  return out;
}

std::size_t count_of(const std::vector<Target>& targets) {
  std::size_t count = 1;
  for (const Target& target : targets) {
    count *= target.axis.values.size();
    if (count > wedge_cells_most)
      fail(target.axis.parameter,
           fmt::format("more than the {} pictures that a wedge may have", wedge_cells_most));
  }
  return count;
}

void set(JobOptions& job, const JobParameter& parameter, const Json& value) {
  try {
    parameter.set(job, value);
  } catch (const Error& error) {
    fail(std::string(parameter.name), error.message());
  }
}

bool same(const std::vector<SceneEdit>& a, const std::vector<SceneEdit>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const SceneEdit& x, const SceneEdit& y) {
                      return x.path == y.path && x.value == y.value;
                    });
}

/// Where the combination number `index` stands: the first axis changes fastest, then the second;
/// then, for the blocks, the last, and before it the one before.
std::vector<std::size_t> place_of(std::size_t index, const std::vector<Target>& targets) {
  std::vector<std::size_t> out(targets.size());
  const auto take = [&](std::size_t axis) {
    const std::size_t size = targets[axis].axis.values.size();
    out[axis] = index % size;
    index /= size;
  };
  for (std::size_t axis = 0; axis < std::min<std::size_t>(2, targets.size()); ++axis) take(axis);
  for (std::size_t axis = targets.size(); axis > 2; --axis) take(axis - 1);
  return out;
}

}  // namespace

WedgePlan plan_wedge(const JobOptions& job, std::vector<Vary> axes) {
  if (axes.empty()) fail("", "expected at least one parameter to vary");
  const std::vector<Target> targets = targets_of(job, std::move(axes));
  const std::size_t count = count_of(targets);
  WedgePlan plan;
  for (const Target& target : targets) plan.axes.push_back(target.axis);
  plan.columns = targets[0].axis.values.size();
  if (targets.size() > 1) plan.rows = targets[1].axis.values.size();
  plan.blocks = count / (plan.columns * plan.rows);
  for (std::size_t index = 0; index < count; ++index) {
    WedgeCell cell;
    cell.column = index % plan.columns;
    cell.row = index / plan.columns % plan.rows;
    cell.block = index / plan.columns / plan.rows;
    cell.values = place_of(index, targets);
    cell.job = job;
    std::vector<SceneEdit> edits;
    for (std::size_t axis = 0; axis < targets.size(); ++axis) {
      const Json& value = targets[axis].axis.values[cell.values[axis]];
      if (targets[axis].parameter != nullptr)
        set(cell.job, *targets[axis].parameter, value);
      else
        edits.push_back({targets[axis].axis.parameter, value});
    }
    const auto known = std::find_if(plan.scenes.begin(), plan.scenes.end(),
                                    [&](const auto& other) { return same(edits, other); });
    cell.scene = static_cast<std::size_t>(known - plan.scenes.begin());
    if (known == plan.scenes.end()) plan.scenes.push_back(std::move(edits));
    plan.cells.push_back(std::move(cell));
  }
  return plan;
}

std::string text_of(const WedgePlan& plan, const WedgeCell& cell) {
  std::string out;
  for (std::size_t axis = 0; axis < plan.axes.size(); ++axis)
    out += fmt::format("{}{}={}", axis == 0 ? "" : " ", plan.axes[axis].parameter,
                       value_text(plan.axes[axis].values[cell.values[axis]]));
  return out;
}

Json parameters_of(const WedgePlan& plan, const WedgeCell& cell) {
  Json out = Json::object();
  for (std::size_t axis = 0; axis < plan.axes.size(); ++axis)
    out[plan.axes[axis].parameter] = plan.axes[axis].values[cell.values[axis]];
  return out;
}

namespace {

/// What a file name takes as it is; all else becomes "_", no two of them in a row.
std::string file_part(std::string_view text) {
  std::string out;
  for (const char c : text) {
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("._+-").find(c) != std::string_view::npos;
    if (plain)
      out += c;
    else if (!out.empty() && out.back() != '_')
      out += '_';
  }
  while (!out.empty() && out.back() == '_') out.pop_back();
  return out;
}

}  // namespace

std::vector<std::string> exr_names(const WedgePlan& plan) {
  constexpr std::size_t longest = 200;  // a file name has 255 bytes at most
  std::vector<std::string> out;
  for (const WedgeCell& cell : plan.cells) {
    std::string name;
    for (std::size_t axis = 0; axis < plan.axes.size(); ++axis)
      name += fmt::format("{}{}={}", axis == 0 ? "" : ",", file_part(plan.axes[axis].parameter),
                          file_part(value_text(plan.axes[axis].values[cell.values[axis]])));
    // Nothing hidden, nothing that looks like an option.
    if (name.front() == '.' || name.front() == '-') name.insert(0, "_");
    name = name.substr(0, longest);
    if (std::find(out.begin(), out.end(), name + ".exr") != out.end())
      name += fmt::format(",{}", out.size() + 1);
    out.push_back(name + ".exr");
  }
  return out;
}

void apply(Json& scene, const std::vector<SceneEdit>& edits) {
  for (const SceneEdit& edit : edits) {
    try {
      value_at(scene, edit.path) = edit.value;
    } catch (const Error& error) {
      // A word alone may be meant for the job.
      std::string message = error.message();
      if (edit.path.find_first_of(".[") == std::string::npos && scene.is_object()) {
        std::vector<std::string_view> names;
        for (const JobParameter& one : job_parameters()) names.push_back(one.name);
        const std::string near = nearest_name(edit.path, names);
        if (!near.empty())
          message = fmt::format("unknown parameter \"{}\"; did you mean \"{}\"?",
                                excerpt(edit.path), near);
      }
      fail(edit.path, message);
    }
  }
}

}  // namespace tessera::client
