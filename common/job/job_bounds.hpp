#pragma once

/// Bounds of a job's numbers that reading its JSON and checking it share.
namespace tessera {

constexpr double time_limit_most = 365.25 * 24 * 3600;  ///< seconds
constexpr double noise_most = 1000;
constexpr double fps_least = 0.001, fps_most = 10'000;
constexpr double filter_width_most = 64;  ///< pixels
constexpr int priority_most = 100;        ///< and its negative the least

}  // namespace tessera
