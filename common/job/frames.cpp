#include "common/job/frames.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/base/names.hpp"

namespace tessera {

namespace {

/// More than this many frames nobody writes as a list.
constexpr std::size_t expanded_most = 1'000'000;

[[noreturn]] void bad(std::string_view text) {
  throw Error(ErrorKind::bad_input,
              fmt::format("expected frames such as 7, 1-240, 1-240x2 or 1,5,10-20, from {} to {}, "
                          "found \"{}\"",
                          -limits::frame_max, limits::frame_max, excerpt(text)));
}

/// Takes a number off the front of `rest`.
std::int32_t take_number(std::string_view& rest, std::string_view whole) {
  std::int32_t value = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  if (error != std::errc() || value < -limits::frame_max || value > limits::frame_max) bad(whole);
  rest.remove_prefix(static_cast<std::size_t>(end - rest.data()));
  return value;
}

bool take(std::string_view& rest, char sign) {
  if (rest.empty() || rest.front() != sign) return false;
  rest.remove_prefix(1);
  return true;
}

FrameRange range_from(std::string_view text, std::string_view whole) {
  FrameRange range;
  std::string_view rest = text;
  range.first = range.last = take_number(rest, whole);
  if (take(rest, '-')) {
    range.last = take_number(rest, whole);
    if (take(rest, 'x')) range.step = take_number(rest, whole);
  }
  if (!rest.empty() || range.last < range.first || range.step < 1) bad(whole);
  range.last = range.first + static_cast<std::int32_t>(range.count() - 1) * range.step;
  if (range.last == range.first) range.step = 1;
  return range;
}

/// Ascending numbers, each once, as few ranges.
std::vector<FrameRange> ranges_of(const std::vector<std::int32_t>& frames) {
  std::vector<FrameRange> ranges;
  for (std::size_t i = 0; i < frames.size();) {
    std::size_t end = i + 1;
    const std::int32_t step = end < frames.size() ? frames[end] - frames[i] : 1;
    while (end < frames.size() && frames[end] - frames[end - 1] == step) ++end;
    if (end - i == 2 && step > 1) end = i + 1;  // two that stand apart are no range
    ranges.push_back({frames[i], frames[end - 1], end - i == 1 ? 1 : step});
    i = end;
  }
  return ranges;
}

std::string text_of(const FrameRange& range) {
  if (range.first == range.last) return std::to_string(range.first);
  return range.step == 1 ? fmt::format("{}-{}", range.first, range.last)
                         : fmt::format("{}-{}x{}", range.first, range.last, range.step);
}

}  // namespace

std::uint32_t FrameList::count() const {
  std::uint32_t all = 0;
  for (const FrameRange& range : ranges) all += range.count();
  return all;
}

bool FrameList::contains(std::int32_t frame) const {
  return std::any_of(ranges.begin(), ranges.end(),
                     [frame](const FrameRange& range) { return range.contains(frame); });
}

std::int32_t FrameList::last() const { return number(count() - 1); }

std::int32_t FrameList::number(std::uint32_t index) const {
  auto range = ranges.begin();
  for (; index >= range->count(); ++range) index -= range->count();
  return static_cast<std::int32_t>(range->first + std::int64_t{index} * range->step);
}

std::uint32_t FrameList::index(std::int32_t frame) const {
  std::uint32_t before = 0;
  auto range = ranges.begin();
  for (; !range->contains(frame); ++range) before += range->count();
  return before + static_cast<std::uint32_t>((std::int64_t{frame} - range->first) / range->step);
}

FrameList frames_from_text(std::string_view text) {
  std::vector<FrameRange> written;
  std::size_t count = 0;
  for (std::string_view rest = text;;) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    written.push_back(range_from(rest.substr(0, comma), text));
    count += written.back().count();
    if (count > expanded_most) bad(text);
    if (comma == rest.size()) break;
    rest.remove_prefix(comma + 1);
  }
  FrameList list;
  list.ranges = written;
  if (written.size() == 1) return list;
  std::vector<std::int32_t> frames;
  frames.reserve(count);
  for (const FrameRange& range : written)
    for (std::uint32_t i = 0; i < range.count(); ++i)
      frames.push_back(range.first + static_cast<std::int32_t>(i) * range.step);
  std::sort(frames.begin(), frames.end());
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  list.ranges = ranges_of(frames);
  if (list.ranges.size() > limits::frame_ranges_max)
    throw Error(ErrorKind::bad_input,
                fmt::format("a list of frames has at most {} ranges, and these are {}",
                            limits::frame_ranges_max, list.ranges.size()));
  return list;
}

std::string text_of(const FrameList& frames) {
  std::string text;
  for (const FrameRange& range : frames.ranges) {
    if (!text.empty()) text += ',';
    text += text_of(range);
  }
  return text;
}

}  // namespace tessera
