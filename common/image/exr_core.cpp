#include "common/image/exr_core.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "common/base/error.hpp"
#include "common/base/limits.hpp"
#include "common/image/exr_layout.hpp"

namespace tessera::image {

namespace {
/// The library allocates for the header's attributes and the table of chunks; pixels go where we
/// say.
void* bounded_malloc(std::size_t bytes) {
  constexpr std::size_t most = 16 * limits::MiB;
  return bytes <= most ? std::malloc(bytes) : nullptr;
}
}  // namespace

std::int64_t ExrCore::read(exr_const_context_t, void* self, void* buffer, std::uint64_t size,
                           std::uint64_t offset, exr_stream_error_func_ptr_t) {
  const auto& bytes = static_cast<const ExrCore*>(self)->bytes_;
  if (offset >= bytes.size()) return 0;
  const std::size_t count = std::min<std::size_t>(size, bytes.size() - offset);
  std::memcpy(buffer, bytes.data() + offset, count);
  return static_cast<std::int64_t>(count);
}

std::int64_t ExrCore::size(exr_const_context_t, void* self) {
  return static_cast<std::int64_t>(static_cast<const ExrCore*>(self)->bytes_.size());
}

void ExrCore::note(exr_const_context_t context, exr_result_t, const char* message) {
  void* self = nullptr;
  if (context == nullptr || exr_get_user_data(context, &self) != EXR_ERR_SUCCESS || self == nullptr)
    return;
  auto& said = static_cast<ExrCore*>(self)->said_;
  if (said[0] == '\0') std::strncpy(said.data(), message, said.size() - 1);
}

ExrCore::ExrCore(std::span<const std::byte> bytes, const std::string& name)
    : bytes_(bytes), name_(name) {
  exr_context_initializer_t setup = EXR_DEFAULT_CONTEXT_INITIALIZER;
  setup.error_handler_fn = &note;
  setup.alloc_fn = &bounded_malloc;
  setup.free_fn = &std::free;
  setup.user_data = this;
  setup.read_fn = &read;
  setup.size_fn = &size;
  setup.max_image_width = limits::film_side_max;
  setup.max_image_height = limits::film_side_max;
#ifdef EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION
  setup.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
#endif
  require(exr_start_read(&context_, name_.c_str(), &setup));
}

ExrCore::~ExrCore() {
  if (context_ != nullptr) exr_finish(&context_);
}

void ExrCore::require(exr_result_t result) const {
  if (result == EXR_ERR_SUCCESS) return;
  const char* message = said_[0] != '\0' ? said_.data() : exr_get_default_error_message(result);
  throw Error(ErrorKind::bad_input, fmt::format("not a valid EXR file: {}", printable(message)),
              {.file = name_});
}

}  // namespace tessera::image
