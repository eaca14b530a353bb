#pragma once
#include <cstddef>

#include "server/film/film.hpp"

namespace tessera::server {

/// The noise of a film, 0 without any: how far its pixels are off by, as a share of their light.
///
/// Of a pixel: the root mean square over R, G and B of the standard error of the mean,
/// √(M2 / (n·(n − 1))), over its light (R + G + B) / 3 and a tenth of the film's mean light, so
/// that what is black does not count for noisy. Of the film: the mean over its pixels but the
/// noisiest hundredth, in which fireflies are. It does not change with exposure, and falls with
/// √n. Samples are taken for independent; those of Sobol' points are better than that, so the
/// picture is, too. Infinite where a pixel has fewer than two samples.
double noise_of(const FilmSnapshot& film);
/// Memory that this takes meanwhile, bytes of a pixel.
inline constexpr std::size_t noise_bytes = 24;

}  // namespace tessera::server
