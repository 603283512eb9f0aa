// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Rays through the two-level BVH: nearest hit, and whether a shadow ray gets through.
//
// What is hit is a function of the ray and the scene alone: t, u, v come from the triangle test in object space;
// boxes only ever skip what cannot be hit, so no tree shape, node width or fetch path changes a result; of hits at
// the same t the smallest (instance, triangle in mesh order) wins. (Where the triangle test itself is off by more than the
// boxes' slack - slivers thousands of times as long as wide - the tree does count: resources/TRAVERSAL.md.) A triangle may
// stand in several leaves, under records that are all alike; which of them a hit names depends on the tree.
//
// Needs before it: bindings (bvhNodes, bvhWords, triangleRecords, instanceRecords), and somewhere in the kernel the two hooks
// declared below. Layout of the code for lavapipe, which executes a loop's body once more when a `break` stands in
// front of it, and both sides of every `if`: loops test at their end, rare work stays out of the inner loops. What was
// tried, and what it cost: resources/TRAVERSAL.md.
#ifndef WAVEFRONT_LIB_TRAVERSE_GLSL
#define WAVEFRONT_LIB_TRAVERSE_GLSL
#include "shared/scene_layout.h"
#include "lib/features.glsl"
#include "lib/ray.glsl"
#include "lib/bvh_fetch.glsl"
#include "lib/intersect_triangle.glsl"
#include "lib/intersect_light_shape.glsl"

// Hook: a ray took more steps than the budget allows; its answer cannot be trusted. Sets an error that the host
// reports.
void reportTraversalOverflow();
// Hook: nothing passes through this material slot of the instance (asked only where the instance is not
// kInstanceOpaque, at most once per shadow ray).
bool isTriangleOpaque(uint instance, uint slot);

// An entry for each level that has children left (kMeshMaxDepth + kInstanceMaxDepth of scene/bvh/bvh.h), one for each
// of the two trees below its root, and one that a step may write before it knows whether it needs it.
const uint kTraversalStackSize = 21u + 15u + 3u;
uint traversalStack[kTraversalStackSize];

// Steps of one ray over all its loops. lavapipe 22.3.6 ends loops silently after 65,535 iterations, counted per
// group of 8 lanes, which in nested loops can take as many as all lanes together.
const uint kTraversalBudget = 8000u;
uint traversalSteps = 0u;  // of all rays of this invocation so far: a step is at most two iterations of a loop

const float kMaxFloat = 3.402823466e38;

bool isInnerNode(uint reference) { return (reference & kBvhLeafBit) == 0u; }

// ---- Boxes ----------------------------------------------------------------------------------------------------

// A ray as boxes of one tree see it. `slack` widens every box, in units of t. With eps = 2^-24, R the largest coordinate
// in the tree and |v - o| <= |o| + R it covers
//  - in a mesh: the box test's own rounding (4 eps) and the triangle test's, which can report a hit up to about 8 eps
//    (|o| + R) beside the triangle: 16 eps (|o| + R) in all;
//  - in the tree over instances: the rounding on the way to object space, which moves the ray as seen from the world
//    by up to 8 eps |M| |W| (|o| + R), |M| |W| being 1 to 3 for rotations and scales, more for shears (products of the
//    absolute values of both matrices). 128 eps (|o| + R) covers 16; InstanceBounds adds for shears beyond that.
const float kMeshSlack = 9.5367431640625e-7;    // 2^-20
const float kInstanceSlack = 7.62939453125e-6;  // 2^-17

struct BoxRay {
  vec3 origin;
  vec3 inverse;
  vec3 slack;
};

vec3 nodeSteps(uint exponents) {
  return uintBitsToFloat((uvec3(exponents) << uvec3(23u, 15u, 7u)) & 0x7f800000u);
}

