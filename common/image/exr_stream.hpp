#pragma once
#include <ImfIO.h>

#include <algorithm>
#include <cstring>
#include <span>
#include <stdexcept>
#include <string>

namespace tessera::image {

/// A file in memory, as OpenEXR's C++ library reads one.
class MemoryStream : public Imf::IStream {
 public:
  MemoryStream(std::span<const std::byte> bytes, const std::string& name)
      : Imf::IStream(name.c_str()), bytes_(bytes) {}
  bool isMemoryMapped() const override { return false; }
  bool read(char* to, int count) override {
    const auto wanted = static_cast<std::size_t>(count);
    if (wanted > bytes_.size() - at_) throw std::runtime_error("ends too early");
    std::memcpy(to, bytes_.data() + at_, wanted);
    at_ += wanted;
    return at_ < bytes_.size();
  }
  std::uint64_t tellg() override { return at_; }
  void seekg(std::uint64_t to) override { at_ = std::min<std::size_t>(to, bytes_.size()); }

 private:
  std::span<const std::byte> bytes_;
  std::size_t at_ = 0;
};

/// Size and channels against the limits, by the core, which allocates nothing by them. Throws
/// Error{bad_input} at `name`.
void check_exr_bounds(std::span<const std::byte> exr, const std::string& name);

}  // namespace tessera::image
