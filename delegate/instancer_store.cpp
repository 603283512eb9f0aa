// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "delegate/instancer_store.h"

#include <algorithm>
#include <set>

#include "delegate/prims/matrix.h"
#include "delegate/prims/same.h"
#include "wavefront/base/parallel.h"

namespace delegate {
namespace {

constexpr size_t kMaxDepth = 64;

// The pair of samples around a time, as ComposeInstances takes them.
Matrix4d MatrixAt(const auto& sampleValue, const auto& samples, float time) {
  size_t after = 0;
  while (after < samples.size() && samples[after].time < time) ++after;
  if (after == samples.size()) return sampleValue(samples.back());
  if (after == 0 || samples[after].time == time) return sampleValue(samples[after]);
  const double span = double{samples[after].time} - samples[after - 1].time;
  return Lerp(sampleValue(samples[after - 1]), sampleValue(samples[after]),
              (double{time} - samples[after - 1].time) / span);
}

}  // namespace

InstancerStore::InstancerStore(wavefront::DiagnosticSink sink, unsigned threads)
    : sink_(std::move(sink)), threads_(threads) {}

InstancerStore::Instancer& InstancerStore::FindOrCreate(const std::string& path) {
  std::lock_guard lock(mutex_);
  auto& instancer = instancers_[path];
  if (!instancer) {
    instancer = std::make_unique<Instancer>();
    instancer->state.path = path;
    instancer->version = ++version_;
  }
  return *instancer;
}

void InstancerStore::Create(const std::string& path) { FindOrCreate(path); }

bool InstancerStore::Sync(const std::string& path, InstancerUpdate update) {
  Instancer& instancer = FindOrCreate(path);
  InstancerState& s = instancer.state;
  bool changed = Take(s.transforms, update.transforms);
  changed |= Take(s.positions, update.positions);
  changed |= Take(s.orientations, update.orientations);
  changed |= Take(s.scales, update.scales);
  changed |= Take(s.protoIndices, update.protoIndices);
  changed |= Take(s.prototypeInstances, update.prototypeInstances);
  changed |= Take(s.ids, update.ids);
  changed |= Take(s.invisibleIds, update.invisibleIds);
  if (update.transform && update.transform->empty()) update.transform.reset();
  changed |= Take(s.transform, update.transform);
  changed |= Take(s.primvars, update.primvars);
  changed |= Take(s.visible, update.visible);
  changed |= Take(s.parent, update.parent);
  changed |= Take(s.parentPrototype, update.parentPrototype);
  if (!changed) return false;
  std::lock_guard lock(mutex_);
  instancer.version = ++version_;
  return true;
}

void InstancerStore::Destroy(const std::string& path) {
  std::lock_guard lock(mutex_);
  instancers_.erase(path);
}

uint64_t InstancerStore::Signature(const std::string& path, int32_t prototype) {
  uint64_t hash = 0;
  const auto mix = [&hash](uint64_t v) { hash = (hash ^ v) * 0x100000001b3ull + 0x9e3779b97f4a7c15ull; };
  std::string current = path;
  for (size_t depth = 0; !current.empty() && depth < kMaxDepth; ++depth) {
    const auto found = instancers_.find(current);
    mix(std::hash<std::string>()(current));
    if (found == instancers_.end()) break;
    mix(found->second->version);
    mix(static_cast<uint64_t>(prototype));
    prototype = found->second->state.parentPrototype;
    current = found->second->state.parent;
  }
  return hash;
}

std::shared_ptr<const FlatInstances> InstancerStore::Flatten(const std::string& path, int32_t prototype) {
  auto& known = flattened_[{path, prototype}];
  if (known) return known;
  std::vector<const InstancerState*> chain;
  std::vector<int32_t> prototypes;
  std::string current = path;
  bool broken = false;
  while (!current.empty() && !broken) {
    const auto found = instancers_.find(current);
    if (found == instancers_.end()) {
      sink_({wavefront::Severity::Warning, "instancer-missing", path,
             "The instancer " + current + " does not exist; nothing is drawn."});
      broken = true;
    } else if (chain.size() == kMaxDepth) {
      sink_({wavefront::Severity::Warning, "instancer-cycle", path,
             "Instancers are nested more than 64 deep, or in a circle; nothing is drawn."});
      broken = true;
    } else {
      chain.push_back(&found->second->state);
      prototypes.push_back(prototype);
      prototype = found->second->state.parentPrototype;
      current = found->second->state.parent;
    }
  }
  known = std::make_shared<const FlatInstances>(broken ? FlatInstances()
                                                       : ComposeInstances(chain, prototypes, threads_, sink_));
  return known;
}

std::vector<TimeSamples<Matrix4d>> InstanceTransforms(const TimeSamples<Matrix4d>& prim, const FlatInstances& instances,
                                                      unsigned threads) {
  std::set<float> times;
  if (prim.size() > 1)
    for (const auto& sample : prim) times.insert(sample.time);
  if (instances.transforms.size() > 1)
    for (const auto& sample : instances.transforms) times.insert(sample.time);
  if (times.empty()) times.insert(0);
  const std::vector<float> order(times.begin(), times.end());
  std::vector<Matrix4d> primAt;
  for (float time : order)
    primAt.push_back(MatrixAt([](const auto& sample) { return sample.value; }, prim, time));

  std::vector<TimeSamples<Matrix4d>> result(instances.indices.size());
  constexpr size_t kBlock = 16384;
  const size_t blocks = (result.size() + kBlock - 1) / kBlock;
  wavefront::ParallelFor(blocks, blocks < 2 ? 1 : threads, [&](size_t block) {
    for (size_t k = block * kBlock; k < std::min(result.size(), (block + 1) * kBlock); ++k) {
      TimeSamples<Matrix4d>& samples = result[k];
      samples.reserve(order.size());
      for (size_t t = 0; t < order.size(); ++t)
        samples.push_back({order[t], Multiply(primAt[t], MatrixAt([k](const auto& sample) { return sample.value[k]; },
                                                                  instances.transforms, order[t]))});
    }
  });
  return result;
}

}  // namespace delegate
