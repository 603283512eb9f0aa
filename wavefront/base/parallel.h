// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Parallel loops for work on the host: scene building, texture decoding. No pool is kept: threads live for
// one call, so nothing outlives a renderer and nothing needs to be shut down.
#pragma once

#include <cstddef>
#include <functional>

namespace wavefront {

// Threads to use when the caller has no wish: HDWAVEFRONT_THREADS if it is a positive number, else the
// number of hardware threads; at least 1, at most 256.
unsigned DefaultThreadCount();

// Calls fn(i) once for every i in [0, count), on up to `threads` threads (0: DefaultThreadCount()), the
// calling thread among them; returns when all are done. Indices are handed out one by one in rising order.
// If fn throws, no further index is handed out and the first exception is rethrown here. Calls may nest.
void ParallelFor(size_t count, unsigned threads, const std::function<void(size_t)>& fn);

}  // namespace wavefront
