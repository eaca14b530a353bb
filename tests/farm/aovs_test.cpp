// What a job asks for beside the picture, on real processes: the channels of its file, their sums
// and their bits.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "tests/farm/farm.hpp"
#include "tests/farm/reference.hpp"

namespace tessera::farm_test {
namespace {

constexpr const char* all_aovs =
    "albedo,Z,P,direct,indirect,emission,diffuse,specular,transmission,light_default,UV,object_id,"
    "material_id,CryptoObject,CryptoMaterial,time,variance,samples";

/// 40 samples: more than AOVs of the first surface travel with.
image::ExrImage with_aovs(Farm& farm, int tile, bool disturbed) {
  std::vector<std::string> arguments = arguments_of({.samples = 40, .tile = tile});
  arguments.insert(arguments.end(), {"--aovs", all_aovs});
  const std::string id = farm.submit(scene_path(), arguments);
  if (disturbed) {
    EXPECT_TRUE(farm.wait_for_progress(id, 0.3)) << farm.logs();
    farm.kill_and_restart_server();
  }
  return farm.finish(id);
}

TEST(Aovs, have_the_same_bits_whatever_the_tiles_and_a_killed_coordinator) {
  Farm one, two;
  one.add_worker();
  two.add_worker();
  two.add_worker();
  const image::ExrImage reference = with_aovs(one, 64, false);
  EXPECT_TRUE(reference.has("P.X"));
  EXPECT_TRUE(reference.has("light_default.B"));
  EXPECT_FALSE(reference.has("N.X"));
  const auto found = image::difference(reference, with_aovs(two, 23, true));
  EXPECT_FALSE(found.has_value()) << *found;
}

TEST(Aovs, that_make_up_the_picture_sum_to_it_over_all_samples) {
  Farm farm;
  farm.add_worker(2);
  const image::ExrImage picture = with_aovs(farm, 64, false);
  const std::vector<std::vector<std::string>> sums{
      {"direct", "indirect", "emission"},
      {"emission", "diffuse", "specular", "transmission"},
      {"light_default"}};
  for (const auto& parts : sums)
    for (const char* component : {"R", "G", "B"}) {
      const auto whole = picture.plane(component);
      for (std::size_t i = 0; i < whole.size(); ++i) {
        double sum = 0;
        for (const std::string& part : parts) sum += picture.plane(part + '.' + component)[i];
        ASSERT_NEAR(sum, whole[i], 1e-5 * std::abs(whole[i]) + 1e-12) << parts[0] << component << i;
      }
    }
}

/// A Cryptomatte as compositing tools read it: by its specification, from header and channels.
class MatteReader {
 public:
  MatteReader(const image::ExrImage& picture, const std::string& layer) : picture_(picture) {
    std::string key;
    for (const auto& attribute : picture.metadata.attributes())
      if (attribute.name.starts_with("cryptomatte/") && attribute.name.ends_with("/name") &&
          picture.metadata.text(attribute.name) == layer)
        key = attribute.name.substr(0, attribute.name.size() - 4);
    EXPECT_EQ(key.size(), std::string("cryptomatte/1234567/").size());
    EXPECT_EQ(picture.metadata.text(key + "hash"), "MurmurHash3_32");
    EXPECT_EQ(picture.metadata.text(key + "conversion"), "uint32_to_float32");
    manifest_ = nlohmann::json::parse(picture.metadata.text(key + "manifest"));
    for (const std::string& channel : picture.channels)
      if (channel.starts_with(layer) && (channel.ends_with(".R") || channel.ends_with(".B")))
        ranks_.push_back(channel);
  }

  [[nodiscard]] std::vector<std::string> names() const {
    std::vector<std::string> out;
    for (const auto& [name, id] : manifest_.items()) out.push_back(name);
    return out;
  }
  /// The share of each pixel that shows what has this name.
  [[nodiscard]] std::vector<double> matte(const std::string& name) const {
    const auto bits = std::stoul(manifest_.at(name).get<std::string>(), nullptr, 16);
    const auto id = std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    std::vector<double> out(picture_.plane("A").size());
    for (std::string channel : ranks_) {
      const auto ids = picture_.plane(channel);
      channel.back() = channel.back() == 'R' ? 'G' : 'A';
      const auto shares = picture_.plane(channel);
      for (std::size_t i = 0; i < out.size(); ++i)
        if (ids[i] == id) out[i] += static_cast<double>(shares[i]);
    }
    return out;
  }