BoxRay prepareBoxRay(vec3 origin, vec3 direction, uint rootNode, float relativeSlack) {
  uvec4 root = fetchBvhNode(rootNode * kBvhNodeTexels);
  vec3 reach = abs(uintBitsToFloat(root.xyz)) + 255.0 * nodeSteps(root.w) + abs(origin);
  float slack = max(reach.x, max(reach.y, reach.z)) * relativeSlack;
  // A component of 0 becomes one that moves the ray by far less than the slack.
  vec3 a = abs(direction);
  float least = max(a.x, max(a.y, a.z)) * 9.094947017729282e-13;  // 2^-40
  vec3 inverse = 1.0 / mix(direction, mix(vec3(least), vec3(-least), lessThan(direction, vec3(0.0))),
                           lessThan(a, vec3(least)));
  return BoxRay(origin, inverse, slack * abs(inverse));
}

vec4 unpackBytes(uint word) { return vec4((uvec4(word) >> uvec4(0u, 8u, 16u, 24u)) & 255u); }

// An entry of the stack: what is left of a node whose children are visited in order. The node, counted from the start of
// the stream (kBvhMaxNodes), and the places of one to three children, two bits each, the next one lowest, the last one
// repeated. kBvhEmpty: the end of a tree. One store for each node instead of one for each child: on lavapipe a store to
// an address of its own in each lane is eight stores behind eight branches.
const uint kPlaceBits = 6u;

bool isLastPlace(uint entry) { return (entry >> 2u & 3u) == (entry & 3u); }
uint withoutFirstPlace(uint entry) { return (entry & 0xfffffff0u) | (entry >> 2u & 15u); }

uint firstReferenceOf(uint entry) {
  bool atEnd = entry == kBvhEmpty;
  uint reference = fetchBvhChild(atEnd ? 0u : entry >> kPlaceBits, entry & 3u);
  return atEnd ? kBvhEmpty : reference;
}

// What a ray has still to visit: the top entry, which is not in traversalStack, and the reference of its first child,
// fetched as soon as it is known, so that nothing waits for it.
struct Todo {
  uint top;  // entries in traversalStack
  uint entry;
  uint next;
};

// At the root of the tree over instances, or of a mesh: at the end of the tree what was left before goes on.
Todo enterTree(uint top, uint left) {
  traversalStack[top] = left;
  return Todo(top + 1u, kBvhEmpty, kBvhEmpty);
}

// kBvhEmpty at the end of a tree.
uint popReference(inout Todo todo) {
  uint reference = todo.next;
  bool isLast = isLastPlace(todo.entry);
  uint below = traversalStack[todo.top - 1u];
  todo.entry = isLast ? below : withoutFirstPlace(todo.entry);
  todo.top -= uint(isLast);
  todo.next = firstReferenceOf(todo.entry);
  return reference;
}

