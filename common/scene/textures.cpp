#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "common/base/names.hpp"
#include "common/scene/parts.hpp"

namespace tessera::scene {

namespace {

constexpr double factor_most = 1e30;
constexpr double coordinate_most = 1e6;
constexpr double slope_most = 1e6;

constexpr std::array<std::pair<std::string_view, Wrap>, 3> wraps{
    {{"repeat", Wrap::repeat},
     {"mirrored_repeat", Wrap::mirrored_repeat},
     {"clamp_to_edge", Wrap::clamp_to_edge}}};
constexpr std::array<std::pair<std::string_view, ColorSpace>, 2> spaces{
    {{"srgb", ColorSpace::srgb}, {"linear", ColorSpace::linear}}};
constexpr std::array<std::pair<std::string_view, bool>, 2> filters{
    {{"linear", false}, {"nearest", true}}};
constexpr std::array<std::pair<std::string_view, std::uint8_t>, 4> channels{
    {{"r", std::uint8_t{0}},
     {"g", std::uint8_t{1}},
     {"b", std::uint8_t{2}},
     {"a", std::uint8_t{3}}}};

/// file, color_space, wrap, filter.
TextureSource read_source(Fields& in, Reading& reading) {
  TextureSource out;
  out.texture.image = reading.use_image(in.required("file"));
  if (const auto space = in.optional("color_space"))
    out.color_space = read_word(*space, "color space", spaces);
  if (const auto wrap = in.optional("wrap")) {
    if (wrap->kind() == Kind::array) {
      const std::vector<Value> both = wrap->items();
      if (both.size() != 2) wrap->fail_expected("one wrap mode, or two: of u and of v");
      out.texture.wrap_u = read_word(both[0], "wrap mode", wraps);
      out.texture.wrap_v = read_word(both[1], "wrap mode", wraps);
    } else {
      out.texture.wrap_u = out.texture.wrap_v = read_word(*wrap, "wrap mode", wraps);
    }
  }
  if (const auto filter = in.optional("filter"))
    out.texture.nearest = read_word(*filter, "filter", filters);
  return out;
}

std::array<double, 2> pair_or(Fields& in, std::string_view key, double fallback) {
  std::array<double, 2> out{fallback, fallback};
  if (const auto value = in.optional(key))
    value->numbers(out.data(), 2, -coordinate_most, coordinate_most);
  return out;
}

/// Where the texture is, and how it lies: all keys of a use but its factor and channel.
TextureUse read_use_keys(Fields& in, Reading& reading, ColorSpace meant) {
  TextureUse out;
  if (const auto name = in.optional("texture")) {
    for (const std::string_view key : {"file", "color_space", "wrap", "filter"})
      if (const auto other = in.optional(key))
        other->fail(fmt::format("{} belongs to the texture \"{}\" itself, under textures", key,
                                name->text()));
    out.texture = reading.use_texture(*name, meant);
  } else {
    out.texture = reading.add_texture(read_source(in, reading), meant);
  }
  out.uv_set = static_cast<std::uint8_t>(in.integer_or("uv_set", 0, 1, 0));
  const std::array<double, 2> offset = pair_or(in, "offset", 0);
  std::array<double, 2> scale{1, 1};
  if (const auto value = in.optional("scale")) {
    if (value->kind() == Kind::array)
      value->numbers(scale.data(), 2, -coordinate_most, coordinate_most);
    else
      scale[0] = scale[1] = value->number(-coordinate_most, coordinate_most);
  }
  const double angle = in.number_or("rotation", -36000, 36000, 0) * std::numbers::pi / 180;
  const double cosine = std::cos(angle), sine = std::sin(angle);
  out.to_uv = {cosine * scale[0], sine * scale[1],   offset[0],
               -sine * scale[0],  cosine * scale[1], offset[1]};
  return out;
}

}  // namespace

std::uint32_t Reading::use_image(const Value& value) {
  std::filesystem::path file;
  if (!attempt([&] { file = use_file(value); })) return 0;
  const std::string name = shown(checked_path(value.text()));
  for (std::size_t i = 0; i < images.size(); ++i)
    if (images[i].name == name) return static_cast<std::uint32_t>(i);
  images.push_back({name, FileRange{file, 0, 0}});
  return static_cast<std::uint32_t>(images.size() - 1);
}

std::uint32_t Reading::add_texture(const TextureSource& source, ColorSpace meant) {
  Texture wanted = source.texture;
  wanted.color_space = source.color_space.value_or(meant);
  const auto found = std::find(textures.begin(), textures.end(), wanted);
  if (found != textures.end()) return static_cast<std::uint32_t>(found - textures.begin());
  textures.push_back(wanted);
  return static_cast<std::uint32_t>(textures.size() - 1);
}

std::uint32_t Reading::use_texture(const Value& name, ColorSpace meant) {
  std::vector<std::string_view> names;
  for (const auto& [known, source] : named_textures_) {
    if (known == name.text()) return add_texture(source, meant);
    names.push_back(known);
  }
  if (names.empty())
    name.fail(fmt::format("unknown texture \"{}\": the scene has none", name.text()));
  name.fail(unknown_name("texture", name.text(), names));
}

void read_textures(const Value& value, Reading& reading) {
  for (const Value::Member& member : value.members()) {
    (void)plain_name(member.key);
    Fields in(member.value);
    const TextureSource source = read_source(in, reading);
    in.finish();
    reading.name_texture(member.key.text(), source);
  }
}

TextureUse read_texture_use(const Value& value, Reading& reading, ColorSpace meant) {
  if (value.kind() == Kind::text) return {.texture = reading.use_texture(value, meant)};
  Fields in(value);
  const TextureUse out = read_use_keys(in, reading, meant);
  in.finish();
  return out;
}

NormalMap read_normal_map(const Value& value, Reading& reading) {
  if (value.kind() == Kind::text)
    return {.texture = read_texture_use(value, reading, ColorSpace::linear)};
  Fields in(value);
  NormalMap out;
  out.scale = in.number_or("strength", -slope_most, slope_most, out.scale);
  out.texture = read_use_keys(in, reading, ColorSpace::linear);
  in.finish();
  return out;
}

BumpMap read_bump_map(const Value& value, Reading& reading) {
  if (value.kind() == Kind::text)
    return {.texture = read_texture_use(value, reading, ColorSpace::linear)};
  Fields in(value);
  BumpMap out;
  out.height = in.number_or("height", -length_most, length_most, out.height);
  out.texture = read_use_keys(in, reading, ColorSpace::linear);
  in.finish();
  return out;
}

ColorInput color_input_or(Fields& fields, std::string_view key, double high,
                          const ColorInput& fallback, Reading& reading) {
  const auto value = fields.optional(key);
  if (!value) return fallback;
  if (value->kind() == Kind::text)
    return {.factor = {1, 1, 1}, .texture = read_texture_use(*value, reading, ColorSpace::srgb)};
  if (value->kind() != Kind::object) return {.factor = value->color(high), .texture = {}};
  Fields in(*value);
  ColorInput out;
  out.factor = in.color_or("factor", high, {1, 1, 1});
  out.texture = read_use_keys(in, reading, ColorSpace::srgb);
  in.finish();
  return out;
}

ScalarInput scalar_input_or(Fields& fields, std::string_view key, double low, double high,
                            const ScalarInput& fallback, Reading& reading) {
  const auto value = fields.optional(key);
  if (!value) return fallback;
  ScalarInput out;
  if (value->kind() == Kind::text) {
    out.texture = read_texture_use(*value, reading, ColorSpace::linear);
    return out;
  }
  if (value->kind() != Kind::object) return {.factor = value->number(low, high), .texture = {}};
  Fields in(*value);
  out.factor = in.number_or("factor", -factor_most, factor_most, 1);
  if (const auto channel = in.optional("channel"))
    out.channel = read_word(*channel, "channel", channels);
  out.texture = read_use_keys(in, reading, ColorSpace::linear);
  in.finish();
  return out;
}

}  // namespace tessera::scene
