#pragma once
// What differs between Embree 3 (Debian 12) and Embree 4 (Debian 13), and nothing else.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace tessera::accel::embree {

#if RTC_VERSION_MAJOR >= 4
using Context = RTCRayQueryContext;

inline void intersect(RTCScene scene, RTCRayHit& ray) { rtcIntersect1(scene, &ray); }
inline void occluded(RTCScene scene, RTCRay& ray) { rtcOccluded1(scene, &ray); }
#else
using Context = RTCIntersectContext;

inline void intersect(RTCScene scene, RTCRayHit& ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, &ray);
}
inline void occluded(RTCScene scene, RTCRay& ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, &ray);
}
#endif

/// A user geometry's hit stands in the instance that the traversal is in.
inline void set_instance(RTCHit& hit, const Context& context) {
  hit.instID[0] = context.instID[0];
#if defined(RTC_GEOMETRY_INSTANCE_ARRAY)
  hit.instPrimID[0] = context.instPrimID[0];
#endif
}

}  // namespace tessera::accel::embree
