// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Runs a colour library's GPU shader as a compute kernel over an image.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "wavefront/renderer.h"
#include "wavefront/vulkan/device.h"
#include "wavefront/vulkan/image.h"
#include "wavefront/vulkan/pipeline.h"

namespace wavefront {

// Keeps the pipeline and the tables of the last transform: viewers show one transform again and again, and on lavapipe
// a pipeline takes 0.4 s. Not for several threads at once.
class ColorKernel {
 public:
  // Binding 0: storage buffer of RGBA floats (in place); LUTs at their own bindings. Push constants: pixel count.
  // Workgroup: 64 pixels. Waits for the result.
  Status Run(vulkan::Device& device, std::span<const uint32_t> spirv, const std::vector<Renderer::ColorLut>& luts,
             std::span<float> rgba, uint32_t width, uint32_t height);
  uint64_t builds() const { return builds_; }  // of pipelines and tables

 private:
  struct Built {
    // The key.
    std::vector<uint32_t> spirv;
    std::vector<Renderer::ColorLut> luts;
    // Destroyed in reverse order.
    std::unique_ptr<vulkan::PipelineLayout> layout;
    std::unique_ptr<vulkan::ComputePipeline> pipeline;
    std::unique_ptr<vulkan::Sampler> linear, nearest;
    std::vector<std::unique_ptr<vulkan::Image>> images;
    std::unique_ptr<vulkan::DescriptorSet> set;
  };
  static Result<std::unique_ptr<Built>> Build(vulkan::Device& device, std::span<const uint32_t> spirv,
                                              const std::vector<Renderer::ColorLut>& luts);

  std::unique_ptr<Built> built_;
  uint64_t builds_ = 0;
};

}  // namespace wavefront