// Tests the children of an inner node against [tMin, tMax]; returns the nearest (ordered) or any that is met and leaves
// the others to be visited. If there is none, returns what is next.
uint stepDown(uint node, BoxRay ray, float tMin, float tMax, const bool ordered, inout Todo todo) {
  uint texel = node * kBvhNodeTexels;
  uvec4 head = fetchBvhNode(texel);
  uvec4 children = fetchBvhNode(texel + 1u);
  uvec4 planes = fetchBvhNode(texel + 2u);
  uvec2 planesHigh = fetchBvhNode(texel + 3u).xy;
  vec3 scale = nodeSteps(head.w) * ray.inverse;
  vec3 base = (uintBitsToFloat(head.xyz) - ray.origin) * ray.inverse;
  vec3 baseNear = base - ray.slack;
  vec3 baseFar = base + ray.slack;
  bvec3 backwards = lessThan(ray.inverse, vec3(0.0));
  uvec3 low = planes.xyz;
  uvec3 high = uvec3(planes.w, planesHigh);
  uvec3 near = mix(low, high, backwards);
  uvec3 far = mix(high, low, backwards);
  // As integers, whose minimum and maximum are one instruction; those of floats ask for NaNs. tMin is not negative:
  // the maximum is right, and a minimum of several negative numbers is one of them. A NaN counts as met. The ends lose
  // their sign: -0, which a flight of no length gives, would be less than all other numbers.
  ivec2 ends = floatBitsToInt(vec2(tMin, tMax)) & 0x7fffffff;
  ivec4 nearX = floatBitsToInt(unpackBytes(near.x) * scale.x + baseNear.x);
  ivec4 nearY = floatBitsToInt(unpackBytes(near.y) * scale.y + baseNear.y);
  ivec4 nearZ = floatBitsToInt(unpackBytes(near.z) * scale.z + baseNear.z);
  ivec4 farX = floatBitsToInt(unpackBytes(far.x) * scale.x + baseFar.x);
  ivec4 farY = floatBitsToInt(unpackBytes(far.y) * scale.y + baseFar.y);
  ivec4 farZ = floatBitsToInt(unpackBytes(far.z) * scale.z + baseFar.z);
  ivec4 tNear = max(max(nearX, nearY), max(nearZ, ivec4(ends.x)));
  ivec4 tFar = min(min(farX, farY), min(farZ, ivec4(ends.y)));
  bvec4 missed = greaterThan(intBitsToFloat(tNear), intBitsToFloat(tFar));
  // Keys sort by distance and hold the child's place in the last two bits.
  const uint kNone = 0xffffffffu;
  uvec4 keys = uvec4(0u, 1u, 2u, 3u);
  if (ordered) keys |= uvec4(tNear) & 0xfffffffcu;
  keys = mix(keys, uvec4(kNone), equal(children, uvec4(kBvhEmpty)));
  keys = mix(keys, uvec4(kNone), missed);
  uvec2 small = min(keys.xz, keys.yw);
  uvec2 large = max(keys.xz, keys.yw);
  uint first = min(small.x, small.y);
  uint last = max(large.x, large.y);
  uint a = max(small.x, small.y);
  uint b = min(large.x, large.y);
  uint second = min(a, b);
  uint third = max(a, b);
  bool any = first != kNone;
  bool many = second != kNone;
  uint reference = any ? children[first & 3u] : todo.next;
  third = third == kNone ? second : third;
  last = last == kNone ? third : last;
  uint others = node << kPlaceBits | (last & 3u) << 4u | (third & 3u) << 2u | (second & 3u);
  bool isLast = isLastPlace(todo.entry);
  traversalStack[todo.top] = todo.entry;
  uint below = traversalStack[todo.top - 1u];
  todo.entry = many ? others : (any ? todo.entry : (isLast ? below : withoutFirstPlace(todo.entry)));
  todo.top = many ? todo.top + 1u : (!any && isLast ? todo.top - 1u : todo.top);
  todo.next = firstReferenceOf(todo.entry);
  return reference;
}

// ---- Instances ------------------------------------------------------------------------------------------------

// What a ray may still hit at its very beginning. A ray that goes on behind a surface keeps its origin, sets tMin to
// that hit's t and names the hit: then what lies at the same t and later in order is found, and nothing twice.
// The named triangle itself is never hit: it is flat, and has been passed, or is what the ray starts on.
struct InstanceVisit {
  vec3 origin;
  vec3 direction;
  uint nodeBase;
  uint triangleBase;
  uint flags;
  uint firstAtMin;   // at t == tMin, hits need a mesh triangle >= this (kNoHit: none is taken)
  uint skipped;      // mesh triangle that is never hit
  bool enter;        // visible and usable
};

bool isFiniteVector(vec3 v) { return all(lessThanEqual(abs(v), vec3(kMaxFloat))); }

// The mesh triangle behind a record; 0 for light shapes, whose records do not exist.
uint meshTriangleOf(uint instance, uint record) {
  bool isMesh = (fetchInstanceU(instance * kInstanceTexels + 3u).z & kInstanceKindMask) == kKindMesh;
  uint index = floatBitsToUint(fetchTriangle(record * kTriangleTexels).w);
  return isMesh ? index : 0u;
}

