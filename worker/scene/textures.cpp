#include "worker/scene/textures.hpp"

#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <map>
#include <tuple>
#include <utility>

#include "common/base/limits.hpp"
#include "common/scene/image_bytes.hpp"

namespace tessera::worker {
namespace {

/// A picture, and what its integers mean.
using Wanted = std::pair<std::uint32_t, scene::ColorSpace>;

using Held = std::shared_ptr<const std::vector<std::byte>>;

image::Texels decode(const scene::Image& image, image::TexelBudget& budget) {
  const Held bytes = scene::encoded_bytes(image);
  return image::decode_texels(*bytes, image.name, &budget);
}

/// For each image the first of the same bytes in the same place: a file that is named or included
/// twice is one picture.
std::vector<std::uint32_t> first_of_same(const std::vector<scene::Image>& images) {
  std::map<std::tuple<std::filesystem::path, std::uint64_t, std::uint64_t>, std::uint32_t> files;
  std::map<Held, std::uint32_t> held;
  std::vector<std::uint32_t> out;
  for (const scene::Image& image : images) {
    const auto index = static_cast<std::uint32_t>(out.size());
    const auto* range = std::get_if<scene::FileRange>(&image.encoded);
    out.push_back(
        range != nullptr
            ? files.try_emplace({range->file, range->offset, range->size}, index).first->second
            : held.try_emplace(std::get<Held>(image.encoded), index).first->second);
  }
  return out;
}

}  // namespace

std::uint64_t picture_bytes_most() {
  const auto pages = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES));
  const auto page = static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
  return std::min<std::uint64_t>(limits::images_bytes, pages * page / 2);
}

render::TextureTable load_textures(const scene::Scene& from, image::TexelBudget& budget) {
  const std::vector<std::uint32_t> same = first_of_same(from.images);
  std::map<Wanted, std::shared_ptr<const render::Pyramid>> pyramids;
  for (const scene::Texture& texture : from.textures)
    pyramids.try_emplace({same[texture.image], texture.color_space});
  std::vector<decltype(pyramids)::value_type*> jobs;
  for (auto& entry : pyramids) jobs.push_back(&entry);
  std::vector<std::exception_ptr> problems(jobs.size());
  tbb::parallel_for(std::size_t{0}, jobs.size(), [&](std::size_t i) {
    try {
      const auto [image, space] = jobs[i]->first;
      jobs[i]->second =
          std::make_shared<const render::Pyramid>(decode(from.images[image], budget), space);
    } catch (...) {
      problems[i] = std::current_exception();
    }
  });
  for (const std::exception_ptr& problem : problems)
    if (problem) std::rethrow_exception(problem);
  std::vector<render::Texture> out;
  out.reserve(from.textures.size());
  for (const scene::Texture& texture : from.textures)
    out.push_back({.picture = pyramids[{same[texture.image], texture.color_space}],
                   .wrap_u = texture.wrap_u,
                   .wrap_v = texture.wrap_v,
                   .nearest = texture.nearest});
  return render::TextureTable(std::move(out));
}

std::shared_ptr<const render::EnvironmentMap> load_environment(const scene::Scene& from,
                                                               image::TexelBudget& budget) {
  const scene::Environment& environment = from.environment.value();
  return std::make_shared<const render::EnvironmentMap>(
      decode(from.images[environment.image.value()], budget), scene::ColorSpace::srgb,
      environment.rotation_degrees * render::pi_d / 180);
}

}  // namespace tessera::worker
