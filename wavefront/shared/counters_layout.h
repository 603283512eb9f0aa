// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// The counters buffer: work left, queue counts, indirect arguments, statistics. One definition for C++ and GLSL.
#ifndef WAVEFRONT_SHARED_COUNTERS_LAYOUT_H
#define WAVEFRONT_SHARED_COUNTERS_LAYOUT_H
#ifdef __cplusplus
#include <cstdint>
#define WF_CONST(name, value) constexpr uint32_t name = value;
namespace wavefront::layout {
#else
#define WF_CONST(name, value) const uint name = value;
#endif
// All offsets count uints.
WF_CONST(kErrorFlags, 0u)        // kError*
WF_CONST(kWorkSample, 1u)        // next sample and pixel to start; the pair is ordered sample-major
WF_CONST(kWorkPixel, 2u)
WF_CONST(kWorkEndSample, 3u)     // samples >= this are not started
WF_CONST(kActivePaths, 4u)       // paths in flight after the last scan
WF_CONST(kIterations, 5u)
WF_CONST(kNewPathBaseSample, 6u) // work index of the first path that new_path starts in this iteration
WF_CONST(kNewPathBasePixel, 7u)
WF_CONST(kNewPathCount, 8u)
WF_CONST(kPoolArgs, 9u)          // x y z groups of the kernels over the whole pool; 0 once nothing is left to do
WF_CONST(kScanArgs, 12u)         // x y z groups of scan_buckets; likewise
// Queues: 8 words each: count being filled, count being traced, args x y z, items lo, items hi, peak
WF_CONST(kQueueBase, 16u)
WF_CONST(kQueueStride, 8u)
WF_CONST(kQueueFill, 0u)
WF_CONST(kQueueCount, 1u)
WF_CONST(kQueueArgs, 2u)
WF_CONST(kQueueItemsLo, 5u)
WF_CONST(kQueueItemsHi, 6u)
WF_CONST(kQueuePeak, 7u)
WF_CONST(kPathsDoneLo, 80u)
WF_CONST(kPathsDoneHi, 81u)
WF_CONST(kMegaNextWork, 82u)     // megakernel: work taken since mega_turn, counted past the end
// Buckets: 10 words each: count, offset in the sorted indices, args x y z, items lo, items hi, peak, whether its paths are
// held because its kernel is still being compiled, and what one path of it costs (float, ns)
WF_CONST(kBucketBase, 96u)
WF_CONST(kBucketStride, 10u)
WF_CONST(kBucketCount, 0u)
WF_CONST(kBucketOffset, 1u)
WF_CONST(kBucketArgs, 2u)
WF_CONST(kBucketItemsLo, 5u)
WF_CONST(kBucketItemsHi, 6u)
WF_CONST(kBucketPeak, 7u)
WF_CONST(kBucketHold, 8u)
WF_CONST(kBucketCost, 9u)
WF_CONST(kBucketNewPath, 0u)     // bucket 0: idle paths; then one bucket per material entry point
WF_CONST(kFirstMaterialBucket, 1u)
// Behind the buckets: their counts while logic fills them, and the places that scatter hands out, for each quarter of the
// pool by itself and a cache line apart. A core of a software device works on neighbouring paths: its additions meet
// no other core's.
WF_CONST(kPoolParts, 4u)
WF_CONST(kPartLine, 16u)
// Queue items: arrays of poolSize uints
WF_CONST(kItemsKeys, 0u)         // bucket of each path (kNoBucket: none)
WF_CONST(kItemsSorted, 1u)       // path indices by bucket
WF_CONST(kItemsQueues, 2u)       // path indices of queue 0; one array per row of queues.def

WF_CONST(kErrorTraversalBudget, 1u)  // a ray gave up in the BVH
WF_CONST(kErrorStackOverflow, 2u)
WF_CONST(kErrorNonFinite, 4u)        // a sample was not finite and was dropped
WF_CONST(kErrorTransparency, 8u)     // more transparent layers than maxTransparency: the rest blocked
WF_CONST(kErrorMediaStack, 16u)      // more than four nested media
WF_CONST(kErrorMediumSteps, 32u)     // a path scattered more often inside of a body than is allowed and was ended
#ifdef __cplusplus
// Where the counts of the parts begin, and how far they are from each other.
constexpr uint32_t PartCounts(uint32_t bucketCount) { return (kBucketBase + kBucketStride * bucketCount + kPartLine - 1) / kPartLine * kPartLine; }
constexpr uint32_t PartStride(uint32_t bucketCount) { return (bucketCount + kPartLine - 1) / kPartLine * kPartLine; }
}  // namespace wavefront::layout
#endif
#undef WF_CONST
#endif
