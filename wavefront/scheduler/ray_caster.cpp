// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/ray_caster.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "wavefront/scene/bvh/bvh.h"
#include "wavefront/scheduler/kernel_spirv.h"
#include "wavefront/shared/scene_layout.h"
#include "wavefront/vulkan/command_stream.h"

namespace wavefront {
namespace {

constexpr uint32_t kGroup = 64;  // local_size_x of cast_rays.comp
enum CasterBinding : uint32_t { kNodes, kWords, kTriangles, kInstances, kRays, kHits };

Result<std::unique_ptr<vulkan::Buffer>> Upload(vulkan::Device& device, std::span<const std::byte> data, const char* name) {
  auto made = vulkan::Buffer::Create(
      device, {std::max<uint64_t>(data.size(), 16), vulkan::MemoryKind::Geometry, vulkan::MemoryLocation::DeviceLocal, name});
  if (!made) return made;
  if (Status s = made.value()->Upload(0, data); !s) return s.error();
  return made;
}

// The mesh where it is: one instance without a transform.
std::vector<uint32_t> InstanceWords(uint32_t nodeBase) {
  std::vector<uint32_t> words(4 * layout::kInstanceTexels, 0u);
  const float one = 1;
  for (const uint32_t diagonal : {0u, 5u, 10u, 16u, 21u, 26u}) std::memcpy(&words[diagonal], &one, sizeof one);
  words[12] = nodeBase;
  words[14] = layout::kKindMesh | layout::kInstanceOpaque;
  words[15] = 1;
  return words;
}

}  // namespace

struct RayCaster::Parts {
  std::unique_ptr<vulkan::Device> device;
  std::unique_ptr<vulkan::Buffer> nodes, triangles, instances, rays, hits;
  std::unique_ptr<vulkan::PipelineLayout> layout;
  std::unique_ptr<vulkan::ComputePipeline> pipeline, counter;  // counter: made when it is asked for
  std::unique_ptr<vulkan::DescriptorSet> set;
  std::vector<uint32_t> meshTriangles;  // by record
  uint32_t rayCount = 0;
  std::unique_ptr<vulkan::CommandStream> stream;  // last: it waits for its work before what the work uses goes

  Status Build(std::span<const Float3> positions, std::span<const UInt3> meshIndices) {
    const bvh::MeshBvh mesh = bvh::BuildMeshBvh(positions, meshIndices, {});
    bvh::Rows3x4 rows{};
    rows[0].x = rows[1].y = rows[2].z = 1;
    const std::array<Bounds3, 1> bounds = {bvh::InstanceBounds(mesh.bounds, rows, rows)};
    std::vector<bvh::BvhNode4> all = bvh::BuildInstanceBvh(bounds).nodes;
    const std::vector<uint32_t> words = InstanceWords(static_cast<uint32_t>(all.size()));
    all.insert(all.end(), mesh.nodes.begin(), mesh.nodes.end());
    for (const bvh::TriangleRecord& t : mesh.triangles) meshTriangles.push_back(t.meshTriangle);
    const auto fill = [&](std::unique_ptr<vulkan::Buffer>& buffer, std::span<const std::byte> data, const char* name) {
      auto made = Upload(*device, data, name);
      if (made) buffer = std::move(made).value();
      return made ? Status{} : Status{made.error()};
    };
    if (Status s = fill(nodes, std::as_bytes(std::span(all)), "BVH nodes"); !s) return s;
    if (Status s = fill(triangles, std::as_bytes(std::span(mesh.triangles)), "triangle records"); !s) return s;
    if (Status s = fill(instances, std::as_bytes(std::span(words)), "instance records"); !s) return s;
    return MakeKernel();
  }

  Status MakePipeline(const char* kernel, std::unique_ptr<vulkan::ComputePipeline>& pipelineOf) {
    constexpr uint32_t kLightShapesConstant = 1000;  // lib/features.glsl: a mesh has none
    auto made = vulkan::ComputePipeline::Create(*device, *layout, {KernelSpirv(kernel), "main", {{kLightShapesConstant, 0}}, kernel});
    if (!made) return made.error();
    pipelineOf = std::move(made).value();
    return {};
  }

  // The seconds on the device.
  Result<double> Run(const vulkan::ComputePipeline& kernel, uint32_t times) {
    if (rayCount == 0) return 0.0;
    if (auto free = stream->Wait(stream->nextFreeAt()); !free) return free.error();
    if (Status s = stream->Begin(); !s) return s.error();
    stream->BindSet(*set);
    stream->BindPipeline(kernel);
    stream->PushConstants(std::as_bytes(std::span(&rayCount, 1)));
    stream->Timestamp();
    for (uint32_t i = 0; i < times; ++i) {
      stream->Dispatch((rayCount + kGroup - 1) / kGroup);
      stream->Barrier();
    }
    stream->Timestamp();
    auto value = stream->Submit();
    if (!value) return value.error();
    if (auto done = stream->Wait(value.value()); !done) return done.error();
    std::array<double, 2> nanoseconds{};
    auto read = stream->ReadTimestamps(value.value(), nanoseconds);
    if (!read) return read.error();
    return (nanoseconds[1] - nanoseconds[0]) * 1e-9;
  }

