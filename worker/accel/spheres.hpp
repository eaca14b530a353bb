#pragma once
#include "worker/accel/embree.hpp"

namespace tessera::accel {

// Callbacks of a user geometry whose user data is an array of accel::Sphere.
void sphere_bounds(const RTCBoundsFunctionArguments* args);
void sphere_intersect(const RTCIntersectFunctionNArguments* args);
void sphere_occluded(const RTCOccludedFunctionNArguments* args);

}  // namespace tessera::accel