InstanceVisit visitInstance(uint instance, Ray ray, uint visibilityMask, uint skipInstance, uint skipMeshTriangle) {
  InstanceVisit visit;
  uint texel = instance * kInstanceTexels;
  uvec4 info = fetchInstanceU(texel + 3u);
  vec4 x = fetchInstanceF(texel);
  vec4 y = fetchInstanceF(texel + 1u);
  vec4 z = fetchInstanceF(texel + 2u);
  vec3 o = ray.origin;
  vec3 d = ray.direction;
  // Written out: the order of the sums is part of what makes t a function of ray and scene in every kernel.
  precise vec3 origin = vec3(x.x * o.x + x.y * o.y + x.z * o.z + x.w, y.x * o.x + y.y * o.y + y.z * o.z + y.w,
                             z.x * o.x + z.y * o.y + z.z * o.z + z.w);
  precise vec3 direction = vec3(x.x * d.x + x.y * d.y + x.z * d.z, y.x * d.x + y.y * d.y + y.z * d.z,
                                z.x * d.x + z.y * d.y + z.z * d.z);
  visit.origin = origin;
  visit.direction = direction;
  visit.nodeBase = info.x;
  visit.triangleBase = info.y;
  visit.flags = info.z;
  bool isSkipped = instance == skipInstance;
  bool goesOn = skipInstance != kNoHit;
  visit.firstAtMin = !goesOn || instance > skipInstance ? 0u : (isSkipped ? skipMeshTriangle + 1u : kNoHit);
  visit.skipped = isSkipped ? skipMeshTriangle : kNoHit;
  visit.enter = (info.w & visibilityMask & 0xffu) != 0u && isFiniteVector(origin) && isFiniteVector(direction);
  return visit;
}

bool isUsableRay(Ray ray) {
  return isFiniteVector(ray.origin) && isFiniteVector(ray.direction) && any(notEqual(ray.direction, vec3(0.0))) &&
         ray.tMin <= ray.tMax && ray.tMax >= 0.0;
}

// The better of two hits: nearer, then earlier in (instance, mesh triangle).
bool isBefore(float tA, uint instanceA, uint triangleA, float tB, uint instanceB, uint triangleB) {
  return tA < tB || (tA == tB && (instanceA < instanceB || (instanceA == instanceB && triangleA < triangleB)));
}

// ---- Nearest hit ----------------------------------------------------------------------------------------------

