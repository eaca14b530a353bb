#include "scenes/generate/gltf_file.hpp"

#include <algorithm>
#include <string_view>

#include "common/base/files.hpp"

namespace tessera::generate {

using nlohmann::json;

namespace {

void append_word(std::vector<std::byte>& to, std::size_t value) {
  for (unsigned shift = 0; shift < 32; shift += 8)
    to.push_back(static_cast<std::byte>((value >> shift) & 0xff));
}

/// A chunk of a .glb: its length, its kind, and the bytes, padded to a multiple of four.
void append_chunk(std::vector<std::byte>& to, std::size_t kind, std::span<const std::byte> bytes,
                  char padding) {
  const std::size_t padded = (bytes.size() + 3) / 4 * 4;
  append_word(to, padded);
  append_word(to, kind);
  to.insert(to.end(), bytes.begin(), bytes.end());
  to.insert(to.end(), padded - bytes.size(), static_cast<std::byte>(padding));
}

}  // namespace

GltfFile::GltfFile(const std::string& scene)
    : json_{{"asset", {{"version", "2.0"}, {"generator", "tessera-scenes"}}},
            {"scene", 0},
            {"scenes", json::array({{{"name", scene}, {"nodes", json::array()}}})}} {}

int GltfFile::add(const char* list, json object) {
  json_[list].push_back(std::move(object));
  return static_cast<int>(json_[list].size()) - 1;
}

void GltfFile::add_node(json node) {
  const int number = add("nodes", std::move(node));
  json_["scenes"][0]["nodes"].push_back(number);
}

void GltfFile::place(const std::string& name, json primitives, json node) {
  node["name"] = name;
  node["mesh"] = add("meshes", {{"name", name}, {"primitives", std::move(primitives)}});
  add_node(std::move(node));
}

int GltfFile::positions(const std::vector<std::array<float, 3>>& values) {
  const int number = accessor(values, Target::vertices);
  auto low = values.at(0), high = low;
  for (const auto& p : values)
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
  json_["accessors"].back()["min"] = low;
  json_["accessors"].back()["max"] = high;
  return number;
}

int GltfFile::texture(const std::string& name, std::span<const std::byte> png) {
  if (!json_.contains("samplers"))
    (void)add("samplers", {{"magFilter", 9729}, {"minFilter", 9987}});  // linear, with mip maps
  const int image =
      add("images",
          {{"name", name}, {"bufferView", view(png, Target::other)}, {"mimeType", "image/png"}});
  return add("textures", {{"sampler", 0}, {"source", image}});
}

int GltfFile::view(std::span<const std::byte> bytes, Target target) {
  json out{{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", bytes.size()}};
  if (target != Target::other) out["target"] = target;
  bytes_.insert(bytes_.end(), bytes.begin(), bytes.end());
  bytes_.resize((bytes_.size() + 3) / 4 * 4);
  return add("bufferViews", std::move(out));
}

void GltfFile::write_gltf(const std::filesystem::path& folder, const std::string& name) {
  json_["buffers"] = json::array({{{"uri", name + ".bin"}, {"byteLength", bytes_.size()}}});
  write_file_atomically(folder / (name + ".bin"), bytes_);
  write_file_atomically(folder / (name + ".gltf"), std::string_view(json_.dump(1) + "\n"));
}

void GltfFile::write_glb(const std::filesystem::path& folder, const std::string& name) {
  json_["buffers"] = json::array({{{"byteLength", bytes_.size()}}});
  const std::string text = json_.dump();
  std::vector<std::byte> out;
  append_word(out, 0x46546c67);  // "glTF"
  append_word(out, 2);
  const std::size_t header = 12 + 8 + (text.size() + 3) / 4 * 4 + 8;
  append_word(out, header + bytes_.size());
  out.reserve(header + bytes_.size());
  append_chunk(out, 0x4e4f534a, std::as_bytes(std::span(text)), ' ');  // "JSON"
  append_chunk(out, 0x004e4942, bytes_, '\0');                         // "BIN"
  write_file_atomically(folder / (name + ".glb"), out);
}

}  // namespace tessera::generate
