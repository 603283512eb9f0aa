// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// Names of Vulkan handles and the link from every object to its device, without vulkan.h: the rest of
// the core can hold these objects and never sees the API.
#pragma once

#include <cstdint>
#include <memory>

// The same declarations as vulkan_core.h makes on a 64-bit machine (a repeated typedef is legal C++).
static_assert(sizeof(void*) == 8, "hdWavefront needs a 64-bit machine");
typedef struct VkBuffer_T* VkBuffer;
typedef struct VkBufferView_T* VkBufferView;
typedef struct VkCommandBuffer_T* VkCommandBuffer;
typedef struct VkCommandPool_T* VkCommandPool;
typedef struct VkDescriptorPool_T* VkDescriptorPool;
typedef struct VkDescriptorSet_T* VkDescriptorSet;
typedef struct VkDescriptorSetLayout_T* VkDescriptorSetLayout;
typedef struct VkDeviceMemory_T* VkDeviceMemory;
typedef struct VkImage_T* VkImage;
typedef struct VkImageView_T* VkImageView;
typedef struct VkPipeline_T* VkPipeline;
typedef struct VkPipelineLayout_T* VkPipelineLayout;
typedef struct VkQueryPool_T* VkQueryPool;
typedef struct VkSampler_T* VkSampler;
typedef struct VkSemaphore_T* VkSemaphore;

namespace wavefront::vulkan {

struct Context;  // context.h, private to wavefront/vulkan

// Counts its owner as one live object of the device and keeps the VkDevice alive as long as it lives,
// so the order in which a Device and its objects are destroyed does not matter.
class ContextRef {
 public:
  explicit ContextRef(std::shared_ptr<Context> context);
  ~ContextRef();
  ContextRef(const ContextRef&) = delete;
  ContextRef& operator=(const ContextRef&) = delete;
  Context* operator->() const { return context_.get(); }
  Context& operator*() const { return *context_; }
  const std::shared_ptr<Context>& shared() const { return context_; }

 private:
  std::shared_ptr<Context> context_;
};

}  // namespace wavefront::vulkan
