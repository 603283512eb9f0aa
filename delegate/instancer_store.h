// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// All instancers of a delegate and the flattened instances of their prototypes. Internal to delegate.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "delegate/prims/instancer.h"

namespace delegate {

// Sync from any thread; the rest from one.
class InstancerStore {
 public:
  InstancerStore(wavefront::DiagnosticSink sink, unsigned threads);

  void Create(const std::string& path);
  bool Sync(const std::string& path, InstancerUpdate update);  // true: something changed
  void Destroy(const std::string& path);

  // Changes when anything in the chain above a prim changes. 0: no instancer.
  uint64_t Signature(const std::string& path, int32_t prototype);
  // The instances of a prototype; kept until Forget, so that the prims of one prototype share them. A broken chain
  // (an instancer that is missing, or its own ancestor) has none, and a diagnostic.
  std::shared_ptr<const FlatInstances> Flatten(const std::string& path, int32_t prototype);
  void Forget() { flattened_.clear(); }

 private:
  struct Instancer {
    InstancerState state;
    uint64_t version = 0;
  };
  Instancer& FindOrCreate(const std::string& path);

  wavefront::DiagnosticSink sink_;
  unsigned threads_;
  std::mutex mutex_;
  std::map<std::string, std::unique_ptr<Instancer>> instancers_;
  std::map<std::pair<std::string, int32_t>, std::shared_ptr<const FlatInstances>> flattened_;
  uint64_t version_ = 0;
};

// A prim's transforms followed by its instances', at every time where one of them has a sample. Transforms of the
// core's instance k are result[k].
std::vector<TimeSamples<wavefront::Matrix4d>> InstanceTransforms(const TimeSamples<wavefront::Matrix4d>& prim,
                                                                 const FlatInstances& instances, unsigned threads);

}  // namespace delegate
