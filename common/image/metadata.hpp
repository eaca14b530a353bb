#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "common/base/clock.hpp"
#include "common/job/job_spec.hpp"

namespace tessera::image {

/// Row-major 4×4 matrix, for row vectors, as OpenEXR's m44f.
using Matrix = std::array<float, 16>;

/// What an attribute of an EXR header can hold here. A number beyond 32 bits (a seed) is written as
/// text.
using AttributeValue = std::variant<std::string, std::int32_t, float, double, Matrix>;

/// What a picture's header says of how it was made: named values in the order in which they were
/// first set. Equal metadata gives equal bytes. Which values are usual: tessera.scene (the bundle's
/// digest), tessera.camera, tessera.frame, tessera.seed, tessera.samples, tessera.integrator,
/// tessera.light_samples, tessera.clamp_direct and tessera.clamp_indirect (where light was
/// clamped), tessera.sampler, tessera.filter, tessera.bounces, tessera.build,
/// tessera.render_seconds (wall clock, from the job's first lease to its last fold),
/// tessera.cpu_seconds (CPU time of the threads that rendered, summed over all of the job's
/// results: what the samples cost, whoever else used the machines), and of OpenEXR's own: software,
/// comments, owner, capDate, utcOffset, worldToCamera, worldToNDC.
class Metadata {
 public:
  struct Attribute {
    std::string name;
    AttributeValue value;
    bool operator==(const Attribute&) const = default;
  };

  /// Adds, or replaces a value of the same name. The name has 1 to 31 bytes and is none of those
  /// that say how the file is laid out (channels, dataWindow, chromaticities, …): anything else is
  /// a mistake of the caller's, Error{failed}.
  void set(std::string_view name, AttributeValue value);
  /// The value, or nullptr.
  [[nodiscard]] const AttributeValue* find(std::string_view name) const;
  /// The value as a person reads it, numbers in decimal; empty if it is not there.
  [[nodiscard]] std::string text(std::string_view name) const;
  [[nodiscard]] const std::vector<Attribute>& attributes() const { return attributes_; }
  /// Width of a pixel over its height: OpenEXR's pixelAspectRatio, which every file has.
  void set_pixel_aspect(float ratio) { pixel_aspect_ = ratio; }
  [[nodiscard]] float pixel_aspect() const { return pixel_aspect_; }
  bool operator==(const Metadata&) const = default;

 private:
  float pixel_aspect_ = 1;
  std::vector<Attribute> attributes_;
};

/// All that the job says of one of its frames, and `software`. The caller adds what it knows
/// besides: tessera.build, tessera.render_seconds, tessera.cpu_seconds, capDate.
Metadata metadata_of(const JobSpec& job, std::int32_t frame);

/// capDate ("YYYY:MM:DD hh:mm:ss", in UTC) and utcOffset 0.
void set_date(Metadata& metadata, UnixMillis when);

}  // namespace tessera::image
