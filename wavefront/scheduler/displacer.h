// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Runs displacement kernels over meshes, in the commit, before their BVHs are built. A kernel sees one mesh at a time
// through the bindings of all kernels, filled with buffers of its own.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "wavefront/base/diagnostics.h"
#include "wavefront/scene.h"
#include "wavefront/scene/texture_store.h"
#include "wavefront/vulkan/command_stream.h"
#include "wavefront/vulkan/descriptors.h"
#include "wavefront/vulkan/pipeline.h"

namespace wavefront {

// One thread at a time; no submitted work may run.
class Displacer {
 public:
  // `layout`: of all kernels (KernelRegistry::layout). All must outlive the displacer.
  Displacer(vulkan::Device& device, const vulkan::PipelineLayout& layout, TextureStore& textures)
      : device_(device), layout_(layout), textures_(textures) {}

  // Moves the points by `mesh.displacements`, makes the normals anew and forgets the displacements: the mesh is then as
  // any other. The textures of the commit must be on the device. Waits for the device: once per mesh and material.
  Status Displace(MeshData& mesh, const DiagnosticSink& sink);

  // What the kernels cost so far, by key; `seconds` from submit to result, the first dispatch among them (where
  // lavapipe compiles).
  struct Times {
    double createSeconds = 0, firstDispatchSeconds = 0, seconds = 0;
    uint64_t dispatches = 0, corners = 0, spirvBytes = 0;
  };
  const std::map<std::string, Times>& times() const { return times_; }

 private:
  struct Job;
  Result<const vulkan::ComputePipeline*> Pipeline(const DisplacementData& displacement);
  Status Prepare(Job& job);
  Status Run(Job& job, std::size_t slot, std::vector<Float3>& offsets);
  Status Allocate(std::unique_ptr<vulkan::Buffer>& buffer, std::span<const std::byte> data, const char* name);

  vulkan::Device& device_;
  const vulkan::PipelineLayout& layout_;
  TextureStore& textures_;
  std::unique_ptr<vulkan::CommandStream> stream_;
  std::map<std::string, std::unique_ptr<vulkan::ComputePipeline>> pipelines_;  // by kernel key
  std::map<std::string, Times> times_;
};

}  // namespace wavefront
