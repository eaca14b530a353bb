#pragma once
#include <unistd.h>

#include <filesystem>
#include <string>
#include <utility>

namespace tessera {

/// A file descriptor, closed when it goes. Negative: none.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int number) noexcept : number_(number) {}
  ~Descriptor() {
    if (is_open()) ::close(number_);
  }
  Descriptor(Descriptor&& other) noexcept : number_(std::exchange(other.number_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(number_, other.number_);
    return *this;
  }

  [[nodiscard]] bool is_open() const noexcept { return number_ >= 0; }
  [[nodiscard]] int number() const noexcept { return number_; }
  /// A name under which this process can open the same file anew, as long as this lives.
  [[nodiscard]] std::filesystem::path path() const {
    return std::filesystem::path(folder) / std::to_string(number_);
  }

  /// Where path() lies.
  static constexpr const char* folder = "/proc/self/fd";

 private:
  int number_ = -1;
};

}  // namespace tessera
