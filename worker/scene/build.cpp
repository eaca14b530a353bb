#include "worker/scene/build.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "common/base/error.hpp"
#include "common/job/matte.hpp"
#include "common/scene/light_groups.hpp"
#include "common/scene/object_names.hpp"
#include "worker/scene/affine.hpp"
#include "worker/scene/arrange.hpp"
#include "worker/scene/emitters.hpp"
#include "worker/scene/merge.hpp"
#include "worker/scene/textures.hpp"
#include "worker/scene/visibility.hpp"

namespace tessera::worker {
namespace {

std::vector<render::CompiledMaterial> compile_all(const std::vector<scene::Material>& materials) {
  if (materials.size() > std::numeric_limits<std::uint16_t>::max() + std::size_t{1}) {
    throw Error(ErrorKind::too_large, fmt::format("the scene has {} materials; at most 65536 can "
                                                  "be told apart",
                                                  materials.size()));
  }
  std::vector<render::CompiledMaterial> out;
  out.reserve(materials.size());
  for (const scene::Material& material : materials)
    out.push_back(render::compile(material, materials));
  return out;
}

/// Which of the scene's light groups this is.
class GroupNumbers {
 public:
  explicit GroupNumbers(const std::vector<std::string>& names) {
    for (const std::string& name : names)
      numbers_.emplace(name, static_cast<std::uint16_t>(numbers_.size()));
  }
  std::uint16_t operator()(const std::string& name) const {
    return name.empty() ? std::uint16_t{0} : numbers_.at(name);
  }

 private:
  std::map<std::string, std::uint16_t> numbers_;
};

/// 0, unless what has this extent stands so far off that float would be coarse there.
std::array<double, 3> origin_for(const Extent& extent) {
  if (extent.empty()) return {};
  double far = 0, reach = 0;
  std::array<double, 3> center;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    center[axis] = 0.5 * (extent.low[axis] + extent.high[axis]);
    far = std::max(far, std::abs(center[axis]));
    reach = std::max(reach, 0.5 * (extent.high[axis] - extent.low[axis]));
  }
  return far > 16 * reach ? center : std::array<double, 3>{};
}

void add_to_accel(const render::Group& group, accel::Scene& scene) {
  for (const render::Geometry& geometry : group.geometries) {
    const std::array<std::span<const accel::Point>, 1> keys{geometry.positions.span()};
    const accel::Mask mask = mask_of(geometry.visibility);
    switch (geometry.kind) {
      case render::GeometryKind::triangles:
        scene.add_triangles(keys, geometry.triangles.span(), mask);
        break;
      case render::GeometryKind::quads:
        if (geometry.round) {
          scene.add_ellipses(keys, geometry.quads.span(), mask);
        } else {
          scene.add_quads(keys, geometry.quads.span(), mask);
        }
        break;
      case render::GeometryKind::spheres:
        scene.add_spheres(geometry.spheres.span(), mask);
        break;
    }
  }
}

render::Placement placement_of(const scene::Transform& to_world, std::uint32_t group,
                               std::uint32_t first_light) {
  const Matrix3 m = linear(to_world);
  const auto back = inverse(m);
  if (!back) {
    throw Error(
        ErrorKind::bad_input,
        "an instance's transform has no inverse: it makes its object flat, or is not finite");
  }
  render::Placement out;
  out.group = group;
  out.first_light = first_light;
  out.moved = true;
  out.to_world = rounded(to_world);
  // Only the direction of what it gives counts; so it is kept far from the ends of float's range.
  double most = 0;
  for (const double entry : *back) most = std::max(most, std::abs(entry));
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      out.normal_to_world[3 * row + column] = static_cast<float>((*back)[3 * column + row] / most);
    }
  }
  out.error_scale = static_cast<float>(error_growth(m, *back));
  return out;
}

std::vector<render::Identity> identities_of(const std::vector<std::string_view>& names) {
  std::vector<render::Identity> out;
  for (const std::string_view name : names)
    out.push_back({static_cast<float>(out.size() + 1), matte_id(name)});
  return out;
}

std::vector<render::Identity> material_identities(const scene::Scene& scene) {
  const scene::MaterialNames materials = scene::material_names(scene);
  const std::vector<render::Identity> named = identities_of(materials.names);
  std::vector<render::Identity> out;
  for (const std::uint32_t name : materials.of_material) out.push_back(named[name]);
  return out;
}

render::Bounds3 bounds_of(const Extent& extent, const std::array<double, 3>& origin) {
  render::Bounds3 bounds;
  if (extent.empty()) return bounds;
  const render::Vec3d shift = render::to_vec3d(origin);
  bounds.grow(render::to_float(render::to_vec3d(extent.low) - shift));
  bounds.grow(render::to_float(render::to_vec3d(extent.high) - shift));
  return bounds;
}