 private:
  const image::ExrImage& picture_;
  nlohmann::json manifest_;
  std::vector<std::string> ranks_;
};

std::vector<double> sum_of(const MatteReader& mattes, const std::vector<std::string>& names) {
  std::vector<double> out(mattes.matte(names.front()).size());
  for (const std::string& name : names) {
    const std::vector<double> matte = mattes.matte(name);
    std::transform(out.begin(), out.end(), matte.begin(), out.begin(), std::plus<>());
  }
  return out;
}

TEST(Mattes, name_every_object_in_the_file_and_share_out_what_is_there) {
  Farm farm;
  farm.add_worker(2);
  // As many samples as AOVs of the first surface travel with: alpha is of the same.
  std::vector<std::string> arguments = arguments_of({.samples = 16});
  arguments.insert(arguments.end(), {"--aovs", "CryptoObject,CryptoMaterial,object_id"});
  const image::ExrImage picture = farm.finish(farm.submit(scene_path(), arguments));
  const MatteReader objects(picture, "CryptoObject"), materials(picture, "CryptoMaterial");
  const std::vector<std::string> in_order{"floor",     "ceiling", "back wall",   "right wall",
                                          "left wall", "light",   "short block", "tall block"};
  EXPECT_EQ(objects.names().size(), in_order.size());
  const auto alpha = picture.plane("A"), ids = picture.plane("object_id");
  const std::vector<double> all = sum_of(objects, in_order);
  for (std::size_t i = 0; i < all.size(); ++i) ASSERT_NEAR(all[i], alpha[i], 1e-6) << i;
  EXPECT_EQ(sum_of(materials, materials.names()), all);
  EXPECT_EQ(sum_of(objects, {"floor", "ceiling", "back wall", "short block", "tall block"}),
            materials.matte("white"));
  for (std::size_t number = 1; number <= in_order.size(); ++number) {
    const std::vector<double> matte = objects.matte(in_order[number - 1]);
    std::size_t whole = 0, part = 0;
    for (std::size_t i = 0; i < matte.size(); ++i) {
      if (matte[i] > 0 && matte[i] < 1) ++part;
      if (matte[i] != 1) continue;
      ++whole;
      ASSERT_EQ(ids[i], static_cast<float>(number)) << i;
    }
    EXPECT_GT(whole, 5U) << in_order[number - 1];
    EXPECT_GT(part, 10U) << in_order[number - 1];
  }
}

/// A ball that throws its shadow on a catcher.
std::string catching_scene(const Farm& farm) {
  const std::filesystem::path file = farm.folder().path() / "catching.json";
  std::ofstream(file) << R"({"tessera": 1, "film": {"width": 90, "height": 61, "transparent": true},
    "camera": {"eye": [0, 5, 7], "target": [0, 0.5, 0]},
    "environment": {"radiance": 0.5},
    "materials": {"clay": {"type": "diffuse"}, "lamp": {"type": "emitter", "radiance": 8}},
    "shapes": [
      {"type": "quad", "material": "clay", "corner": [-9, 0, 9], "edge_u": [18, 0, 0],
       "edge_v": [0, 0, -18], "visibility": {"shadow_catcher": true}},
      {"type": "sphere", "material": "clay", "center": [0, 1, 0], "radius": 0.7},
      {"type": "quad", "material": "lamp", "corner": [-3, 6, -1], "edge_u": [2, 0, 0],
       "edge_v": [0, 0, 2]}]})";
  return file;
}

image::ExrImage catching_picture(Farm& farm, const std::string& tile,
                                 const std::vector<std::string>& more = {}) {
  std::vector<std::string> arguments{"--samples", "40", "--tile", tile};
  arguments.insert(arguments.end(), more.begin(), more.end());
  return farm.finish(farm.submit(catching_scene(farm), arguments));
}

TEST(ShadowCatchers, have_the_same_bits_whatever_workers_and_tiles_there_are) {
  Farm one, two;
  one.add_worker();
  two.add_worker();
  two.add_worker();
  const image::ExrImage reference = catching_picture(one, "64");
  const auto alpha = reference.plane("A");
  EXPECT_GT(std::ranges::count_if(alpha, [](float a) { return a > 0.3F && a < 0.9F; }), 100);
  EXPECT_GT(std::ranges::count(alpha, 1.0F), 100) << "the ball";
  EXPECT_TRUE(reference.has("N.X"));
  for (const char* tile : {"16", "23", "256"}) {
    const auto found = image::difference(reference, catching_picture(two, tile));
    EXPECT_FALSE(found.has_value()) << tile << ": " << *found;
  }
}

TEST(ShadowCatchers, are_in_alpha_as_their_channels_say_and_a_crop_has_the_same_bits) {
  Farm farm;
  farm.add_worker(2);
  const image::ExrImage whole = catching_picture(farm, "64");
  const image::ExrImage part = catching_picture(farm, "16", {"--crop", "31x20+11+7"});
  ASSERT_EQ(part.width, 31);
  ASSERT_EQ(part.height, 20);
  for (std::size_t y = 0; y < 20; ++y)
    for (std::size_t x = 0; x < 31; ++x)
      ASSERT_EQ(part.plane("A")[y * 31 + x], whole.plane("A")[(y + 7) * 90 + x + 11]);
  std::size_t covered = 0;
  for (std::size_t i = 0; i < whole.plane("A").size(); ++i) {
    if (whole.plane("shadow_catcher.A")[i] < 1) continue;
    ++covered;
    const double lit = whole.plane("shadow_catcher.G")[i];
    const double open = whole.plane("shadow_catcher.unshadowed.G")[i];
    ASSERT_NEAR(whole.plane("A")[i], 1 - lit / open, 1e-6) << i;
    ASSERT_EQ(whole.plane("R")[i], 0) << i;
  }
  EXPECT_GT(covered, whole.plane("A").size() / 2);
}

TEST(Aovs, that_are_unknown_are_refused_before_anything_is_queued) {
  const Farm farm;
  const Outcome out = farm.tessera({"submit", scene_path(), "--aovs", "Z,albdo"});
  EXPECT_EQ(out.code, 2);
  EXPECT_NE(out.errors.find("--aovs: unknown AOV \"albdo\"; did you mean \"albedo\"?"),
            std::string::npos)
      << out.errors;
}

}  // namespace
}  // namespace tessera::farm_test
