#include "common/scene/scene_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <unordered_set>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/job/aovs.hpp"
#include "common/scene/gltf/gltf.hpp"
#include "common/scene/names.hpp"
#include "common/scene/parts.hpp"
#include "common/scene/read_file.hpp"
#include "common/scene/studio.hpp"

namespace tessera::scene {

namespace fs = std::filesystem;

fs::path Reading::use_file(const Value& value) {
  try {
    const std::string path = checked_path(value.text());
    fs::path file = files_.locate(path);
    const bool known = std::any_of(used_.begin(), used_.end(),
                                   [&](const UsedFile& used) { return used.path == path; });
    if (!known) used_.push_back({path, file});
    return file;
  } catch (const Error& error) {
    if (error.place().line != 0) throw;
    throw Error(ErrorKind::bad_input, error.message(), value.place());
  }
}

Scene Reading::load_part(const Value& file, gltf::Options options) {
  options.whole = false;
  options.moment = {.time = moment_.time, .made_up = std::nullopt};
  options.keep = keep_;
  LoadedScene part;
  attempt([&] {
    (void)use_file(file);
    part = gltf::load(files_, checked_path(file.text()), options);
  });
  duration = std::max(duration, part.duration);
  for (UsedFile& used : part.files)
    if (std::none_of(used_.begin(), used_.end(),
                     [&](const UsedFile& other) { return other.path == used.path; }))
      used_.push_back(std::move(used));
  std::move(part.warnings.begin(), part.warnings.end(), std::back_inserter(warnings));
  std::move(part.problems.begin(), part.problems.end(), std::back_inserter(problems));
  std::move(part.variants.begin(), part.variants.end(), std::back_inserter(variants));
  std::move(part.animations.begin(), part.animations.end(), std::back_inserter(animations));
  return std::move(part.scene);
}

std::string read_name(Fields& fields, std::string_view key, std::string_view kind,
                      const std::vector<std::string_view>& names) {
  const Value value = fields.required(key);
  const std::string& name = value.text();
  if (std::find(names.begin(), names.end(), name) == names.end())
    value.fail(unknown_name(kind, name, names));
  return name;
}

namespace {

constexpr int film_default = 512;
constexpr double strength_most = 1e12;

/// True if it is transparent where the camera sees nothing but surroundings.
bool read_film(Fields& root, RenderSettings& out) {
  out.width = out.height = film_default;
  const auto film = root.optional("film");
  if (!film) return false;
  Fields in(*film);
  out.width = static_cast<int>(in.required("width").integer(1, limits::film_side_max));
  out.height = static_cast<int>(in.required("height").integer(1, limits::film_side_max));
  out.pixel_aspect = in.number_or("pixel_aspect", limits::pixel_aspect_min,
                                  limits::pixel_aspect_max, out.pixel_aspect);
  const bool transparent = in.boolean_or("transparent", false);
  in.finish();
  if (static_cast<std::int64_t>(out.width) * out.height > limits::film_pixels_max)
    film->fail(fmt::format("a film of {} by {} has more than the {} pixels that a frame may have",
                           out.width, out.height, limits::film_pixels_max));
  return transparent;
}

template <class Names>
std::string name_or(Fields& in, std::string_view kind, const Names& names,
                    const std::string& fallback) {
  if (!in.optional(kind)) return fallback;
  return read_name(in, kind, kind, {names.begin(), names.end()});
}

/// [x, y, width, height]. A film of another size, by command line, is looked at when the job is.
Rect read_crop(const Value& value, const RenderSettings& film) {
  const char* const expected = "[x, y, width, height], whole numbers of pixels";
  const std::vector<Value> items = value.items(expected);
  if (items.size() != 4) value.fail_expected(expected);
  const auto pixels = [&](std::size_t item, int least) {
    return static_cast<int>(items[item].integer(least, limits::film_side_max));
  };
  const Rect out{pixels(0, 0), pixels(1, 0), pixels(2, 1), pixels(3, 1)};
  if (out.x + out.width > film.width || out.y + out.height > film.height)
    value.fail(fmt::format("expected [x, y, width, height] within the film of {} by {}", film.width,
                           film.height));
  return out;
}

std::vector<std::string> read_aovs(const Value& list) {
  std::vector<std::string> names;
  for (const Value& name : list.items("a list of names")) names.push_back(name.text());
  try {
    static_cast<void>(aov_uses(names));
  } catch (const Error& error) {
    list.fail(error.message());
  }
  return names;
}

void read_render(Fields& root, RenderSettings& out) {
  const auto render = root.optional("render");
  if (!render) return;
  Fields in(*render);
  out.samples = in.integer_or("samples", 1, limits::samples_max, out.samples);
  out.bounces = static_cast<int>(in.integer_or("bounces", 0, limits::bounces_max, out.bounces));
  out.integrator = name_or(in, "integrator", integrator_names, out.integrator);
  out.sampler = name_or(in, "sampler", sampler_names, out.sampler);
  out.filter = name_or(in, "filter", filter_names, out.filter);
  out.filter_width = in.number_or("filter_width", 0, 64, out.filter_width);
  out.light_samples = static_cast<int>(
      in.integer_or("light_samples", 1, limits::light_samples_max, out.light_samples));
  out.seed = static_cast<std::uint64_t>(in.integer_or("seed", 0, INT64_MAX, 0));
  out.clamp_direct = in.number_or("clamp_direct", 0, limits::clamp_max, 0);
  out.clamp_indirect = in.number_or("clamp_indirect", 0, limits::clamp_max, 0);
  if (const auto crop = in.optional("crop")) out.crop = read_crop(*crop, out);
  if (const auto aovs = in.optional("aovs")) out.aovs = read_aovs(*aovs);
  out.aovs_follow_specular = in.boolean_or("aovs_follow_specular", out.aovs_follow_specular);
  in.finish();
}

/// What a scene says of its surroundings.
struct Surroundings {
  std::optional<Environment> environment;
  bool studio = false;  ///< turned with the camera, which is not known yet
};

Surroundings read_environment(Fields& root, Reading& reading) {
  const auto environment = root.optional("environment");
  if (!environment) return {};
  Fields in(*environment);
  Environment out;
  const bool studio = in.boolean_or("studio", false);
  const auto file = in.optional("file");
  const auto radiance = in.optional("radiance");
  if ((studio ? 1 : 0) + (file ? 1 : 0) + (radiance ? 1 : 0) > 1)
    environment->fail(
        "radiance, file and studio exclude each other: an environment is a colour, a picture or "
        "the studio's light");
  out.radiance = {1, 1, 1};
  if (file)
    out.image = reading.use_image(*file);
  else if (!studio)
    out.radiance = in.required("radiance").color(radiance_most);
  out.strength = in.number_or("strength", 0, strength_most, out.strength);
  out.rotation_degrees = in.number_or("rotation", -36000, 36000, 0);
  out.light_group = read_light_group(in);
  in.finish();
  return {.environment = out, .studio = studio};
}

/// What a picture of included files needs, and neither they nor the scene have.
void fill_in(Reading& reading, Scene& out) {
  const double aspect =
      out.render.pixel_aspect * out.render.width / static_cast<double>(out.render.height);
  reading.made_up = make_up(out, aspect, reading.moment().made_up);
  if (reading.made_up.camera)
    reading.warnings.emplace_back("the scene has no camera: this one shows all of it");
  if (reading.made_up.light)
    reading.warnings.emplace_back("the scene has no light: it is given that of a studio");
}

Scene read_scene(const Value& value, Reading& reading) {
  Fields root(value);
  (void)root.required("tessera").integer(1, 1);  // the version of the format
  Scene out;
  out.name = root.text_or("name", "");
  if (!out.name.empty() && !is_plain_name(out.name))
    root.required("name").fail("expected a name of at most 128 bytes without control characters");
  (void)root.text_or("about", "");
  reading.film_transparent = out.film_transparent = read_film(root, out.render);
  read_render(root, out.render);
  const auto include = root.optional("include");
  if (!include || root.has("camera") || root.has("cameras")) out.cameras = read_cameras(root);
  const Surroundings surroundings = read_environment(root, reading);
  out.environment = surroundings.environment;
  if (const auto lights = root.optional("lights")) out.lights = read_lights(*lights);
  if (const auto textures = root.optional("textures")) read_textures(*textures, reading);
  if (const auto materials = root.optional("materials"))
    reading.materials = read_materials(*materials, reading);
  // What is included has pictures and textures of its own, which come behind these.
  out.images = std::move(reading.images);
  out.textures = std::move(reading.textures);
  if (include) read_includes(*include, reading, out);
  if (const auto shapes = root.optional("shapes"))
    for (Shape& shape : read_shapes(*shapes, reading)) out.shapes.push_back(std::move(shape));
  const std::size_t included = out.objects.size();
  if (const auto objects = root.optional("objects"))
    for (Object& object : read_objects(*objects, reading)) out.objects.push_back(std::move(object));
  if (const auto instances = root.optional("instances"))
    read_instances(*instances, included, reading, out);
  out.materials = std::move(reading.materials);
  read_light_groups(root, out);
  root.finish();
  if (include) fill_in(reading, out);
  if (surroundings.studio)
    add_studio(out,
               reading.moment().made_up ? reading.moment().made_up->view : out.cameras.front());
  return out;
}

Scene parse(std::string text, const std::string& name, Reading& reading) {
  const Document document(std::move(text), name);
  const Value root(document, 0);
  if (root.kind() != Kind::object) root.fail_expected("an object");
  return read_scene(root, reading);
}

LoadedScene load(const SceneFiles& files, const std::string& path, const Moment& moment,
                 Keep keep) {
  const std::string checked = checked_path(path);
  if (gltf::is_gltf(checked)) return gltf::load(files, checked, {.moment = moment, .keep = keep});
  const fs::path file = files.locate(checked);
  const std::string name = files.shown(checked);
  Reading reading(files, moment, keep);
  LoadedScene out;
  out.scene = parse(read_file(file, name, limits::scene_json_bytes), name, reading);
  out.files.push_back({checked, file});
  for (const UsedFile& used : reading.used())
    if (used.path != checked) out.files.push_back(used);
  out.duration = reading.duration;
  out.made_up = reading.made_up;
  out.problems = std::move(reading.problems);
  out.warnings = std::move(reading.warnings);
  out.variants = std::move(reading.variants);
  out.animations = std::move(reading.animations);
  return out;
}

}  // namespace

Error as_one(const std::vector<Error>& problems) {
  constexpr std::size_t listed_most = 100;
  std::unordered_set<std::string> said;  // a file may be named at several places
  std::string list;
  for (const Error& problem : problems)
    if (said.insert(problem.what()).second && said.size() <= listed_most)
      list += fmt::format("\n  {}", problem.what());
  if (said.size() == 1) return problems.front();
  if (said.size() > listed_most) list += fmt::format("\n  and {} more", said.size() - listed_most);
  return {ErrorKind::bad_input, fmt::format("{} files cannot be used:{}", said.size(), list)};
}

LoadedScene survey_scene(const SceneFiles& files, const std::string& path) {
  return load(files, path, Moment{}, Keep::outlines);
}

LoadedScene load_scene(const SceneFiles& files, const std::string& path, const Moment& moment) {
  LoadedScene out = load(files, path, moment, Keep::meshes);
  if (!out.problems.empty()) throw as_one(out.problems);
  return out;
}

LoadedScene load_scene(const fs::path& file) {
  return load_scene(FolderFiles(file.parent_path()), file.filename().string());
}

Scene parse_scene(std::string_view text, const std::string& name, const SceneFiles& files) {
  Reading reading(files, Moment{}, Keep::meshes);
  Scene out = parse(std::string(text), name, reading);
  if (!reading.problems.empty()) throw as_one(reading.problems);
  return out;
}

}  // namespace tessera::scene