render::Light environment_light(const render::Bounds3& bounds,
                                const scene::Environment& environment,
                                const render::EnvironmentMap* map) {
  render::EnvironmentLight shape;
  shape.map = map;
  if (!bounds.empty()) {
    shape.center = (bounds.low + bounds.high) * 0.5F;
    shape.radius = std::max(0.5F * render::length(bounds.high - bounds.low), 1e-30F);
  }
  render::Light light;
  light.shape = shape;
  light.radiance =
      render::to_color(environment.radiance) * static_cast<float>(environment.strength);
  return light;
}

/// Puts the groups into the world, and their lights behind `lights`.
void place_groups(const Arrangement& arrangement, const std::vector<MergedGroup>& merged,
                  render::Scene& out, std::vector<render::Light>& lights) {
  out.world_geometries = static_cast<std::uint32_t>(merged[0].group.geometries.size());
  out.placements.reserve(arrangement.placed.size() + 1);
  out.placements.emplace_back();
  out.placements[0].first_light =
      add_lights(merged[0], out.materials, scene::Transform{}, render::no_id, lights);
  for (const Arrangement::Placed& placed : arrangement.placed) {
    const scene::Transform to_world =
        relative_to(from_origin(placed.to_world, merged[placed.group].origin), out.origin);
    const auto instance =
        out.world_geometries + static_cast<std::uint32_t>(out.placements.size() - 1);
    out.placements.push_back(
        placement_of(to_world, static_cast<std::uint32_t>(placed.group),
                     add_lights(merged[placed.group], out.materials, to_world, instance, lights)));
    out.placements.back().visibility = placed.visibility;
    out.placements.back().object = placed.object;
  }
}

void build_hierarchies(render::Scene& out, const accel::Progress& progress) {
  for (std::size_t i = 1; i < out.groups.size(); ++i) {
    out.group_accels.emplace_back(out.device);
    add_to_accel(out.groups[i], out.group_accels.back());
    out.group_accels.back().build(progress);
  }
  add_to_accel(out.groups[0], out.accel);
  for (std::size_t i = 1; i < out.placements.size(); ++i) {
    const std::array<accel::Affine, 1> keys{out.placements[i].to_world};
    const render::Placement& placed = out.placements[i];
    out.accel.add_instance(out.group_accels[placed.group - 1], keys, mask_of(placed.visibility));
  }
  out.accel.build(progress);
}

}  // namespace

render::Scene build_scene(scene::Scene&& description, const accel::Device& device,
                          const accel::Progress& progress, const render::SceneNeeds& needs) {
  scene::Scene from = std::move(description);
  render::Scene out(device);
  out.keeps = needs;
  image::TexelBudget budget(picture_bytes_most());
  // Tables that materials share are made by the first that asks; pictures need not wait for it.
  tbb::parallel_invoke([&] { out.materials = compile_all(from.materials); },
                       [&] { out.textures = load_textures(from, budget); });
  out.light_groups = scene::light_groups(from);
  const GroupNumbers group_of(out.light_groups);
  for (std::size_t i = 0; i < from.materials.size(); ++i)
    out.materials[i].light_group = group_of(from.materials[i].light_group);
  for (const render::CompiledMaterial& material : out.materials) {
    out.has_gaps = out.has_gaps || material.has_opacity || material.back_culled;
  }
  out.cameras = std::move(from.cameras);

  const scene::ObjectNames objects = scene::object_names(from);
  out.object_identities = identities_of(objects.names);
  out.material_identities = material_identities(from);
  Arrangement arrangement = arrange(from, out.materials, objects);
  // There may be millions, and they stand in the arrangement.
  from.instances = std::vector<scene::Instance>();
  const std::vector<Extent> of_group = extents_of_groups(arrangement);
  const Extent extent = extent_of(arrangement, of_group);
  out.origin = origin_for(extent);
  out.bounds = bounds_of(extent, out.origin);

  std::vector<MergedGroup> merged;
  for (std::size_t i = 0; i < arrangement.groups.size(); ++i) {
    merged.push_back(merge(arrangement.groups[i], out.materials, out.textures,
                           i == 0 ? out.origin : origin_for(of_group[i]), needs.coordinates));
  }
  // Embree takes its memory from the system, and would not find what meshes left here.
  malloc_trim(0);
  std::vector<render::Light> lights;
  place_groups(arrangement, merged, out, lights);
  arrangement.placed = std::vector<Arrangement::Placed>();
  if (from.environment) {
    out.has_environment = true;
    const scene::Environment& environment = *from.environment;
    if (environment.image) out.environment_map = load_environment(from, budget);
    render::Light light = environment_light(out.bounds, environment, out.environment_map.get());
    light.group = group_of(environment.light_group);
    if (!render::is_black(render::power(light))) lights.push_back(light);
  }
  for (const scene::PunctualLight& light : from.lights) {
    lights.push_back(punctual_light(light, out.origin, out.bounds));
    lights.back().group = group_of(light.light_group);
  }
  for (MergedGroup& one : merged) out.groups.push_back(std::move(one.group));
  for (const render::Light& light : lights) out.light_errors.push_back(rounding_error(light, out));
  out.lights = render::LightTable(std::move(lights));

  out.film_transparent = from.film_transparent;
  note_visibility(out);
  build_hierarchies(out, progress);
  return out;
}

}  // namespace tessera::worker
