#include <fmt/format.h>

#include <cmath>
#include <string>
#include <unordered_set>

#include "common/base/names.hpp"
#include "common/scene/parts.hpp"

namespace tessera::scene {

namespace {

constexpr double degrees_per_radian = 180.0 / 3.14159265358979323846;

constexpr double millimetres_per_metre = 1000;
constexpr int blades_least = 3, blades_most = 64;
constexpr double shift_most = 100;

constexpr std::array<std::pair<std::string_view, Projection>, 3> projections{
    {{"perspective", Projection::perspective},
     {"orthographic", Projection::orthographic},
     {"equirectangular", Projection::equirectangular}}};

void refuse(Fields& in, std::string_view key, std::string_view whose) {
  if (const auto value = in.optional(key)) value->fail(fmt::format("only {} have it", whose));
}

/// The vertical field of view, from "fov" or from a lens and the film behind it.
double read_fov(Fields& in) {
  const auto fov = in.optional("fov");
  const auto focal_length = in.optional("focal_length");
  const auto film_size = in.optional("film_size");
  if (fov && (focal_length || film_size))
    fov->fail("give the field of view by fov, or by focal_length and film_size, and not by both");
  if (fov) return fov->number(1e-3, 179.999);
  if (!focal_length && !film_size) return Camera{}.fov_y_degrees;
  const double focal = in.required("focal_length").number(direction_least, length_most);
  Vec2 film{};
  in.required("film_size").numbers(film.data(), 2, direction_least, length_most);
  return 2 * std::atan(film[1] / 2 / focal) * degrees_per_radian;
}

/// The aperture's radius, by itself or from a photographer's numbers.
double read_aperture(Fields& in) {
  const auto f_number = in.optional("f_number");
  if (!f_number) return in.number_or("aperture_radius", 0, length_most, 0);
  if (const auto radius = in.optional("aperture_radius"))
    radius->fail("give aperture_radius or f_number, and not both");
  const double stop = f_number->number(1e-3, 1e6);
  const auto focal_length = in.optional("focal_length");
  if (!focal_length) f_number->fail("an f_number needs the focal_length, in millimetres");
  return focal_length->number(direction_least, length_most) / millimetres_per_metre / (2 * stop);
}

Lens read_lens(Fields& in, double distance) {
  Lens out;
  out.radius = read_aperture(in);
  out.focus_distance = in.number_or("focus_distance", length_least, length_most, distance);
  if (const auto blades = in.optional("aperture_blades"))
    out.blades = static_cast<int>(blades->integer(blades_least, blades_most));
  out.rotation_degrees = in.number_or("aperture_rotation", -36000, 36000, 0);
  return out;
}

/// What `out` sees, and through what; its eye and target are known.
void read_optics(Fields& in, double distance, Camera& out) {
  const bool has_height = in.has("orthographic_height");
  out.projection = has_height ? Projection::orthographic : Projection::perspective;
  if (const auto projection = in.optional("projection"))
    out.projection = read_word(*projection, "projection", projections);
  if (out.projection != Projection::orthographic)
    refuse(in, "orthographic_height", "orthographic cameras");
  if (out.projection == Projection::perspective) {
    out.fov_y_degrees = read_fov(in);
  } else {
    for (const char* key : {"fov", "focal_length", "film_size", "f_number"})
      refuse(in, key, "perspective cameras");
  }
  if (out.projection == Projection::orthographic)
    out.orthographic_height = in.required("orthographic_height").number(length_least, length_most);
  if (out.projection == Projection::equirectangular) {
    for (const char* key :
         {"aperture_radius", "focus_distance", "aperture_blades", "aperture_rotation", "shift"})
      refuse(in, key, "perspective and orthographic cameras");
    return;
  }
  out.lens = read_lens(in, distance);
  if (const auto shift = in.optional("shift"))
    shift->numbers(out.shift.data(), 2, -shift_most, shift_most);
}

Camera read_camera(const Value& value, std::size_t position) {
  Fields in(value);
  Camera out;
  out.name = in.text_or("name", position == 0 ? "camera" : fmt::format("camera {}", position + 1));
  if (!is_plain_name(out.name))
    in.required("name").fail("expected 1 to 128 bytes without control characters");
  out.eye = in.required("eye").point();
  const Value target = in.required("target");
  out.target = target.point();
  const auto up = in.optional("up");
  if (up) out.up = up->point();
  const Vec3 view{out.target[0] - out.eye[0], out.target[1] - out.eye[1],
                  out.target[2] - out.eye[2]};
  const double distance = std::hypot(view[0], view[1], view[2]);
  if (!(distance >= direction_least))
    target.fail("the target is where the eye is: the camera looks nowhere");
  read_optics(in, distance, out);
  in.finish();
  const Vec3& u = out.up;
  const double size = std::hypot(u[0], u[1], u[2]);
  const double across = std::hypot(view[1] * u[2] - view[2] * u[1], view[2] * u[0] - view[0] * u[2],
                                   view[0] * u[1] - view[1] * u[0]);
  if (!(size >= direction_least) || !(across > 1e-9 * size * distance))
    up.value_or(value).fail("up has no length, or lies along the line of sight");
  return out;
}

}  // namespace

std::vector<Camera> read_cameras(Fields& root) {
  const auto one = root.optional("camera");
  const auto list = root.optional("cameras");
  if (one && list) list->fail("give camera, or the list cameras, and not both");
  if (one) return {read_camera(*one, 0)};
  if (!list) (void)root.required("camera");
  std::vector<Camera> out;
  std::unordered_set<std::string> names;
  for (const Value& value : list->items("a list of cameras")) {
    Camera camera = read_camera(value, out.size());
    if (!names.insert(camera.name).second)
      value.fail(fmt::format("two cameras have the name \"{}\"", camera.name));
    out.push_back(std::move(camera));
  }
  if (out.empty()) list->fail("expected at least one camera");
  return out;
}

}  // namespace tessera::scene
