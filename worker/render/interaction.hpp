#pragma once
#include <bit>
#include <cstdint>

#include "worker/render/bsdf/material.hpp"
#include "worker/render/lights/light.hpp"
#include "worker/render/scene.hpp"

namespace tessera::render {

/// Where a path scatters: on a surface, or in a medium (then `medium` is set, and there are no
/// normals).
struct Interaction {
  Vec3 p;
  ShadingPoint shading;  ///< wo, normals (outer side), footprint, details
  float t = 0;           ///< distance along the ray that came here
  float u = 0, v = 0;    ///< the hit's, of accel
  /// A ray that leaves starts this far along the geometric normal. It is a bound of the rounding
  /// error of p and of the intersector for this very primitive, so it scales with the scene and
  /// needs no setting.
  float error = 0;
  std::uint32_t medium = no_id;
  std::uint32_t placement = 0;
  std::uint32_t geometry = 0;  ///< within the placement's group
  std::uint32_t primitive = no_id;
  std::uint32_t instance = no_id;
  std::uint32_t light = no_id;  ///< which of the scene's lights this is a point of
  std::uint16_t material = 0;

  [[nodiscard]] bool on_surface() const { return medium == no_id; }

  /// Where a ray along `direction` starts, so that it does not meet the surface that it leaves.
  [[nodiscard]] Vec3 start(const Vec3& direction) const {
    return p + shading.normal * (dot(direction, shading.normal) < 0 ? -error : error);
  }
  /// How far along `ray`, which came here, the surface is surely behind it.
  [[nodiscard]] float behind(const Ray& ray) const {
    const float cosine = std::max(std::abs(dot(ray.direction, shading.normal)), 1e-3F);
    return (t + error / cosine) * (1 + 0x1p-22F);
  }
  /// A ray from here along unit `direction`, as far as `length`; `came` is the ray that led here.
  [[nodiscard]] Ray leave(const Vec3& direction, float length, const Ray& came) const {
    Ray ray;
    ray.origin = start(direction);
    ray.direction = direction;
    ray.t_max = length;
    ray.time = came.time;
    ray.cone_width = came.cone_width + came.cone_spread * t;
    ray.cone_spread = came.cone_spread;
    return ray;
  }
};

/// Asks memory for what surface_at() will read: first a face's indices and material …
inline void prefetch_face(const Geometry& geometry, std::uint32_t face) {
  if (geometry.kind == GeometryKind::triangles) __builtin_prefetch(&geometry.triangles[face]);
  __builtin_prefetch(&geometry.materials[face]);
}
/// … then, once the indices are there, its corners.
inline void prefetch_corners(const Geometry& geometry, std::uint32_t face) {
  if (geometry.kind != GeometryKind::triangles) return;
  for (const std::uint32_t vertex : geometry.triangles[face]) {
    __builtin_prefetch(&geometry.positions[vertex]);
    if (!geometry.normals.empty()) __builtin_prefetch(&geometry.normals[vertex]);
    if (!geometry.uvs[0].empty()) __builtin_prefetch(&geometry.uvs[0][vertex]);
  }
}

/// Reads a part of what surface_at() will read of most hits, and drops it. What was asked for may
/// have been pushed out again by what rays met since. Called for many hits one after the other it
/// waits for all of them at once; surface_at() and what follows it are too long for that.
inline void await_surface(const Geometry& geometry, std::uint32_t face) {
  const auto await = [](auto word) { asm volatile("" ::"r"(word)); };
  await(geometry.materials[face]);
  if (geometry.kind != GeometryKind::triangles) return;
  for (const std::uint32_t vertex : geometry.triangles[face]) {
    await(std::bit_cast<std::uint32_t>(geometry.positions[vertex][0]));
    if (!geometry.normals.empty()) await(geometry.normals[vertex]);
    if (!geometry.uvs[0].empty()) await(std::bit_cast<std::uint32_t>(geometry.uvs[0][vertex].x));
  }
}

/// The surface at `hit`, which came from `ray`.
Interaction surface_at(const Scene& scene, const Ray& ray, const accel::Hit& hit);

/// Moves a ray that leaves below the face of a hit which is rounded, so that it starts on what the
/// face stands for: over it by as much as the corners' tangent planes are (Hanika, "Hacking the
/// Shadow Terminator", Ray Tracing Gems II, 2021), but for a tilt that all corners share; its end,
/// if it has one, stays. False where nothing round stands over the face: then nothing leaves so.
bool leave_rounded(const Scene& scene, const Interaction& at, Ray& ray);

/// After so many surfaces without scattering a path ends, and nothing is left of light.
inline constexpr int passes_most = 4096;

/// The share of the surface at `at` that is not there to what passes in full or not at all, as
/// light does on its way from lights: 0…1.
inline float passing_share(const Scene& scene, const Interaction& at) {
  const CompiledMaterial& material = scene.materials[at.material];
  if (!material.has_opacity && !material.back_culled) return 0;
  return 1 - presence(material, scene.textures, at.shading);
}

/// The part of light that passes along `ray` by surfaces that are not wholly there.
Color transmittance_through(const Scene& scene, Ray ray);

/// The part of light that passes along `ray`, per channel.
inline Color transmittance(const Scene& scene, const Ray& ray) {
  if (scene.has_gaps) return transmittance_through(scene, ray);
  return scene.occluded(ray) ? Color{} : gray(1);
}

}  // namespace tessera::render
