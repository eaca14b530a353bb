#include "common/scene/gltf/asset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>

#include "common/base/limits.hpp"
#include "common/base/names.hpp"
#include "common/scene/gltf/check.hpp"
#include "common/scene/gltf/container.hpp"
#include "common/scene/gltf/uri.hpp"

namespace tessera::scene::gltf {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t warnings_most = 50;

constexpr std::array<std::string_view, 16> known_extensions{
    "KHR_materials_variants",     "KHR_lights_punctual",
    "KHR_texture_transform",      "KHR_mesh_quantization",
    "KHR_materials_transmission", "KHR_materials_ior",
    "KHR_materials_volume",       "KHR_materials_emissive_strength",
    "KHR_materials_specular",     "KHR_materials_clearcoat",
    "KHR_materials_anisotropy",   "KHR_materials_unlit",
    "EXT_mesh_gpu_instancing",    "EXT_texture_webp",
    "EXT_meshopt_compression",    "KHR_draco_mesh_compression"};

/// The files that a glTF file names, and the bytes that it holds itself.
class Gatherer {
 public:
  Gatherer(const SceneFiles& files, const std::string& path, Asset& asset)
      : files_(files), folder_(fs::path(path).parent_path().generic_string()), asset_(asset) {}

  Bytes buffer(const BufferEntry& entry, const std::optional<FileRange>& binary,
               const std::string& place) {
    Bytes out;
    if (entry.uri) {
      out = named(*entry.uri);
    } else if (entry.fallback) {
      return std::make_shared<const std::vector<std::byte>>();
    } else {
      if (!binary) asset_.fail(place, "has no uri, and the file has no binary chunk");
      out = *binary;
    }
    const std::uint64_t there = size_of(out);
    if (there < entry.bytes)
      asset_.fail(
          place + "/byteLength",
          fmt::format("says {} bytes, and there are {}: the file is cut off", entry.bytes, there));
    return out;
  }

  Bytes named(const Uri& uri) {
    try {
      if (auto bytes = decode_data_uri(uri.text))
        return std::make_shared<const std::vector<std::byte>>(std::move(*bytes));
      const std::string relative = path_of_uri(uri.text);
      const std::string path = checked_path(
          folder_.empty() || relative.starts_with('/') ? relative : folder_ + "/" + relative);
      FileRange out{.file = files_.locate(path)};
      const bool known = std::any_of(asset_.files.begin(), asset_.files.end(),
                                     [&](const UsedFile& used) { return used.path == path; });
      if (!known) asset_.files.push_back({path, out.file});
      return out;
    } catch (const Error& error) {
      asset_.fail(uri.place, error.message());
    }
  }

  /// Calls `read`, which reads what a file holds; a problem more if it throws.
  template <class Read>
  void attempt(const Read& read) {
    try {
      read();
    } catch (const Error& error) {
      asset_.problems.push_back(error);
    }
  }

  static std::uint64_t size_of(const Bytes& bytes) {
    if (const auto* range = std::get_if<FileRange>(&bytes))
      return range->size != 0 ? range->size : fs::file_size(range->file);
    return std::get<1>(bytes)->size();
  }

