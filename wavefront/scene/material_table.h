// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Kernels by topology key, the buckets they own, and the parameter blocks of materials.
#pragma once

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "wavefront/scene.h"
#include "wavefront/scene/stream.h"
#include "wavefront/shared/counters_layout.h"
#include "wavefront/shared/scene_layout.h"

namespace wavefront {

// One bucket = one pipeline of one kernel.
struct Bucket {
  std::string kernelKey;
  KernelEntry entry;
  std::function<KernelCode()> code;  // thread-safe; to be called once
  std::string user;                  // a material that uses it, for diagnostics
};

struct KernelInfo {
  uint32_t surface = layout::kNoBucket, opacity = layout::kNoBucket, emission = layout::kNoBucket;  // bucket numbers
  std::vector<std::string> primvars;
};

struct MaterialInfo {
  std::string path;
  std::string kernelKey;
  Range parameters;  // in texels
  uint32_t mediumPriority = 0;
  bool scatters = false, lightEnters = false;
};

class MaterialTable {
 public:
  explicit MaterialTable(vulkan::Device& device);

  // Staging; thread-safe, also while Commit runs: what is registered then is part of the next commit.
  void RegisterKernel(MaterialKernelData kernel);
  bool HasKernel(const std::string& key) const;
  MaterialId Create(MaterialData material);
  void Set(MaterialId id, MaterialData material);
  void Destroy(MaterialId id);
  void SetDefault(MaterialId id);

  // Uploads parameter blocks. `valuesChanged`: some block; `bindingsChanged`: a kernel or a block's place.
  Status Commit(bool* valuesChanged, bool* bindingsChanged);

  MaterialId Resolve(MaterialId id) const { return materials_.count(id) != 0 ? id : default_; }
  const MaterialInfo* Find(MaterialId id) const;
  const KernelInfo* Kernel(const std::string& key) const;
  // Bucket b of the counters is buckets()[b - kFirstMaterialBucket].
  const std::vector<Bucket>& buckets() const { return buckets_; }
  uint64_t count() const { return materials_.size(); }

  Stream parameters;

 private:
  mutable std::mutex mutex_;
  std::map<MaterialId, MaterialData> staged_;
  std::vector<MaterialId> destroyed_;
  std::map<MaterialId, MaterialInfo> materials_;
  void AdoptKernel(MaterialKernelData kernel);
  std::map<std::string, MaterialKernelData> stagedKernels_;
  std::map<std::string, KernelInfo> kernels_;  // this and what follows: changed by Commit only
  std::vector<Bucket> buckets_;
  MaterialId next_ = 0, default_ = kInvalidId;
  bool defaultChanged_ = false;
};

}  // namespace wavefront
