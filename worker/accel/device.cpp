#include "worker/accel/device.hpp"

#include <fmt/format.h>

#include "common/base/error.hpp"

namespace tessera::accel {
namespace {

void on_error(void* user, RTCError, const char* message) {
  auto& state = *static_cast<Device::State*>(user);
  const std::lock_guard lock(state.mutex);
  state.last_message = message != nullptr ? message : "";
}

bool on_memory(void* user, ssize_t bytes, bool /*after*/) {
  auto& state = *static_cast<Device::State*>(user);
  const std::int64_t now = state.memory.fetch_add(bytes) + bytes;
  std::int64_t peak = state.memory_peak.load();
  while (now > peak && !state.memory_peak.compare_exchange_weak(peak, now)) {
  }
  return true;
}

const char* name_of(RTCError code) {
  switch (code) {
    case RTC_ERROR_INVALID_ARGUMENT:
      return "invalid argument";
    case RTC_ERROR_INVALID_OPERATION:
      return "invalid operation";
    case RTC_ERROR_OUT_OF_MEMORY:
      return "out of memory";
    case RTC_ERROR_UNSUPPORTED_CPU:
      return "this processor is not supported";
    case RTC_ERROR_CANCELLED:
      return "given up";
    default:
      return "unknown error";
  }
}

}  // namespace

Device::State::~State() {
  if (handle != nullptr) rtcReleaseDevice(handle);
}

void Device::State::check(const char* what) {
  const RTCError code = rtcGetDeviceError(handle);
  if (code == RTC_ERROR_NONE) return;
  const std::lock_guard lock(mutex);
  throw Error(ErrorKind::failed,
              fmt::format("Embree, {}: {} ({})", what, name_of(code), last_message));
}

void Device::State::require_masks() const {
  if (rtcGetDeviceProperty(handle, RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) != 0) return;
  throw Error(ErrorKind::failed,
              "this machine's Embree was built without ray masks (EMBREE_RAY_MASK): it cannot hide "
              "anything from some rays alone");
}

Device::Device(const DeviceConfig& config) : state_(std::make_shared<State>()) {
  state_->isa = config.isa;
  const std::string text = "isa=" + config.isa;
  state_->handle = rtcNewDevice(text.c_str());
  if (state_->handle == nullptr) {
    throw Error(ErrorKind::failed, fmt::format("Embree has no device with {}: {}", text,
                                               name_of(rtcGetDeviceError(nullptr))));
  }
  rtcSetDeviceErrorFunction(state_->handle, on_error, state_.get());
  rtcSetDeviceMemoryMonitorFunction(state_->handle, on_memory, state_.get());
  state_->check("new device");
}

std::int64_t Device::memory() const { return state_->memory.load(); }
std::int64_t Device::memory_peak() const { return state_->memory_peak.load(); }

std::string Device::version() const {
  const auto number = rtcGetDeviceProperty(state_->handle, RTC_DEVICE_PROPERTY_VERSION);
  return fmt::format("embree {}.{}.{} isa={}", number / 10000, number / 100 % 100, number % 100,
                     state_->isa);
}

}  // namespace tessera::accel
