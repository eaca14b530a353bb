#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

/// Which primitive a ray meets. Embree stands behind this; no other folder includes it.
namespace tessera::accel {

/// Layouts that are shared with Embree: plain floats, one after another.
using Point = std::array<float, 3>;
using Triangle = std::array<std::uint32_t, 3>;
/// Corners in order around; a hit's u runs from corner 0 to 1, v from corner 0 to 3.
using Quad = std::array<std::uint32_t, 4>;
struct Sphere {
  Point center{};
  float radius = 1;
};
/// Affine, row-major 3×4.
using Affine = std::array<float, 12>;

constexpr std::uint32_t none = 0xffffffffU;

/// Bits by which rays tell what they meet: a ray meets a geometry if their masks share a bit, and
/// what is in an instance if it meets both. This one meets all, and is met by all.
using Mask = std::uint32_t;
constexpr Mask everything = 0xffffffffU;

/// A segment origin + t·direction, near ≤ t ≤ far; the direction needs no particular length.
struct Ray {
  Point origin{};
  float near = 0;
  Point direction{};
  float time = 0;  ///< 0…1
  float far = 0;
};

struct Hit {
  std::uint32_t geometry = none;  ///< within its scene, in the order of add_…
  std::uint32_t primitive = none;
  std::uint32_t instance = none;  ///< none where the geometry stands in the scene itself
  float u = 0,
        v = 0;  ///< triangle: weights of corners 1 and 2; quad: along its two edges; sphere: 0
  float t = 0;
  Point ng{};  ///< not normalised, in the space of the geometry; right-handed over the corners

  [[nodiscard]] bool any() const { return geometry != none; }
};

struct DeviceConfig {
  /// The instruction set that Embree is held to. It decides bits: all workers of a job must have
  /// the same.
  std::string isa = "avx2";
};

/// One Embree device; scenes share it. Copies are handles to the same one.
class Device {
 public:
  /// Throws Error{failed} if this machine cannot run the instruction set.
  explicit Device(const DeviceConfig& config = {});

  /// Bytes that Embree holds now, and the most it ever held.
  [[nodiscard]] std::int64_t memory() const;
  [[nodiscard]] std::int64_t memory_peak() const;
  /// "embree 3.13.5 isa=avx2": goes into a worker's build id.
  [[nodiscard]] std::string version() const;

  struct State;  ///< within this folder only

 private:
  friend class Scene;
  std::shared_ptr<State> state_;
};

/// Called from building threads with the part that is done, 0…1; false asks for the build to be
/// given up.
using Progress = std::function<bool(double)>;

/// Primitives and the hierarchy over them: build once, then ask from any number of threads. Buffers
/// given to add_… are shared, not copied: they must outlive the scene, stay where they are, and
/// have 16 readable bytes behind their end (accel::Buffer has). Positions and transforms are lists
/// of time keys, spread evenly over 0…1; one key stands still. A mask other than `everything`
/// throws Error{failed} where Embree was built without masks.
class Scene {
 public:
  explicit Scene(const Device& device);
  ~Scene();
  Scene(Scene&&) noexcept;
  Scene& operator=(Scene&&) noexcept;

  /// Each returns the geometry's number: 0, 1, 2, …
  std::uint32_t add_triangles(std::span<const std::span<const Point>> position_keys,
                              std::span<const Triangle> triangles, Mask mask = everything);
  std::uint32_t add_quads(std::span<const std::span<const Point>> position_keys,
                          std::span<const Quad> quads, Mask mask = everything);
  /// The same parallelograms, of each of which only the ellipse is there that touches the middles
  /// of its edges.
  std::uint32_t add_ellipses(std::span<const std::span<const Point>> position_keys,
                             std::span<const Quad> around, Mask mask = everything);
  /// Intersected exactly, in double.
  std::uint32_t add_spheres(std::span<const Sphere> spheres, Mask mask = everything);
  /// `child` must be built, hold no instances itself, and outlive this scene. Hits name this number
  /// as their instance.
  std::uint32_t add_instance(const Scene& child, std::span<const Affine> transform_keys,
                             Mask mask = everything);

  /// Builds the hierarchy with the threads of the calling TBB arena; the result does not depend on
  /// how many there are. Throws Error{failed} for what Embree says, and when `progress` gave up.
  void build(const Progress& progress = {});

  /// The nearest hit. The scene must be built; this and all below may be called from any thread.
  [[nodiscard]] Hit intersect(const Ray& ray, Mask mask = everything) const;
  /// True if anything at all is met.
  [[nodiscard]] bool occluded(const Ray& ray, Mask mask = everything) const;
  /// The same for many rays with a mask of `everything`, hits[i] for rays[i].
  void intersect(std::span<const Ray> rays, std::span<Hit> hits) const;
  void occluded(std::span<const Ray> rays, std::span<std::uint8_t> hidden) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
  /// Embree's own handle, kept here so that a ray costs no further look-up.
  void* handle_ = nullptr;
};

}  // namespace tessera::accel