// Nearest hit with tMin <= t <= tMax on instances whose visibility meets the mask: true, and `hit` is set; else `hit`
// is left alone. skipInstance, skipTriangle (record): the surface that the ray starts on or goes on behind (see
// InstanceVisit); kNoHit: none. Light shapes count like any other surface.
bool traverseClosest(Ray ray, uint visibilityMask, uint skipInstance, uint skipTriangle, inout Hit hit) {
  if (!isUsableRay(ray)) return false;
  float tMin = max(ray.tMin, 0.0);
  float tMax = min(ray.tMax, kMaxFloat);
  uint skipMeshTriangle = skipInstance == kNoHit ? kNoHit : meshTriangleOf(skipInstance, skipTriangle);
  Hit best = noHit(tMax);
  uint bestMeshTriangle = kNoHit;
  BoxRay worldRay = prepareBoxRay(ray.origin, ray.direction, tlasRoot(), kInstanceSlack);
  uint steps = 0u;
  Todo todo = enterTree(0u, kBvhEmpty);
  uint reference = 0u;
  do {
    do {
      reference = stepDown(tlasRoot() + reference, worldRay, tMin, best.t, true, todo);
      ++steps;
    } while (isInnerNode(reference) && steps < kTraversalBudget);
    // Instance after instance, until an inner node comes off the stack.
    bool atInstance = reference != kBvhEmpty && !isInnerNode(reference);
    if (atInstance) {
      do {
        uint instance = reference & kBvhLeafFirstMask;
        InstanceVisit visit = visitInstance(instance, ray, visibilityMask, skipInstance, skipMeshTriangle);
        uint kind = visit.flags & kInstanceKindMask;
        if (kHasLightShapes && visit.enter && kind != kKindMesh) {
          float t, u, v;
          bool found = intersectLightShape(kind, visit.origin, visit.direction, tMin, visit.firstAtMin != 0u, t, u, v);
          if (found && isBefore(t, instance, 0u, best.t, best.instance, bestMeshTriangle)) {
            best = Hit(t, instance, 0u, u, v);
            bestMeshTriangle = 0u;
          }
        }
        if (visit.enter && kind == kKindMesh) {
          BoxRay boxRay = prepareBoxRay(visit.origin, visit.direction, visit.nodeBase, kMeshSlack);
          TriangleTestRay testRay = prepareTriangleTest(visit.origin, visit.direction);
          todo = enterTree(todo.top, todo.entry);
          uint inside = 0u;
          do {
            do {
              inside = stepDown(visit.nodeBase + inside, boxRay, tMin, best.t, true, todo);
              ++steps;
            } while (isInnerNode(inside) && steps < kTraversalBudget);
            // Leaf after leaf, one triangle per turn, until an inner node comes off the stack.
            bool inLeaf = inside != kBvhEmpty && !isInnerNode(inside);
            if (inLeaf) {
              uint record = visit.triangleBase + (inside & kBvhLeafFirstMask);
              uint left = (inside >> kBvhLeafCountShift) & 7u;
              do {
                vec4 v0 = fetchTriangle(record * kTriangleTexels);
                vec3 v1 = fetchTriangle(record * kTriangleTexels + 1u).xyz;
                vec3 v2 = fetchTriangle(record * kTriangleTexels + 2u).xyz;
                float t, u, v;
                bool found = intersectTriangle(testRay, v0.xyz, v1, v2, t, u, v);
                uint meshTriangle = floatBitsToUint(v0.w);
                found = found && meshTriangle != visit.skipped &&
                        (t > tMin || (t == tMin && meshTriangle >= visit.firstAtMin && visit.firstAtMin != kNoHit)) &&
                        isBefore(t, instance, meshTriangle, best.t, best.instance, bestMeshTriangle);
                if (found) {
                  best = Hit(t, instance, record, u, v);
                  bestMeshTriangle = meshTriangle;
                }
                ++steps;
                if (left == 0u) {
                  inside = popReference(todo);
                  inLeaf = inside != kBvhEmpty && !isInnerNode(inside);
                  record = visit.triangleBase + (inside & kBvhLeafFirstMask);
                  left = (inside >> kBvhLeafCountShift) & 7u;
                } else {
                  --left;
                  ++record;
                }
              } while (inLeaf && steps < kTraversalBudget);
            }
          } while (inside != kBvhEmpty && steps < kTraversalBudget);
        }
        reference = popReference(todo);
        atInstance = reference != kBvhEmpty && !isInnerNode(reference);
      } while (atInstance && steps < kTraversalBudget);
    }
  } while (reference != kBvhEmpty && steps < kTraversalBudget);
  traversalSteps += steps;
  if (steps >= kTraversalBudget) reportTraversalOverflow();
  if (best.instance == kNoHit) return false;
  hit = best;
  return true;
}

// ---- Shadow rays ----------------------------------------------------------------------------------------------

const uint kShadowClear = 0u;
const uint kShadowBlocked = 1u;
const uint kShadowNeedsOpacity = 2u;

