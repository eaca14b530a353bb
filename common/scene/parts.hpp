#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "common/scene/description.hpp"
#include "common/scene/fields.hpp"
#include "common/scene/scene_file.hpp"

/// How each part of a scene file is read. One table for materials, one for shapes: a new type is
/// one reader and one line.
namespace tessera::scene {

/// What reading a shape may need beside its own keys.
class Reading {
 public:
  Reading(const SceneFiles& files, bool meshes) : files_(files), meshes_(meshes) {}

  /// Where the file that `value` names is; notes that the scene uses it. Throws at `value` if there
  /// is none.
  std::filesystem::path use_file(const Value& value);
  /// A glTF file that `value` names, without what would be made up for it; its files and warnings
  /// join this scene's.
  Scene load_part(const Value& file);
  /// The name of a file of the scene, for errors.
  [[nodiscard]] std::string shown(const std::string& path) const { return files_.shown(path); }
  /// False if mesh files need only be there.
  [[nodiscard]] bool meshes() const { return meshes_; }
  [[nodiscard]] const std::vector<UsedFile>& used() const { return used_; }

  std::vector<Material> materials;
  std::vector<std::string> warnings;

 private:
  const SceneFiles& files_;
  bool meshes_;
  std::vector<UsedFile> used_;
};

/// A list of steps, the first applied first. Throws if the whole is singular.
Transform read_transform(const Value& steps);

/// An object of materials by name, in the order in which they stand.
std::vector<Material> read_materials(const Value& materials);

/// A list of shapes; their materials are looked up in `reading`.
std::vector<Shape> read_shapes(const Value& shapes, Reading& reading);

/// Throws at `place` if `shape`, which `to_world` brings into the world, can not stand there: a
/// sphere that emits and becomes an ellipsoid, or what is made flat.
void check_placed(const Shape& shape, const Transform& to_world, const Reading& reading,
                  const Value& place);

/// The keys of a mesh, inline or from a file.
Mesh read_mesh(Fields& fields, Reading& reading);

/// `camera`, or the list `cameras`: exactly one of the two keys must be there.
std::vector<Camera> read_cameras(Fields& root);

/// A list of glTF files whose parts join the scene: materials stand in `reading` behind its own.
/// The scene's materials, cameras and lights take the place of included ones of their names.
void read_includes(const Value& list, Reading& reading, Scene& out);

/// A list of lights without a size.
std::vector<PunctualLight> read_lights(const Value& lights);

/// The name at `key` must be one of `names`; throws at its value otherwise.
std::string read_name(Fields& fields, std::string_view key, std::string_view kind,
                      const std::vector<std::string_view>& names);

}  // namespace tessera::scene
