#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <string>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/image/exr_core.hpp"
#include "common/image/exr_layout.hpp"
#include "common/image/tile.hpp"
#include "common/image/tile_layout.hpp"
#include "common/image/tile_view.hpp"

namespace tessera::image {

namespace {

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
  const std::size_t most = pixels * expected.layout->travelling(expected.aovs) * sizeof(float) +
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

void check_channels(const exr_attr_chlist_t& found, const TileExpectation& expected) {
  const ChannelLayout& layout = *expected.layout;
  const auto order = layout.by_name(expected.aovs);
  const std::span entries(found.entries, static_cast<std::size_t>(found.num_channels));
  const auto fits = [&](const exr_attr_chlist_entry_t& entry, std::size_t channel) {
    return std::string_view(entry.name.str, static_cast<std::size_t>(entry.name.length)) ==
               layout[channel].name &&
           entry.pixel_type == EXR_PIXEL_FLOAT && entry.x_sampling == 1 && entry.y_sampling == 1;
  };
  if (std::equal(entries.begin(), entries.end(), order.begin(), order.end(), fits)) return;
  std::vector<std::string> expected_names, found_names;
  for (const std::size_t channel : order) expected_names.push_back(layout[channel].name);
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
  check_channels(*channels, expected);
  check_samples(file, Group::beauty, expected.samples);
  check_samples(file, Group::aov, expected.aovs ? expected.samples : 0);
}

/// Where the pixels of each line stand, and of each channel in a line.
void find_lines(const ExrCore& file, std::span<const std::byte> exr, TileView& tile) {
  const std::size_t row_bytes = static_cast<std::size_t>(tile.window.width) * sizeof(float);
  std::size_t line_bytes = 0;
  tile.offset_of.resize(tile.layout->size());
  for (const std::size_t channel : tile.layout->by_name(tile.has_aovs())) {
    tile.offset_of[channel] = line_bytes;
    line_bytes += row_bytes;
  }
  tile.lines.reserve(static_cast<std::size_t>(tile.window.height));
  for (int y = tile.window.y; y < tile.window.y + tile.window.height; ++y) {
    exr_chunk_info_t chunk{};
    file.require(exr_read_scanline_chunk_info(file.get(), 0, y, &chunk));
    if (chunk.packed_size != line_bytes)
      wrong(fmt::format("line {}", y), fmt::format("{} bytes", line_bytes),
            fmt::format("{}", chunk.packed_size));
    if (chunk.data_offset > exr.size() || exr.size() - chunk.data_offset < line_bytes)
      wrong(fmt::format("line {}", y), "to be within the file",
            fmt::format("it to begin at byte {} of {}", chunk.data_offset, exr.size()));
    tile.lines.push_back(exr.data() + chunk.data_offset);
  }
}

/// Bits of a float without its sign are at least those of infinity for Inf and NaN alone.
bool all_finite(const FloatRow& values) {
  std::uint32_t largest = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    largest = std::max(largest, std::bit_cast<std::uint32_t>(values[i]) & 0x7fffffffU);
  return largest < 0x7f800000U;
}

bool any_negative(const FloatRow& values) {
  std::uint32_t negative = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    negative |= static_cast<std::uint32_t>(values[i] < 0);
  return negative != 0;
}

bool may_be_negative(const Channel& channel) {
  return channel.merge != Merge::moment2 && channel.merge != Merge::matte_weight &&
         channel.merge != Merge::total;
}

/// Throws for the first value of the line that may not be.
void refuse_values(const TileView& tile, std::size_t y) {
  for (std::size_t channel = 0; channel < tile.channels(); ++channel) {
    const Channel& entry = (*tile.layout)[channel];
    const bool signed_too = may_be_negative(entry);
    const FloatRow row = tile.row(channel, y);
    for (std::size_t x = 0; x < row.size(); ++x) {
      const float value = row[x];
      if (std::isfinite(value) && (signed_too || value >= 0)) continue;
      wrong(fmt::format("channel {} at pixel {},{}", entry.name,
                        static_cast<std::size_t>(tile.window.x) + x,
                        static_cast<std::size_t>(tile.window.y) + y),
            signed_too ? "a finite number" : "a finite number, not negative",
            fmt::format("{}", value));
    }
  }
}

void check_values(const TileView& tile) {
  const std::size_t in_line = tile.channels() * static_cast<std::size_t>(tile.window.width);
  for (std::size_t y = 0; y < tile.lines.size(); ++y) {
    bool usable = all_finite(FloatRow(tile.lines[y], in_line));
    for (std::size_t channel = 0; channel < tile.channels(); ++channel)
      if (!may_be_negative((*tile.layout)[channel]))
        usable = usable && !any_negative(tile.row(channel, y));
    if (!usable) refuse_values(tile, y);
  }
}

}  // namespace

TileView view_of(const TileImage& tile) {
  TileView view{.window = tile.window,
                .film_width = tile.film_width,
                .film_height = tile.film_height,
                .samples = tile.samples,
                .lines = {},
                .offset_of = {},
                .layout = tile.layout};
  view.offset_of.resize(tile.layout->size());
  const std::span<const std::byte> bytes = std::as_bytes(std::span(tile.values));
  const std::size_t row_bytes = static_cast<std::size_t>(tile.window.width) * sizeof(float);
  for (std::size_t channel = 0; channel < tile.channels(); ++channel)
    view.offset_of[channel] = channel * tile.pixels() * sizeof(float);
  for (int row = 0; row < tile.window.height; ++row)
    view.lines.push_back(bytes.data() + static_cast<std::size_t>(row) * row_bytes);
  return view;
}

TileView view_tile(std::span<const std::byte> exr, const TileExpectation& expected) {
  check_kind(exr);
  check_size(exr, expected);
  const ExrCore file(exr, "tile EXR");
  check_header(file, expected);
  TileView tile{.window = expected.window,
                .film_width = expected.film_width,
                .film_height = expected.film_height,
                .samples = {expected.samples, expected.aovs ? expected.samples : 0},
                .lines = {},
                .offset_of = {},
                .layout = expected.layout};
  find_lines(file, exr, tile);
  check_values(tile);
  return tile;
}

TileImage decode_tile(std::span<const std::byte> exr, const TileExpectation& expected) {
  const TileView view = view_tile(exr, expected);
  TileImage tile{.window = view.window,
                 .film_width = view.film_width,
                 .film_height = view.film_height,
                 .samples = view.samples,
                 .values = {},
                 .layout = view.layout};
  tile.values.resize(tile.channels() * tile.pixels());
  float* to = tile.values.data();
  for (std::size_t channel = 0; channel < tile.channels(); ++channel)
    for (const std::byte* line : view.lines) {
      const auto width = static_cast<std::size_t>(tile.window.width);
      std::memcpy(to, line + view.offset_of[channel], width * sizeof(float));
      to += width;
    }
  return tile;
}

}  // namespace tessera::image
