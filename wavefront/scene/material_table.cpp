// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scene/material_table.h"

namespace wavefront {

MaterialTable::MaterialTable(vulkan::Device& device)
    : parameters(device, "material parameters", vulkan::MemoryKind::Materials, 16) {}

void MaterialTable::RegisterKernel(MaterialKernelData kernel) {
  std::lock_guard lock(mutex_);
  if (kernels_.count(kernel.key) == 0) stagedKernels_.try_emplace(kernel.key, std::move(kernel));
}
bool MaterialTable::HasKernel(const std::string& key) const {
  std::lock_guard lock(mutex_);
  return kernels_.count(key) != 0 || stagedKernels_.count(key) != 0;
}
void MaterialTable::AdoptKernel(MaterialKernelData kernel) {
  KernelInfo info;
  auto add = [&](KernelEntry entry, std::vector<uint32_t>& spirv, bool exists) {
    if (!exists) return layout::kNoBucket;
    Bucket bucket{kernel.key, entry, {}, kernel.user};
    if (kernel.compile) bucket.code = [compile = kernel.compile, entry] { return compile(entry); };
    else bucket.code = [words = std::move(spirv)] { return KernelCode{words, {}, 0, false}; };
    buckets_.push_back(std::move(bucket));
    return static_cast<uint32_t>(buckets_.size() - 1) + layout::kFirstMaterialBucket;
  };
  const bool lazy = static_cast<bool>(kernel.compile);
  info.surface = add(KernelEntry::Surface, kernel.surfaceSpirv, lazy || !kernel.surfaceSpirv.empty());
  info.opacity = add(KernelEntry::Opacity, kernel.opacitySpirv, lazy ? kernel.hasOpacity : !kernel.opacitySpirv.empty());
  info.emission = add(KernelEntry::Emission, kernel.emissionSpirv, lazy ? kernel.hasEmission : !kernel.emissionSpirv.empty());
  info.primvars = std::move(kernel.primvars);
  kernels_[kernel.key] = std::move(info);
}
MaterialId MaterialTable::Create(MaterialData material) {
  std::lock_guard lock(mutex_);
  staged_[next_] = std::move(material);
  return next_++;
}
void MaterialTable::Set(MaterialId id, MaterialData material) {
  std::lock_guard lock(mutex_);
  staged_[id] = std::move(material);
}
void MaterialTable::Destroy(MaterialId id) {
  std::lock_guard lock(mutex_);
  staged_.erase(id);
  destroyed_.push_back(id);
}
void MaterialTable::SetDefault(MaterialId id) {
  std::lock_guard lock(mutex_);
  defaultChanged_ = defaultChanged_ || default_ != id;
  default_ = id;
}

Status MaterialTable::Commit(bool* valuesChanged, bool* bindingsChanged) {
  std::lock_guard lock(mutex_);
  for (auto& [key, kernel] : stagedKernels_) AdoptKernel(std::move(kernel));
  stagedKernels_.clear();
  *valuesChanged = !staged_.empty();
  *bindingsChanged = !destroyed_.empty() || defaultChanged_;
  defaultChanged_ = false;
  for (MaterialId id : destroyed_) {
    auto it = materials_.find(id);
    if (it == materials_.end()) continue;
    parameters.Free(it->second.parameters);
    materials_.erase(it);
  }
  destroyed_.clear();
  for (auto& [id, data] : staged_) {
    MaterialInfo& info = materials_[id];
    const uint32_t texels = static_cast<uint32_t>(data.parameters.size());
    if (info.kernelKey != data.kernelKey || info.parameters.count != texels) {
      parameters.Free(info.parameters);
      info.parameters = parameters.Allocate(texels);
      *bindingsChanged = true;
    }
    if (info.mediumPriority != data.mediumPriority || info.scatters != data.scatters || info.lightEnters != data.lightEnters)
      *bindingsChanged = true;
    info.mediumPriority = data.mediumPriority;
    info.scatters = data.scatters;
    info.lightEnters = data.lightEnters;
    info.kernelKey = data.kernelKey;
    info.path = data.path;
  }
  if (Status s = parameters.Fit(); !s) return s;
  for (auto& [id, data] : staged_) {
    if (Status s = parameters.Write<Float4>(materials_[id].parameters, data.parameters); !s) return s;
  }
  staged_.clear();
  return {};
}

const MaterialInfo* MaterialTable::Find(MaterialId id) const {
  auto it = materials_.find(id);
  return it == materials_.end() ? nullptr : &it->second;
}
const KernelInfo* MaterialTable::Kernel(const std::string& key) const {
  auto it = kernels_.find(key);
  return it == kernels_.end() ? nullptr : &it->second;
}

}  // namespace wavefront
