#include "worker/scene/textures.hpp"

#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <exception>
#include <fstream>
#include <map>
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

}  // namespace

image::Texels load_picture(const scene::Image& image) {
  if (const auto* range = std::get_if<scene::FileRange>(&image.encoded))
    return image::decode_texels(bytes_of(*range, image.name), image.name);
  return image::decode_texels(
      *std::get<std::shared_ptr<const std::vector<std::byte>>>(image.encoded), image.name);
}

render::TextureTable load_textures(const scene::Scene& from) {
  std::map<Wanted, std::shared_ptr<const render::Pyramid>> pyramids;
  for (const scene::Texture& texture : from.textures)
    pyramids.try_emplace({texture.image, texture.color_space});
  std::vector<decltype(pyramids)::value_type*> jobs;
  for (auto& entry : pyramids) jobs.push_back(&entry);
  std::vector<std::exception_ptr> problems(jobs.size());
  tbb::parallel_for(std::size_t{0}, jobs.size(), [&](std::size_t i) {
    try {
      const auto [image, space] = jobs[i]->first;
      jobs[i]->second =
          std::make_shared<const render::Pyramid>(load_picture(from.images[image]), space);
    } catch (...) {
      problems[i] = std::current_exception();
    }
  });
  for (const std::exception_ptr& problem : problems)
    if (problem) std::rethrow_exception(problem);
  std::vector<render::Texture> out;
  out.reserve(from.textures.size());
  for (const scene::Texture& texture : from.textures)
    out.push_back({.picture = pyramids[{texture.image, texture.color_space}],
                   .wrap_u = texture.wrap_u,
                   .wrap_v = texture.wrap_v,
                   .nearest = texture.nearest});
  return render::TextureTable(std::move(out));
}

std::shared_ptr<const render::EnvironmentMap> load_environment(const scene::Scene& from) {
  const scene::Environment& environment = from.environment.value();
  return std::make_shared<const render::EnvironmentMap>(
      load_picture(from.images[environment.image.value()]), scene::ColorSpace::srgb,
      environment.rotation_degrees * render::pi_d / 180);
}

}  // namespace tessera::worker
