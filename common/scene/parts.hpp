#pragma once
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/names.hpp"
#include "common/scene/description.hpp"
#include "common/scene/fields.hpp"
#include "common/scene/gltf/gltf.hpp"
#include "common/scene/scene_file.hpp"

/// How each part of a scene file is read. One table for materials, one for shapes: a new type is
/// one reader and one line.
namespace tessera::scene {

/// A texture as it stands in the file: what its texels mean follows from the input that it feeds,
/// unless the file says it.
struct TextureSource {
  Texture texture;
  std::optional<ColorSpace> color_space;
};

/// What reading a shape may need beside its own keys.
class Reading {
 public:
  Reading(const SceneFiles& files, Moment moment, Keep keep)
      : files_(files), moment_(std::move(moment)), keep_(keep) {}

  /// Where the file that `value` names is; notes that the scene uses it. Throws at `value` if there
  /// is none.
  std::filesystem::path use_file(const Value& value);
  /// A glTF file that `value` names, without what would be made up for it; its files and warnings
  /// join this scene's. `options` say its variant and units.
  Scene load_part(const Value& file, gltf::Options options);
  /// The name of a file of the scene, for errors.
  [[nodiscard]] std::string shown(const std::string& path) const { return files_.shown(path); }
  [[nodiscard]] const Moment& moment() const { return moment_; }
  [[nodiscard]] Keep keep() const { return keep_; }
  [[nodiscard]] const std::vector<UsedFile>& used() const { return used_; }

  /// Calls `read`, which reads a file; false, and a problem more, if it throws an Error.
  template <class Read>
  bool attempt(const Read& read) {
    try {
      read();
      return true;
    } catch (const Error& error) {
      problems.push_back(error);
      return false;
    }
  }

  /// The picture in the file that `value` names, each file once; 0 and a problem more if there is
  /// none.
  std::uint32_t use_image(const Value& value);
  /// A texture that an input uses: its index in `textures`. `meant` is what the input's texels mean
  /// where the texture does not say it.
  std::uint32_t add_texture(const TextureSource& source, ColorSpace meant);
  /// The one of that name, among the scene's `textures`.
  std::uint32_t use_texture(const Value& name, ColorSpace meant);
  void name_texture(const std::string& name, const TextureSource& source) {
    named_textures_.emplace_back(name, source);
  }

  bool film_transparent = false;  ///< read before whatever may need it
  std::vector<Material> materials;
  std::vector<std::string> warnings, variants, animations;
  std::vector<Error> problems;  ///< of files, as in LoadedScene
  std::vector<Image> images;
  std::vector<Texture> textures;
  double duration = 0;  ///< this and the next as in LoadedScene
  MadeUp made_up;

 private:
  const SceneFiles& files_;
  Moment moment_;
  Keep keep_;
  std::vector<UsedFile> used_;
  std::vector<std::pair<std::string, TextureSource>> named_textures_;
};

/// An object of textures by name.
void read_textures(const Value& textures, Reading& reading);

/// A texture's name; or an object with `texture`, a name, or with `file`, `color_space`, `wrap`,
/// `filter`; and `uv_set`, `offset`, `scale`, `rotation`. `meant`: what the texels mean unless the
/// texture says it.
TextureUse read_texture_use(const Value& value, Reading& reading, ColorSpace meant);

/// A colour within 0 … high, or a texture's name, or such an object with `factor`.
ColorInput color_input_or(Fields& fields, std::string_view key, double high,
                          const ColorInput& fallback, Reading& reading);
/// A number within low … high, or a texture's name, or such an object with `factor` and `channel`
/// ("r", "g", "b", "a").
ScalarInput scalar_input_or(Fields& fields, std::string_view key, double low, double high,
                            const ScalarInput& fallback, Reading& reading);

/// A texture's name, or such an object with `strength`.
NormalMap read_normal_map(const Value& value, Reading& reading);
/// A texture's name, or such an object with `height`.
BumpMap read_bump_map(const Value& value, Reading& reading);

/// A list of steps, the first applied first. Throws if the whole is singular.
Transform read_transform(const Value& steps);

/// An object of materials by name, in the order in which they stand.
std::vector<Material> read_materials(const Value& materials, Reading& reading);

/// A list of shapes; their materials are looked up in `reading`.
std::vector<Shape> read_shapes(const Value& shapes, Reading& reading);

/// A member `visibility` of a shape, an object, an instance or an included file.
Visibility read_visibility(Fields& in, const Reading& reading);
/// Throws at `place` if what is placed there would be both a holdout and a shadow catcher.
void check_visibility(const Visibility& visibility, const Value& place);

/// The text at `value`, which must be a plain name (names.hpp).
const std::string& plain_name(const Value& value);

/// An object of objects by name.
std::vector<Object> read_objects(const Value& objects, Reading& reading);
/// A list of instances of the scene's objects, of which its own begin at `first`, behind those that
/// were included: they join the scene's.
void read_instances(const Value& instances, std::size_t first, const Reading& reading, Scene& out);

/// Throws at `place` if `shape`, which `to_world` brings into the world, can not stand there: a
/// sphere that emits and becomes an ellipsoid, or what is made flat.
void check_placed(const Shape& shape, const Transform& to_world, const Reading& reading,
                  const Value& place);

/// The keys of a mesh, inline or from a file.
Mesh read_mesh(Fields& fields, Reading& reading);

/// `camera`, or the list `cameras`: exactly one of the two keys must be there.
std::vector<Camera> read_cameras(Fields& root);

/// The meaning of the word at `value`, or an error that names the nearest.
template <class Meaning, std::size_t Size>
Meaning read_word(const Value& value, std::string_view kind,
                  const std::array<std::pair<std::string_view, Meaning>, Size>& words) {
  std::vector<std::string_view> names;
  for (const auto& [name, meaning] : words) {
    if (name == value.text()) return meaning;
    names.push_back(name);
  }
  value.fail(unknown_name(kind, value.text(), names));
}

/// A list of glTF files whose parts join the scene: materials stand in `reading` behind its own.
/// The scene's materials, cameras and lights take the place of included ones of their names.
void read_includes(const Value& list, Reading& reading, Scene& out);

/// A member `group` of what emits; empty for the default group.
std::string read_light_group(Fields& in);
/// `light_groups`, an object of lists: names of lights and emitting materials, or "environment", by
/// group.
void read_light_groups(Fields& root, Scene& out);

/// A list of lights without a size.
std::vector<PunctualLight> read_lights(const Value& lights);

/// The name at `key` must be one of `names`; throws at its value otherwise.
std::string read_name(Fields& fields, std::string_view key, std::string_view kind,
                      const std::vector<std::string_view>& names);

}  // namespace tessera::scene
