#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tessera::scene {

/// Names one behind the other, by number: what a scene may have millions of costs 8 bytes each
/// beside its letters, and what shares a name the number alone.
class NameList {
 public:
  /// Where something has no name of its own.
  static constexpr std::uint32_t none = 0xffffffff;

  /// The name's number: 0, and then always one more. At most `none` are added.
  std::uint32_t add(std::string_view name) {
    text_ += name;
    ends_.push_back(text_.size());
    return static_cast<std::uint32_t>(ends_.size() - 1);
  }
  /// Of a number that add() gave; good until the next is added.
  [[nodiscard]] std::string_view operator[](std::uint32_t number) const {
    const std::size_t begin = number == 0 ? 0 : ends_[number - 1];
    return std::string_view(text_).substr(begin, ends_[number] - begin);
  }
  [[nodiscard]] std::size_t size() const { return ends_.size(); }
  /// Of memory.
  [[nodiscard]] std::size_t bytes() const {
    return text_.capacity() + ends_.capacity() * sizeof(ends_[0]);
  }

 private:
  std::string text_;
  std::vector<std::size_t> ends_;
};

}  // namespace tessera::scene