// Whether anything stands between tMin and tMax. Blocked: something opaque does, wherever. NeedsOpacity: something that
// may let light through does; `candidate` is the nearest such hit. The opacity kernel weighs it and, if light is left,
// the ray goes on behind it (tMin = candidate.t, skip = candidate). Light shapes throw no shadows.
// An instance with opaque and other materials counts as one that may let light through, hit by hit.
uint traverseShadow(Ray ray, uint visibilityMask, uint skipInstance, uint skipTriangle, out Hit candidate) {
  candidate = noHit(ray.tMax);
  if (!isUsableRay(ray)) return kShadowClear;
  float tMin = max(ray.tMin, 0.0);
  float tMax = min(ray.tMax, kMaxFloat);
  uint skipMeshTriangle = skipInstance == kNoHit ? kNoHit : meshTriangleOf(skipInstance, skipTriangle);
  Hit best = noHit(tMax);
  uint bestMeshTriangle = kNoHit;
  bool blocked = false;
  BoxRay worldRay = prepareBoxRay(ray.origin, ray.direction, tlasRoot(), kInstanceSlack);
  uint steps = 0u;
  Todo todo = enterTree(0u, kBvhEmpty);
  uint reference = 0u;
  do {
    do {
      reference = stepDown(tlasRoot() + reference, worldRay, tMin, tMax, false, todo);
      ++steps;
    } while (isInnerNode(reference) && steps < kTraversalBudget);
    // Instance after instance, until an inner node comes off the stack.
    bool atInstance = reference != kBvhEmpty && !isInnerNode(reference);
    if (atInstance) {
      do {
        uint instance = reference & kBvhLeafFirstMask;
        InstanceVisit visit = visitInstance(instance, ray, visibilityMask, skipInstance, skipMeshTriangle);
        bool opaque = (visit.flags & kInstanceOpaque) != 0u;
        if (visit.enter && (visit.flags & kInstanceKindMask) == kKindMesh) {
          BoxRay boxRay = prepareBoxRay(visit.origin, visit.direction, visit.nodeBase, kMeshSlack);
          TriangleTestRay testRay = prepareTriangleTest(visit.origin, visit.direction);
          todo = enterTree(todo.top, todo.entry);
          uint inside = 0u;
          do {
            float tEnd = opaque ? tMax : best.t;
            do {
              inside = stepDown(visit.nodeBase + inside, boxRay, tMin, tEnd, false, todo);
              ++steps;
            } while (isInnerNode(inside) && steps < kTraversalBudget);
            bool inLeaf = inside != kBvhEmpty && !isInnerNode(inside);
            if (inLeaf) {
              uint record = visit.triangleBase + (inside & kBvhLeafFirstMask);
              uint left = (inside >> kBvhLeafCountShift) & 7u;
              do {
                vec4 v0 = fetchTriangle(record * kTriangleTexels);
                vec3 v1 = fetchTriangle(record * kTriangleTexels + 1u).xyz;
                vec3 v2 = fetchTriangle(record * kTriangleTexels + 2u).xyz;
                float t, u, v;
                bool found = intersectTriangle(testRay, v0.xyz, v1, v2, t, u, v);
                uint meshTriangle = floatBitsToUint(v0.w);
                found = found && meshTriangle != visit.skipped && t <= tMax &&
                        (t > tMin || (t == tMin && meshTriangle >= visit.firstAtMin && visit.firstAtMin != kNoHit));
                blocked = blocked || (found && opaque);
                if (found && isBefore(t, instance, meshTriangle, best.t, best.instance, bestMeshTriangle)) {
                  best = Hit(t, instance, record, u, v);
                  bestMeshTriangle = meshTriangle;
                }
                ++steps;
                if (left == 0u) {
                  inside = popReference(todo);
                  inLeaf = inside != kBvhEmpty && !isInnerNode(inside);
                  record = visit.triangleBase + (inside & kBvhLeafFirstMask);
                  left = (inside >> kBvhLeafCountShift) & 7u;
                } else {
                  --left;
                  ++record;
                }
              } while (inLeaf && !blocked && steps < kTraversalBudget);
            }
          } while (inside != kBvhEmpty && !blocked && steps < kTraversalBudget);
        }
        reference = popReference(todo);
        atInstance = reference != kBvhEmpty && !isInnerNode(reference);
      } while (atInstance && !blocked && steps < kTraversalBudget);
    }
  } while (reference != kBvhEmpty && !blocked && steps < kTraversalBudget);
  traversalSteps += steps;
  if (steps >= kTraversalBudget) reportTraversalOverflow();
  if (blocked) return kShadowBlocked;
  if (best.instance == kNoHit) return kShadowClear;
  uint slot = floatBitsToUint(fetchTriangle(best.triangle * kTriangleTexels + 1u).w);
  if (isTriangleOpaque(best.instance, slot)) return kShadowBlocked;
  candidate = best;
  return kShadowNeedsOpacity;
}

#endif