 private:
  const SceneFiles& files_;
  std::string folder_;
  Asset& asset_;
};

void parse(const std::string& text, Asset& asset) {
  tinygltf::TinyGLTF parser;
  std::string problem, remark;
  if (!parser.LoadASCIIFromString(&asset.model, &problem, &remark, text.data(),
                                  static_cast<unsigned int>(text.size()), ""))
    asset.fail("", fmt::format("not a good glTF file: {}", excerpt(problem, 300)));
}

void check_extensions(const CheckedJson& checked, Asset& asset) {
  const auto known = [](const std::string& name) {
    return std::find(known_extensions.begin(), known_extensions.end(), name) !=
           known_extensions.end();
  };
  const auto& required = checked.extensions_required;
  for (std::size_t i = 0; i < required.size(); ++i)
    if (!known(required[i]))
      asset.fail(fmt::format("/extensionsRequired/{}", i),
                 fmt::format("the file cannot be shown without \"{}\", which is not supported",
                             excerpt(required[i])));
  for (const std::string& used : checked.extensions_used)
    if (!known(used))
      asset.warn(fmt::format("extension {} is not supported, and passed over", excerpt(used)));
}

/// So that no length is believed that has no bytes behind it.
void check_views(const Asset& asset) {
  for (std::size_t i = 0; i < asset.model.bufferViews.size(); ++i) {
    const tinygltf::BufferView& view = asset.model.bufferViews[i];
    if (extension(view.extensions, "EXT_meshopt_compression") != nullptr) continue;
    const std::uint64_t there = asset.buffer_bytes[static_cast<std::size_t>(view.buffer)];
    if (view.byteOffset > there || view.byteLength > there - view.byteOffset)
      asset.fail(fmt::format("/bufferViews/{}", i),
                 fmt::format("{} bytes from {} on; /buffers/{} has {}", view.byteLength,
                             view.byteOffset, view.buffer, there));
  }
}

Image image_of(const ImageEntry& entry, std::size_t number, Asset& asset, Gatherer& gatherer) {
  const std::string place = fmt::format("/images/{}", number);
  Image out{.name = asset.name + ": " + place, .encoded = {}};
  if (entry.uri) {
    out.encoded = gatherer.named(*entry.uri);
    if (std::holds_alternative<FileRange>(out.encoded)) out.name = excerpt(entry.uri->text, 200);
    return out;
  }
  const tinygltf::BufferView& view =
      asset.model.bufferViews[static_cast<std::size_t>(entry.buffer_view)];
  const Bytes& buffer = asset.buffers[static_cast<std::size_t>(view.buffer)];
  if (extension(view.extensions, "EXT_meshopt_compression") != nullptr)
    asset.fail(place + "/bufferView", "an image in a buffer view with EXT_meshopt_compression");
  if (const auto* range = std::get_if<FileRange>(&buffer)) {
    out.encoded = FileRange{
        .file = range->file, .offset = range->offset + view.byteOffset, .size = view.byteLength};
  } else {
    const auto& bytes = *std::get<1>(buffer);
    const auto first = bytes.begin() + static_cast<std::ptrdiff_t>(view.byteOffset);
    out.encoded = std::make_shared<const std::vector<std::byte>>(
        first, first + static_cast<std::ptrdiff_t>(view.byteLength));
  }
  return out;
}

}  // namespace

void Asset::warn(const std::string& message) {
  const std::string whole = name + ": " + message;
  if (warnings.size() >= warnings_most ||
      std::find(warnings.begin(), warnings.end(), whole) != warnings.end())
    return;
  warnings.push_back(whole);
}

Asset read_asset(const SceneFiles& files, const std::string& path) {
  Asset out;
  out.name = files.shown(path);
  Container container = read_container(files.locate(path), out.name);
  const CheckedJson checked = check_json(std::move(container.json), out.name);
  // First, as the parser does not understand what another extension leaves out.
  check_extensions(checked, out);
  parse(checked.rest, out);
  for (const std::size_t accessor : checked.without_view)
    out.model.accessors[accessor].bufferView = -1;
  Gatherer gatherer(files, path, out);
  for (std::size_t i = 0; i < checked.buffers.size(); ++i)
    gatherer.attempt([&] {
      out.buffers.push_back(gatherer.buffer(checked.buffers[i],
                                            i == 0 ? container.binary : std::nullopt,
                                            fmt::format("/buffers/{}", i)));
    });
  const bool whole = out.problems.empty();
  for (const Bytes& bytes : out.buffers) out.buffer_bytes.push_back(Gatherer::size_of(bytes));
  if (whole) check_views(out);
  for (std::size_t i = 0; i < checked.images.size(); ++i)
    if (whole || checked.images[i].uri)
      gatherer.attempt(
          [&] { out.images.push_back(image_of(checked.images[i], i, out, gatherer)); });
  return out;
}

const tinygltf::Value* member(const tinygltf::Value& object, const std::string& key) {
  if (!object.IsObject() || !object.Has(key)) return nullptr;
  return &object.Get(key);
}

const tinygltf::Value* extension(const tinygltf::ExtensionMap& extensions, const std::string& key) {
  const auto found = extensions.find(key);
  return found == extensions.end() ? nullptr : &found->second;
}

double number_or(const tinygltf::Value& object, const std::string& key, double fallback) {
  const tinygltf::Value* value = member(object, key);
  return value != nullptr && value->IsNumber() ? value->GetNumberAsDouble() : fallback;
}

int integer_or(const tinygltf::Value& object, const std::string& key, int fallback) {
  const tinygltf::Value* value = member(object, key);
  return value != nullptr && value->IsInt() ? value->GetNumberAsInt() : fallback;
}

std::string text_or(const tinygltf::Value& object, const std::string& key,
                    const std::string& fallback) {
  const tinygltf::Value* value = member(object, key);
  return value != nullptr && value->IsString() ? value->Get<std::string>() : fallback;
}

Color color_or(const tinygltf::Value& object, const std::string& key, const Color& fallback) {
  const tinygltf::Value* value = member(object, key);
  if (value == nullptr || !value->IsArray() || value->ArrayLen() != 3) return fallback;
  return {value->Get(0).GetNumberAsDouble(), value->Get(1).GetNumberAsDouble(),
          value->Get(2).GetNumberAsDouble()};
}

}  // namespace tessera::scene::gltf
