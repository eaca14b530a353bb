#include <fmt/format.h>
#include <immintrin.h>

#include <cassert>
#include <cstddef>
#include <limits>
#include <vector>

#include "common/base/error.hpp"
#include "worker/accel/accel.hpp"
#include "worker/accel/device.hpp"
#include "worker/accel/spheres.hpp"

namespace tessera::accel {

struct Scene::State {
  std::shared_ptr<Device::State> device;
  RTCScene scene = nullptr;
  std::uint32_t count = 0;

  explicit State(std::shared_ptr<Device::State> from) : device(std::move(from)) {}
  State(const State&) = delete;
  State& operator=(const State&) = delete;
  ~State() {
    if (scene != nullptr) rtcReleaseScene(scene);
  }

  std::uint32_t attach(RTCGeometry geometry, Mask mask) {
    if (mask != everything) device->require_masks();
    // Embree 3 and 4 do not agree on what a geometry has that is given none.
    rtcSetGeometryMask(geometry, mask);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, count);
    rtcReleaseGeometry(geometry);
    device->check("new geometry");
    return count++;
  }
  std::uint32_t add_mesh(RTCGeometryType type, RTCFormat format,
                         std::span<const std::span<const Point>> keys, const void* indices,
                         std::size_t count_of, std::size_t stride, Mask mask,
                         RTCFilterFunctionN filter = nullptr) {
    assert(!keys.empty());
    RTCGeometry geometry = rtcNewGeometry(device->handle, type);
    rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(keys.size()));
    for (unsigned key = 0; key < keys.size(); ++key) {
      rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, key, RTC_FORMAT_FLOAT3,
                                 keys[key].data(), 0, sizeof(Point), keys[key].size());
    }
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, format, indices, 0, stride,
                               count_of);
    rtcSetGeometryIntersectFilterFunction(geometry, filter);
    rtcSetGeometryOccludedFilterFunction(geometry, filter);
    return attach(geometry, mask);
  }
};

Scene::Scene(const Device& device) : state_(std::make_unique<State>(device.state_)) {
  state_->scene = rtcNewScene(device.state_->handle);
  device.state_->check("new scene");
  rtcSetSceneFlags(state_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(state_->scene, RTC_BUILD_QUALITY_MEDIUM);
  handle_ = state_->scene;
}
Scene::~Scene() = default;
Scene::Scene(Scene&&) noexcept = default;
Scene& Scene::operator=(Scene&&) noexcept = default;

std::uint32_t Scene::add_triangles(std::span<const std::span<const Point>> position_keys,
                                   std::span<const Triangle> triangles, Mask mask) {
  return state_->add_mesh(RTC_GEOMETRY_TYPE_TRIANGLE, RTC_FORMAT_UINT3, position_keys,
                          triangles.data(), triangles.size(), sizeof(Triangle), mask);
}

std::uint32_t Scene::add_quads(std::span<const std::span<const Point>> position_keys,
                               std::span<const Quad> quads, Mask mask) {
  return state_->add_mesh(RTC_GEOMETRY_TYPE_QUAD, RTC_FORMAT_UINT4, position_keys, quads.data(),
                          quads.size(), sizeof(Quad), mask);
}

namespace {
/// Lets a ray pass where it meets a parallelogram outside the ellipse within.
void keep_ellipse(const RTCFilterFunctionNArguments* args) {
  assert(args->N == 1);
  const float x = 2 * RTCHitN_u(args->hit, 1, 0) - 1, y = 2 * RTCHitN_v(args->hit, 1, 0) - 1;
  if (x * x + y * y > 1) args->valid[0] = 0;
}
}  // namespace

std::uint32_t Scene::add_ellipses(std::span<const std::span<const Point>> position_keys,
                                  std::span<const Quad> around, Mask mask) {
  return state_->add_mesh(RTC_GEOMETRY_TYPE_QUAD, RTC_FORMAT_UINT4, position_keys, around.data(),
                          around.size(), sizeof(Quad), mask, keep_ellipse);
}

std::uint32_t Scene::add_spheres(std::span<const Sphere> spheres, Mask mask) {
  RTCGeometry geometry = rtcNewGeometry(state_->device->handle, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(spheres.size()));
  // Embree's handlers take the pointer as mutable and hand it back; nobody writes through it.
  rtcSetGeometryUserData(geometry, const_cast<Sphere*>(spheres.data()));
  rtcSetGeometryBoundsFunction(geometry, sphere_bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, sphere_intersect);
  rtcSetGeometryOccludedFunction(geometry, sphere_occluded);
  return state_->attach(geometry, mask);
}

std::uint32_t Scene::add_instance(const Scene& child, std::span<const Affine> transform_keys,
                                  Mask mask) {
  assert(!transform_keys.empty());
  RTCGeometry geometry = rtcNewGeometry(state_->device->handle, RTC_GEOMETRY_TYPE_INSTANCE);
  rtcSetGeometryInstancedScene(geometry, child.state_->scene);
  rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(transform_keys.size()));
  for (unsigned key = 0; key < transform_keys.size(); ++key) {
    rtcSetGeometryTransform(geometry, key, RTC_FORMAT_FLOAT3X4_ROW_MAJOR,
                            transform_keys[key].data());
  }
  return state_->attach(geometry, mask);
}

