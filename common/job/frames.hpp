#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tessera {

/// first, first + step, … up to last.
struct FrameRange {
  std::int32_t first = 1;
  std::int32_t last = 1;
  std::int32_t step = 1;
  bool operator==(const FrameRange&) const = default;
  [[nodiscard]] std::uint32_t count() const {
    return static_cast<std::uint32_t>((static_cast<std::int64_t>(last) - first) / step + 1);
  }
  [[nodiscard]] bool contains(std::int32_t frame) const {
    return frame >= first && frame <= last &&
           (static_cast<std::int64_t>(frame) - first) % step == 0;
  }
};

/// The frames of a job, ascending: ranges, each of which begins after the end of the one before.
struct FrameList {
  FrameList() : ranges(1) {}
  FrameList(const FrameRange& only) : ranges(1, only) {}
  FrameList(std::int32_t first, std::int32_t last, std::int32_t step)
      : ranges(1, FrameRange{first, last, step}) {}

  std::vector<FrameRange> ranges;

  bool operator==(const FrameList&) const = default;
  [[nodiscard]] std::uint32_t count() const;
  [[nodiscard]] bool contains(std::int32_t frame) const;
  [[nodiscard]] std::int32_t first() const { return ranges.front().first; }
  [[nodiscard]] std::int32_t last() const;
  /// The frame with so many before it; index < count().
  [[nodiscard]] std::int32_t number(std::uint32_t index) const;
  /// How many come before this one, which it contains.
  [[nodiscard]] std::uint32_t index(std::int32_t frame) const;
};

/// "7", "1-240", "1-240x2", "1,5,10-20": as people write frames; in any order, some of them twice.
/// A negative number is written as it is: "-5--1". Throws Error{bad_input} that says what was
/// expected.
FrameList frames_from_text(std::string_view text);
/// In the same form, as short as it gets.
std::string text_of(const FrameList& frames);

}  // namespace tessera