  Status MakeKernel() {
    using vulkan::DescriptorKind, vulkan::Format;
    const auto texels = [](uint32_t number, Format format) {
      return vulkan::Binding{number, vulkan::IsUint(format) ? DescriptorKind::TexelBufferUint : DescriptorKind::TexelBufferFloat, 1, format};
    };
    auto madeLayout = vulkan::PipelineLayout::Create(
        *device,
        {texels(kNodes, Format::Rgba32Uint), texels(kWords, Format::R32Uint), texels(kTriangles, Format::Rgba32Float),
         texels(kInstances, Format::Rgba32Uint), texels(kRays, Format::Rgba32Float), {kHits, DescriptorKind::StorageBuffer}},
        "ray caster");
    if (!madeLayout) return madeLayout.error();
    layout = std::move(madeLayout).value();
    if (Status s = MakePipeline("cast_rays", pipeline); !s) return s;
    auto madeStream = vulkan::CommandStream::Create(*device);
    if (!madeStream) return madeStream.error();
    stream = std::move(madeStream).value();
    return {};
  }

  Status Bind() {
    auto made = vulkan::DescriptorSet::Create(*device, *layout);
    if (!made) return made.error();
    set = std::move(made).value();
    struct Row { uint32_t number; vulkan::Buffer* buffer; };
    for (const Row& row : {Row{kNodes, nodes.get()}, {kWords, nodes.get()}, {kTriangles, triangles.get()}, {kInstances, instances.get()}, {kRays, rays.get()}}) {
      if (Status s = set->WriteTexels(row.number, *row.buffer); !s) return s;
    }
    return set->Write(kHits, *hits);
  }
};

RayCaster::RayCaster(std::unique_ptr<Parts> parts) : parts_(std::move(parts)) {}
RayCaster::~RayCaster() = default;

Result<std::unique_ptr<RayCaster>> RayCaster::Create(const std::string& selector, std::span<const Float3> positions,
                                                     std::span<const UInt3> triangles) {
  vulkan::DeviceOptions options;
  options.selector = selector;
  auto device = vulkan::Device::Create(options);
  if (!device) return device.error();
  auto parts = std::make_unique<Parts>();
  parts->device = std::move(device).value();
  if (Status s = parts->Build(positions, triangles); !s) return s.error();
  return std::unique_ptr<RayCaster>(new RayCaster(std::move(parts)));
}

Status RayCaster::SetRays(std::span<const CasterRay> rays) {
  static_assert(sizeof(CasterRay) == 32);
  Parts& p = *parts_;
  auto made = Upload(*p.device, std::as_bytes(rays), "rays");
  if (!made) return made.error();
  const std::vector<std::byte> empty(rays.size() * 8);
  auto madeHits = Upload(*p.device, empty, "hits");
  if (!madeHits) return madeHits.error();
  p.rays = std::move(made).value();
  p.hits = std::move(madeHits).value();
  p.rayCount = static_cast<uint32_t>(rays.size());
  if (Status s = p.Bind(); !s) return s;
  return Cast();
}

Status RayCaster::Cast() {
  auto seconds = parts_->Run(*parts_->pipeline, 1);
  return seconds ? Status{} : Status{seconds.error()};
}

Result<double> RayCaster::CastTimed(uint32_t casts) { return parts_->Run(*parts_->pipeline, casts); }

Result<RayBytes> RayCaster::CountBytes() {
  Parts& p = *parts_;
  RayBytes bytes;
  if (p.rayCount == 0) return bytes;
  if (!p.counter)
    if (Status s = p.MakePipeline("count_ray_fetches", p.counter); !s) return s.error();
  if (auto ran = p.Run(*p.counter, 1); !ran) return ran.error();
  std::vector<std::array<uint32_t, 2>> counts(p.rayCount);
  if (Status s = p.hits->Download(0, std::as_writable_bytes(std::span(counts))); !s) return s.error();
  for (const auto& [nodes, triangles] : counts) {
    bytes.nodes += nodes;
    bytes.triangles += triangles;
  }
  bytes.nodes /= p.rayCount;
  bytes.triangles /= p.rayCount;
  if (Status s = Cast(); !s) return s.error();
  return bytes;
}

Result<std::vector<CasterHit>> RayCaster::Hits() {
  Parts& p = *parts_;
  std::vector<CasterHit> hits(p.rayCount);
  if (hits.empty()) return hits;
  if (Status s = p.hits->Download(0, std::as_writable_bytes(std::span(hits))); !s) return s.error();
  for (CasterHit& hit : hits) {
    if (hit.triangle != kNoTriangle) hit.triangle = p.meshTriangles[hit.triangle];
  }
  return hits;
}

}  // namespace wavefront
