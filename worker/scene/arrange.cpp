#include "worker/scene/arrange.hpp"

#include <algorithm>
#include <limits>

#include "worker/scene/affine.hpp"

namespace tessera::worker {
namespace {

using render::Vec3d;

/// A scale that is the same in all directions and positive, and a shift: nothing else.
bool keeps_directions(const scene::Transform& transform) {
  const Matrix3 m = linear(transform);
  for (std::size_t i = 0; i < 9; ++i) {
    if (i % 4 == 0 ? m[i] != m[0] : m[i] != 0) return false;
  }
  return m[0] > 0;
}

/// Spheres that only an instance can show.
class BentSpheres {
 public:
  explicit BentSpheres(std::span<const render::CompiledMaterial> materials)
      : materials_(materials) {}

  bool operator()(const scene::Shape& shape, const scene::Transform& transform) const {
    if (!std::holds_alternative<scene::Sphere>(shape.geometry)) return false;
    if (!uniform_scale(transform)) return true;
    return materials_[shape.material].wants != 0 && !keeps_directions(transform);
  }

 private:
  std::span<const render::CompiledMaterial> materials_;
};

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr Extent nothing{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};

void grow(Extent& extent, const Vec3d& p) {
  const std::array<double, 3> at{p.x, p.y, p.z};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    extent.low[axis] = std::min(extent.low[axis], at[axis]);
    extent.high[axis] = std::max(extent.high[axis], at[axis]);
  }
}

void grow_by_corners(Extent& extent, const Extent& box, const scene::Transform& transform) {
  for (unsigned corner = 0; corner < 8; ++corner) {
    grow(extent, times_point(transform, {(corner & 1) != 0 ? box.high[0] : box.low[0],
                                         (corner & 2) != 0 ? box.high[1] : box.low[1],
                                         (corner & 4) != 0 ? box.high[2] : box.low[2]}));
  }
}

void grow_by_quad(Extent& extent, const scene::Quad& quad, const scene::Transform& transform) {
  const Vec3d a = render::to_vec3d(quad.corner), u = render::to_vec3d(quad.edge_u),
              v = render::to_vec3d(quad.edge_v);
  for (const Vec3d& p : {a, a + u, a + v, a + u + v}) grow(extent, times_point(transform, p));
}

void grow_by_shape(Extent& extent, const PlacedShape& placed) {
  const scene::Transform& t = placed.to_group;
  const auto& geometry = placed.shape->geometry;
  if (const auto* quad = std::get_if<scene::Quad>(&geometry)) {
    grow_by_quad(extent, *quad, t);
  } else if (const auto* disk = std::get_if<scene::Disk>(&geometry)) {
    grow_by_quad(extent, square_around(*disk), t);
  } else if (const auto* sphere = std::get_if<scene::Sphere>(&geometry)) {
    Extent box = nothing;
    const Vec3d c = render::to_vec3d(sphere->center);
    const double r = sphere->radius;
    grow(box, c - Vec3d{r, r, r});
    grow(box, c + Vec3d{r, r, r});
    grow_by_corners(extent, box, t);
  } else if (const auto* box = std::get_if<scene::Box>(&geometry)) {
    grow_by_corners(extent, {box->low, box->high}, t);
  } else if (const auto* mesh = std::get_if<scene::Mesh>(&geometry)) {
    for (const auto& p : mesh->positions) grow(extent, times_point(t, {p[0], p[1], p[2]}));
  }
}

}  // namespace

Arrangement arrange(scene::Scene& description, std::span<const render::CompiledMaterial> materials,
                    const scene::ObjectNames& objects) {
  const BentSpheres is_bent(materials);
  Arrangement out;
  out.groups.resize(1);
  const auto add_to_world = [&](scene::Shape& shape, const scene::Transform& to_world,
                                const scene::Visibility& visibility, std::uint32_t object) {
    if (is_bent(shape, to_world)) {
      out.groups.push_back({{&shape, scene::Transform{}}});
      out.placed.push_back({out.groups.size() - 1, to_world, visibility, object});
    } else {
      out.groups[0].push_back({&shape, to_world, visibility, object});
    }
  };
  for (std::size_t i = 0; i < description.shapes.size(); ++i) {
    scene::Shape& shape = description.shapes[i];
    add_to_world(shape, shape.to_world, shape.visibility, objects.of_shape[i]);
  }

  struct Place {
    const scene::Instance* instance;
    std::uint32_t object;
  };
  std::vector<std::vector<Place>> places(description.objects.size());
  for (std::size_t i = 0; i < description.instances.size(); ++i) {
    const scene::Instance& instance = description.instances[i];
    places[instance.object].push_back({&instance, objects.of_instance[i]});
  }
  for (std::size_t object = 0; object < places.size(); ++object) {
    std::vector<scene::Shape>& shapes = description.objects[object].shapes;
    if (places[object].size() == 1) {
      const auto& [only, name] = places[object][0];
      for (scene::Shape& shape : shapes)
        add_to_world(shape, only->to_world * shape.to_world, only->visibility & shape.visibility,
                     name);
      continue;
    }
    if (places[object].empty()) continue;
    std::vector<PlacedShape> together;
    for (scene::Shape& shape : shapes) {
      if (!is_bent(shape, shape.to_world)) {
        together.push_back({&shape, shape.to_world, shape.visibility});
        continue;
      }
      out.groups.push_back({{&shape, scene::Transform{}, shape.visibility}});
      for (const auto& [place, name] : places[object]) {
        out.placed.push_back(
            {out.groups.size() - 1, place->to_world * shape.to_world, place->visibility, name});
      }
    }
    if (together.empty()) continue;
    out.groups.push_back(std::move(together));
    for (const auto& [place, name] : places[object]) {
      out.placed.push_back({out.groups.size() - 1, place->to_world, place->visibility, name});
    }
  }
  return out;
}

std::vector<Extent> extents_of_groups(const Arrangement& arrangement) {
  std::vector<Extent> of_group;
  for (const std::vector<PlacedShape>& group : arrangement.groups) {
    Extent extent = nothing;
    for (const PlacedShape& placed : group) grow_by_shape(extent, placed);
    of_group.push_back(extent);
  }
  return of_group;
}

Extent extent_of(const Arrangement& arrangement, std::span<const Extent> of_group) {
  Extent all = of_group[0];
  for (const Arrangement::Placed& placed : arrangement.placed) {
    if (!of_group[placed.group].empty()) {
      grow_by_corners(all, of_group[placed.group], placed.to_world);
    }
  }
  return all;
}

}  // namespace tessera::worker