void Scene::build(const Progress& progress) {
  const auto report = [](void* user, double done) {
    return (*static_cast<const Progress*>(user))(done);
  };
  if (progress) {
    rtcSetSceneProgressMonitorFunction(state_->scene, report, const_cast<Progress*>(&progress));
  }
  rtcCommitScene(state_->scene);
  rtcSetSceneProgressMonitorFunction(state_->scene, nullptr, nullptr);
  state_->device->check("build");
}

namespace {

/// Written by fours, as Embree reads it: four separate writes would have to reach the cache first.
void to_embree(const Ray& ray, Mask mask, RTCRay& out) {
  static_assert(offsetof(RTCRay, tnear) == 12 && offsetof(RTCRay, dir_x) == 16 &&
                offsetof(RTCRay, time) == 28);
  _mm_store_ps(&out.org_x, _mm_setr_ps(ray.origin[0], ray.origin[1], ray.origin[2], ray.near));
  _mm_store_ps(&out.dir_x,
               _mm_setr_ps(ray.direction[0], ray.direction[1], ray.direction[2], ray.time));
  out.tfar = ray.far;
  out.mask = mask;
  out.id = 0;
  out.flags = 0;
}

Hit intersect_one(RTCScene scene, const Ray& ray, Mask mask) {
  RTCRayHit both;
  to_embree(ray, mask, both.ray);
  both.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  both.hit.primID = RTC_INVALID_GEOMETRY_ID;
  both.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  embree::intersect(scene, both);
  Hit hit;
  if (both.hit.geomID == RTC_INVALID_GEOMETRY_ID) return hit;
  hit.geometry = both.hit.geomID;
  hit.primitive = both.hit.primID;
  hit.instance = both.hit.instID[0];
  hit.u = both.hit.u;
  hit.v = both.hit.v;
  hit.t = both.ray.tfar;
  hit.ng = {both.hit.Ng_x, both.hit.Ng_y, both.hit.Ng_z};
  return hit;
}

bool occluded_one(RTCScene scene, const Ray& ray, Mask mask) {
  RTCRay copy;
  to_embree(ray, mask, copy);
  embree::occluded(scene, copy);
  return copy.tfar < 0;
}

}  // namespace

Hit Scene::intersect(const Ray& ray, Mask mask) const {
  return intersect_one(static_cast<RTCScene>(handle_), ray, mask);
}

bool Scene::occluded(const Ray& ray, Mask mask) const {
  return occluded_one(static_cast<RTCScene>(handle_), ray, mask);
}

void Scene::intersect(std::span<const Ray> rays, std::span<Hit> hits) const {
  assert(hits.size() >= rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    hits[i] = intersect_one(static_cast<RTCScene>(handle_), rays[i], everything);
  }
}

void Scene::occluded(std::span<const Ray> rays, std::span<std::uint8_t> hidden) const {
  assert(hidden.size() >= rays.size());
  for (std::size_t i = 0; i < rays.size(); ++i) {
    hidden[i] = occluded_one(static_cast<RTCScene>(handle_), rays[i], everything) ? 1 : 0;
  }
}

}  // namespace tessera::accel
