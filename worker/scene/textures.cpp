#include "worker/scene/textures.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <unistd.h>

#include <algorithm>
#include <exception>
#include <fstream>
#include <map>
#include <tuple>
#include <utility>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"

namespace tessera::worker {
namespace {

std::vector<std::byte> bytes_of(const scene::FileRange& range, const std::string& name) {
  const Place place{.file = name, .key = {}};
  std::error_code error;
  const std::uintmax_t whole = std::filesystem::file_size(range.file, error);
  if (error)
    throw Error(ErrorKind::not_found, fmt::format("no such file ({})", error.message()), place);
  if (range.offset > whole || range.size > whole - range.offset)
    throw Error(ErrorKind::bad_input, "the picture lies beyond the end of its file", place);
  const std::uintmax_t size = range.size == 0 ? whole - range.offset : range.size;
  if (size > limits::image_file_bytes)
    throw Error(
        ErrorKind::too_large,
        fmt::format("{} bytes; a picture's file may have {}", size, limits::image_file_bytes),
        place);
  std::vector<std::byte> out(static_cast<std::size_t>(size));
  std::ifstream in(range.file, std::ios::binary);
  in.seekg(static_cast<std::streamoff>(range.offset));
  if (!in.read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size())))
    throw Error(ErrorKind::failed, "cannot be read", place);
  return out;
}

/// A picture, and what its integers mean.
using Wanted = std::pair<std::uint32_t, scene::ColorSpace>;

using Held = std::shared_ptr<const std::vector<std::byte>>;

image::Texels decode(const scene::Image& image, image::TexelBudget& budget) {
  if (const auto* range = std::get_if<scene::FileRange>(&image.encoded))
    return image::decode_texels(bytes_of(*range, image.name), image.name, &budget);
  return image::decode_texels(*std::get<Held>(image.encoded), image.name, &budget);
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

/// What the pictures of one scene may take of this machine: mip levels are a third more, and there
/// is more to a scene than its pictures.
std::uint64_t picture_bytes_most() {
  const auto pages = static_cast<std::uint64_t>(sysconf(_SC_PHYS_PAGES));
  const auto page = static_cast<std::uint64_t>(sysconf(_SC_PAGE_SIZE));
  return std::min<std::uint64_t>(limits::images_bytes, pages * page / 2);
}

}  // namespace

render::TextureTable load_textures(const scene::Scene& from) {
  const std::vector<std::uint32_t> same = first_of_same(from.images);
  std::map<Wanted, std::shared_ptr<const render::Pyramid>> pyramids;
  for (const scene::Texture& texture : from.textures)
    pyramids.try_emplace({same[texture.image], texture.color_space});
  image::TexelBudget budget(picture_bytes_most());
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

std::shared_ptr<const render::EnvironmentMap> load_environment(const scene::Scene& from) {
  const scene::Environment& environment = from.environment.value();
  image::TexelBudget budget(picture_bytes_most());
  return std::make_shared<const render::EnvironmentMap>(
      decode(from.images[environment.image.value()], budget), scene::ColorSpace::srgb,
      environment.rotation_degrees * render::pi_d / 180);
}

}  // namespace tessera::worker
