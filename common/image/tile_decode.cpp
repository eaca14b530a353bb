#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <string>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/image/exr_core.hpp"
#include "common/image/exr_layout.hpp"
#include "common/image/tile.hpp"
#include "common/image/tile_layout.hpp"

namespace tessera::image {

namespace {

std::vector<std::size_t> sorted_prefix(std::size_t count) {
  std::vector<std::size_t> order(count);
  for (std::size_t i = 0; i < count; ++i) order[i] = i;
  std::sort(order.begin(), order.end(), [](std::size_t a, std::size_t b) {
    return channel_table()[a].name < channel_table()[b].name;
  });
  return order;
}

[[noreturn]] void wrong(std::string_view what, const std::string& expected,
                        const std::string& found) {
  throw Error(ErrorKind::bad_input, fmt::format("{}: expected {}, found {}", what, expected, found),
              {.file = "tile EXR"});
}

/// Magic, version 2 and no flag: one part, scan lines, not deep. The rest is OpenEXR's to parse.
void check_kind(std::span<const std::byte> exr) {
  constexpr std::uint32_t magic = 20000630, version = 2;
  std::array<std::uint32_t, 2> words{};
  if (exr.size() < sizeof words) wrong("size", "an EXR file", fmt::format("{} bytes", exr.size()));
  std::memcpy(words.data(), exr.data(), sizeof words);
  if (words[0] != magic)
    wrong("magic number", "that of an EXR file", fmt::format("0x{:08x}", words[0]));
  if (words[1] == version) return;
  std::string found = fmt::format("version {}", words[1] & 0xff);
  constexpr std::array<std::pair<unsigned, std::string_view>, 4> flags{
      {{0x200, "tiled"}, {0x400, "long names"}, {0x800, "deep"}, {0x1000, "several parts"}}};
  for (const auto& [flag, name] : flags)
    if ((words[1] & flag) != 0) found += fmt::format(", {}", name);
  wrong("kind of file", "version 2, one part of scan lines", found);
}

/// Pixels, table, and as much again for attributes as a header needs a hundred times over.
void check_size(std::span<const std::byte> exr, const TileExpectation& expected) {
  const auto pixels = static_cast<std::size_t>(expected.window.pixels());
  const std::size_t most = pixels * channels_travelling(expected.aovs) * sizeof(float) +
                           static_cast<std::size_t>(expected.window.height) * 16 + 64 * limits::KiB;
  if (exr.size() > most)
    wrong("size", fmt::format("at most {} bytes", most), fmt::format("{} bytes", exr.size()));
}

void check_window(std::string_view what, const exr_attr_box2i_t& found, const Rect& expected) {
  const std::int64_t width = std::int64_t{found.max.x} - found.min.x + 1;
  const std::int64_t height = std::int64_t{found.max.y} - found.min.y + 1;
  if (found.min.x == expected.x && found.min.y == expected.y && width == expected.width &&
      height == expected.height)
    return;
  wrong(what,
        fmt::format("{}x{} at {},{}", expected.width, expected.height, expected.x, expected.y),
        fmt::format("{}x{} at {},{}", width, height, found.min.x, found.min.y));
}

void check_channels(const exr_attr_chlist_t& found, bool aovs) {
  const auto order = travelling_by_name(aovs);
  const std::span entries(found.entries, static_cast<std::size_t>(found.num_channels));
  const auto fits = [](const exr_attr_chlist_entry_t& entry, std::size_t channel) {
    return std::string_view(entry.name.str, static_cast<std::size_t>(entry.name.length)) ==
               channel_table()[channel].name &&
           entry.pixel_type == EXR_PIXEL_FLOAT && entry.x_sampling == 1 && entry.y_sampling == 1;
  };
  if (std::equal(entries.begin(), entries.end(), order.begin(), order.end(), fits)) return;
  std::vector<std::string> expected_names, found_names;
  for (const std::size_t channel : order)
    expected_names.emplace_back(channel_table()[channel].name);
  constexpr std::array<const char*, 3> types{"uint", "half", "float"};
  for (const auto& entry : entries.first(std::min<std::size_t>(entries.size(), 32))) {
    const std::string_view name(entry.name.str, static_cast<std::size_t>(entry.name.length));
    const auto type = static_cast<std::size_t>(entry.pixel_type);
    found_names.push_back(fmt::format(
        "{} ({}{})", printable(name.substr(0, 32)), type < types.size() ? types[type] : "?",
        entry.x_sampling == 1 && entry.y_sampling == 1 ? "" : ", subsampled"));
  }
  if (entries.size() > found_names.size())
    found_names.emplace_back(fmt::format("… ({} in all)", entries.size()));
  wrong("channels", fmt::format("{}, each float", fmt::join(expected_names, " ")),
        found_names.empty() ? "none" : fmt::format("{}", fmt::join(found_names, " ")));
}

void check_samples(const ExrCore& file, Group group, std::uint32_t expected) {
  const std::string_view name = samples_attribute[static_cast<std::size_t>(group)];
  std::int32_t found = 0;
  const exr_result_t result = exr_attr_get_int(file.get(), 0, std::string(name).c_str(), &found);
  if (result == EXR_ERR_SUCCESS && found >= 0 && static_cast<std::uint32_t>(found) == expected)
    return;
  wrong(name, std::to_string(expected),
        result == EXR_ERR_SUCCESS           ? std::to_string(found)
        : result == EXR_ERR_NO_ATTR_BY_NAME ? std::string("nothing")
                                            : std::string("another type than int"));
}

void check_header(const ExrCore& file, const TileExpectation& expected) {
  exr_storage_t storage{};
  file.require(exr_get_storage(file.get(), 0, &storage));
  if (storage != EXR_STORAGE_SCANLINE) wrong("storage", "scan lines", "another");
  exr_compression_t compression{};
  file.require(exr_get_compression(file.get(), 0, &compression));
  if (compression != EXR_COMPRESSION_NONE)
    wrong("compression", "none", fmt::format("method {}", static_cast<int>(compression)));
  exr_attr_box2i_t window{};
  file.require(exr_get_data_window(file.get(), 0, &window));
  check_window("data window", window, expected.window);
  file.require(exr_get_display_window(file.get(), 0, &window));
  check_window("display window", window, {0, 0, expected.film_width, expected.film_height});
  const exr_attr_chlist_t* channels = nullptr;
  file.require(exr_get_channels(file.get(), 0, &channels));
  check_channels(*channels, expected.aovs);
  check_samples(file, Group::beauty, expected.samples);
  check_samples(file, Group::aov, expected.aovs ? expected.samples : 0);
}

void read_lines(const ExrCore& file, TileImage& tile) {
  const auto order = travelling_by_name(tile.has_aovs());
  const auto width = static_cast<std::size_t>(tile.window.width);
  const std::size_t row_bytes = width * sizeof(float);
  std::vector<std::byte> line(order.size() * row_bytes);
  for (int row = 0; row < tile.window.height; ++row) {
    exr_chunk_info_t chunk{};
    file.require(exr_read_scanline_chunk_info(file.get(), 0, tile.window.y + row, &chunk));
    if (chunk.packed_size != line.size())
      wrong(fmt::format("line {}", tile.window.y + row), fmt::format("{} bytes", line.size()),
            fmt::format("{}", chunk.packed_size));
    file.require(exr_read_chunk(file.get(), 0, &chunk, line.data()));
    const std::byte* from = line.data();
    for (const std::size_t channel : order) {
      std::memcpy(tile.plane(channel).data() + static_cast<std::size_t>(row) * width, from,
                  row_bytes);
      from += row_bytes;
    }
  }
}

/// Bits of a float without its sign are at least those of infinity for Inf and NaN alone.
bool any_unusable(std::span<const float> values, bool may_be_negative) {
  std::uint32_t largest = 0, negative = 0;
  for (const float value : values) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    largest = std::max(largest, bits & 0x7fffffffU);
    negative |= static_cast<std::uint32_t>(value < 0);
  }
  return largest >= 0x7f800000U || (negative != 0 && !may_be_negative);
}

void check_values(const TileImage& tile) {
  for (std::size_t channel = 0; channel < tile.channels(); ++channel) {
    const Channel& entry = channel_table()[channel];
    const bool may_be_negative = entry.merge != Merge::moment2;
    const auto plane = tile.plane(channel);
    if (!any_unusable(plane, may_be_negative)) continue;
    for (std::size_t i = 0; i < plane.size(); ++i) {
      if (!any_unusable(plane.subspan(i, 1), may_be_negative)) continue;
      const auto width = static_cast<std::size_t>(tile.window.width);
      wrong(fmt::format("channel {} at pixel {},{}", entry.name,
                        static_cast<std::size_t>(tile.window.x) + i % width,
                        static_cast<std::size_t>(tile.window.y) + i / width),
            may_be_negative ? "a finite number" : "a finite number, not negative",
            fmt::format("{}", plane[i]));
    }
  }
}

}  // namespace

std::span<const std::size_t> travelling_by_name(bool with_aovs) {
  static const std::vector<std::size_t> beauty = sorted_prefix(channels_travelling(false));
  static const std::vector<std::size_t> all = sorted_prefix(channels_travelling(true));
  return with_aovs ? all : beauty;
}

TileImage decode_tile(std::span<const std::byte> exr, const TileExpectation& expected) {
  check_kind(exr);
  check_size(exr, expected);
  const ExrCore file(exr, "tile EXR");
  check_header(file, expected);
  TileImage tile{.window = expected.window,
                 .film_width = expected.film_width,
                 .film_height = expected.film_height,
                 .samples = {expected.samples, expected.aovs ? expected.samples : 0},
                 .values = {}};
  tile.values.resize(tile.channels() * tile.pixels());
  read_lines(file, tile);
  check_values(tile);
  return tile;
}

}  // namespace tessera::image
