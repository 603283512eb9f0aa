// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Camera rays: pinhole, thin lens or orthographic. Camera space looks along -Z, +Y up.
#ifndef WAVEFRONT_LIB_CAMERA_GLSL
#define WAVEFRONT_LIB_CAMERA_GLSL
#include "lib/bindings.glsl"

// The condition itself. Said of constants of the frame that a branch goes by: lavapipe compiles a kernel anew for each value
// of such a uniform where that saves enough of its code (lvp_inline_uniforms), in the middle of a render and with each edit of
// the camera. It cannot see that no invocation has this number.
bool isSet(bool condition) { return condition == (gl_GlobalInvocationID.x != 0xffffffffu); }

// Concentric map of the unit square to the unit disk (Shirley and Chiu 1997).
vec2 sampleDisk(vec2 u) {
  vec2 o = 2.0 * u - 1.0;
  if (o.x == 0.0 && o.y == 0.0) return vec2(0.0);
  bool wide = abs(o.x) > abs(o.y);
  float r = wide ? o.x : o.y;
  float theta = wide ? 0.78539816 * (o.y / o.x) : 1.57079633 - 0.78539816 * (o.x / o.y);
  return r * vec2(cos(theta), sin(theta));
}
vec3 cameraPoint(vec3 p) {
  vec4 q = vec4(p, 1.0);
  return vec3(dot(frame.cameraToWorld0, q), dot(frame.cameraToWorld1, q), dot(frame.cameraToWorld2, q));
}
vec3 cameraVector(vec3 v) {
  return vec3(dot(frame.cameraToWorld0.xyz, v), dot(frame.cameraToWorld1.xyz, v), dot(frame.cameraToWorld2.xyz, v));
}

// The part of o + t d that the plane leaves; an interval with tMax < tMin holds nothing.
void clipRay(vec4 plane, vec3 o, vec3 d, inout float tMin, inout float tMax) {
  float at = dot(plane.xyz, o) + plane.w, rate = dot(plane.xyz, d);
  if (rate > 0.0) tMin = max(tMin, -at / rate);
  else if (rate < 0.0) tMax = min(tMax, -at / rate);
  else if (at < 0.0) tMax = -1.0;
}

// `pixel`: continuous image position, x to the right, y *down* from the top row. tMin and tMax honour the clipping range.
void cameraRay(vec2 pixel, vec2 uLens, out vec3 origin, out vec3 direction, out float tMin, out float tMax) {
  vec2 s = vec2(mix(frame.window.x, frame.window.y, pixel.x / float(frame.width)),
                mix(frame.window.w, frame.window.z, pixel.y / float(frame.height)));
  vec3 o, d;
  if (isSet(frame.orthographic != 0u)) {
    o = vec3(s, 0.0);
    d = vec3(0.0, 0.0, -1.0);
  } else {
    o = vec3(0.0);
    d = vec3(s, -1.0);
    if (isSet(frame.lensRadius > 0.0)) {
      o = vec3(frame.lensRadius * sampleDisk(uLens), 0.0);
      d = d * frame.focusDistance - o;
    }
  }
  d = normalize(d);
  float perUnitDepth = 1.0 / -d.z;  // distance along the ray per unit of depth
  origin = cameraPoint(o);
  vec3 w = cameraVector(d);
  float scale = length(w);          // a scaled camera transform scales distances, too
  direction = w / scale;
  tMin = frame.nearClip * perUnitDepth;
  tMax = frame.farClip * perUnitDepth;
  if (isSet(frame.clipPlaneCount > 0u)) clipRay(frame.clipPlane0, o, d, tMin, tMax);
  if (isSet(frame.clipPlaneCount > 1u)) clipRay(frame.clipPlane1, o, d, tMin, tMax);
  if (isSet(frame.clipPlaneCount > 2u)) clipRay(frame.clipPlane2, o, d, tMin, tMax);
  if (isSet(frame.clipPlaneCount > 3u)) clipRay(frame.clipPlane3, o, d, tMin, tMax);
  if (isSet(frame.clipPlaneCount > 4u)) clipRay(frame.clipPlane4, o, d, tMin, tMax);
  if (isSet(frame.clipPlaneCount > 5u)) clipRay(frame.clipPlane5, o, d, tMin, tMax);
  tMin *= scale;
  tMax *= scale;
}
#endif
