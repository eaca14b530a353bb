#pragma once
#include <openexr.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace tessera::image {

/// An EXR file in memory, opened by OpenEXR's C core, its header parsed. Nothing that the file says
/// makes it allocate more than a bound: not in the header, not for its table of chunks. The bytes
/// must outlive it.
class ExrCore {
 public:
  /// `name` is what errors call the file. Throws Error{bad_input}.
  ExrCore(std::span<const std::byte> bytes, const std::string& name);
  ExrCore(const ExrCore&) = delete;
  ExrCore& operator=(const ExrCore&) = delete;
  ~ExrCore();

  [[nodiscard]] exr_const_context_t get() const { return context_; }
  /// Throws Error{bad_input} with what the library said, if `result` is a failure.
  void require(exr_result_t result) const;

 private:
  static std::int64_t read(exr_const_context_t context, void* self, void* buffer,
                           std::uint64_t size, std::uint64_t offset,
                           exr_stream_error_func_ptr_t error);
  static std::int64_t size(exr_const_context_t context, void* self);
  static void note(exr_const_context_t context, exr_result_t code, const char* message);

  std::span<const std::byte> bytes_;
  std::string name_;
  std::array<char, 200> said_{};  ///< the first thing that the library complained of
  exr_context_t context_ = nullptr;
};

}  // namespace tessera::image
