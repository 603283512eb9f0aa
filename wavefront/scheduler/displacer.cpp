// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
#include "wavefront/scheduler/displacer.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <set>

#include "wavefront/scene/displacement.h"
#include "wavefront/scene/geometry_store.h"
#include "wavefront/shared/scene_layout.h"

namespace wavefront {
namespace {

constexpr uint32_t kGroupSize = 64;           // local_size_x of material/displacement_head.glsl
constexpr uint32_t kMaxGroups = 65535;        // in x
constexpr uint64_t kSliceTriangles = 1 << 20;  // 36 MiB of offsets: inside of any storage binding

const DisplacementData* DisplacementOf(const MeshData& mesh, std::size_t slot) {
  return slot < mesh.displacements.size() ? mesh.displacements[slot].get() : nullptr;
}
std::size_t SlotOf(const MeshData& mesh, std::size_t triangle) {
  return mesh.materialSlots.empty() ? 0 : mesh.materialSlots[triangle];
}

}  // namespace

// What the kernels read of one mesh.
struct Displacer::Job {
  const MeshData& mesh;
  std::vector<Float3> pointNormals;
  std::vector<uint32_t> indices;                          // index stream
  std::vector<float> values;                              // primvar stream
  uint32_t positionBase = 0;
  std::map<std::string, PrimvarDescriptor> primvars;
  std::vector<std::vector<uint32_t>> triangles{};         // by slot
  std::vector<uint32_t> listBase{};                       // by slot, in the index stream
  std::vector<uint32_t> bindingTexel{};                   // by slot
  std::vector<uint32_t> bindings{};
  std::vector<Float4> parameters{};
  std::unique_ptr<vulkan::Buffer> instanceBuffer{}, meshBuffer{}, indexBuffer{}, valueBuffer{}, bindingBuffer{},
      parameterBuffer{}, output{};
  std::unique_ptr<vulkan::DescriptorSet> set{};

  void Lay();
  void LayPrimvars();
  void LayBindings();
};

void Displacer::Job::LayPrimvars() {
  std::set<std::string> wanted;
  for (const auto& displacement : mesh.displacements)
    if (displacement) wanted.insert(displacement->primvars.begin(), displacement->primvars.end());
  for (const PrimvarData& p : mesh.primvars) {
    if (p.components > 4 || p.values.empty() || wanted.count(p.name) == 0) continue;
    PrimvarDescriptor& d = primvars[p.name];
    d = {static_cast<uint32_t>(values.size()), layout::kNoStream,
         static_cast<uint32_t>(p.interpolation) | p.components << 8, 0};
    values.insert(values.end(), p.values.begin(), p.values.end());
    if (p.indices.empty()) continue;
    d.indexBase = static_cast<uint32_t>(indices.size());
    indices.insert(indices.end(), p.indices.begin(), p.indices.end());
  }
}

void Displacer::Job::LayBindings() {
  for (std::size_t slot = 0; slot < mesh.displacements.size(); ++slot) {
    listBase.push_back(static_cast<uint32_t>(indices.size()));
    indices.insert(indices.end(), triangles[slot].begin(), triangles[slot].end());
    bindingTexel.push_back(static_cast<uint32_t>(bindings.size() / 4));
    const DisplacementData* displacement = DisplacementOf(mesh, slot);
    if (displacement == nullptr) continue;
    const auto count = static_cast<uint32_t>(displacement->primvars.size());
    bindings.insert(bindings.end(), {layout::kNoBucket, layout::kNoBucket, layout::kNoBucket,
                                     static_cast<uint32_t>(parameters.size()), 0, 0, count, 0});
    for (const std::string& name : displacement->primvars) {
      const auto found = primvars.find(name);
      const PrimvarDescriptor d = found == primvars.end() ? PrimvarDescriptor() : found->second;
      bindings.insert(bindings.end(), {d.valueBase, d.indexBase, d.packed, d.unused});
    }
    parameters.insert(parameters.end(), displacement->parameters.begin(), displacement->parameters.end());
  }
}

void Displacer::Job::Lay() {
  for (const UInt3& t : mesh.triangles) indices.insert(indices.end(), {t.x, t.y, t.z});
  indices.insert(indices.end(), mesh.faceIds.begin(), mesh.faceIds.end());
  for (const Float3& n : pointNormals) values.insert(values.end(), {n.x, n.y, n.z});
  positionBase = static_cast<uint32_t>(values.size());
  for (const Float3& p : mesh.positions) values.insert(values.end(), {p.x, p.y, p.z});
  LayPrimvars();
  triangles.resize(mesh.displacements.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
    if (DisplacementOf(mesh, SlotOf(mesh, t))) triangles[SlotOf(mesh, t)].push_back(static_cast<uint32_t>(t));
  LayBindings();
}

Result<const vulkan::ComputePipeline*> Displacer::Pipeline(const DisplacementData& displacement) {
  auto& pipeline = pipelines_[displacement.kernelKey];
  if (!pipeline) {
    auto made = vulkan::ComputePipeline::Create(
        device_, layout_, {*displacement.spirv, "main", {}, "displacement:" + displacement.kernelKey});
    if (!made) return made.error();
    pipeline = std::move(made).value();
    times_[displacement.kernelKey].createSeconds = pipeline->creationSeconds();
    times_[displacement.kernelKey].spirvBytes = 4 * displacement.spirv->size();
  }
  return pipeline.get();
}

Status Displacer::Allocate(std::unique_ptr<vulkan::Buffer>& buffer, std::span<const std::byte> data, const char* name) {
  auto made = vulkan::Buffer::Create(
      device_, {data.size(), vulkan::MemoryKind::Geometry, vulkan::MemoryLocation::DeviceLocal, name, true});
  if (!made) return made.error();
  buffer = std::move(made).value();
  return data.empty() ? Status() : buffer->Upload(0, data);
}

Status Displacer::Prepare(Job& job) {
  if (!stream_) {
    auto stream = vulkan::CommandStream::Create(device_, {1, 0, "displacement"});
    if (!stream) return stream.error();
    stream_ = std::move(stream).value();
  }
  auto set = vulkan::DescriptorSet::Create(device_, layout_, "displacement");
  if (!set) return set.error();
  job.set = std::move(set).value();
  // One instance that stands where the mesh does: world space is object space.
  uint32_t instance[4 * layout::kInstanceTexels] = {};
  for (const uint32_t rows : {0u, 16u})
    for (uint32_t i = 0; i < 3; ++i) instance[rows + 5 * i] = std::bit_cast<uint32_t>(1.0f);
  const uint32_t record[4 * layout::kMeshTexels] = {
      0, job.mesh.faceIds.empty() ? layout::kNoStream : static_cast<uint32_t>(3 * job.mesh.triangles.size()),
      static_cast<uint32_t>(job.mesh.triangles.size()), 0,
      0, layout::kNoStream, layout::kInterpVertex | 3u << 8, 0};
  for (Status s : {Allocate(job.instanceBuffer, std::as_bytes(std::span(instance)), "displacement instance"),
                   Allocate(job.meshBuffer, std::as_bytes(std::span(record)), "displacement mesh"),
                   Allocate(job.indexBuffer, std::as_bytes(std::span(job.indices)), "displacement indices"),
                   Allocate(job.valueBuffer, std::as_bytes(std::span(job.values)), "displacement primvars"),
                   Allocate(job.bindingBuffer, std::as_bytes(std::span(job.bindings)), "displacement bindings"),
                   Allocate(job.parameterBuffer, std::as_bytes(std::span(job.parameters)), "displacement parameters")}) {
    if (!s) return s;
  }
  uint64_t most = 0;
  for (const auto& list : job.triangles) most = std::max<uint64_t>(most, list.size());
  auto output = vulkan::Buffer::Create(device_, {36 * std::min(most, kSliceTriangles), vulkan::MemoryKind::Geometry,
                                                 vulkan::MemoryLocation::DeviceLocal, "displacement offsets"});
  if (!output) return output.error();
  job.output = std::move(output).value();
  struct Row {
    uint32_t binding;
    vulkan::Buffer* buffer;
  };
  for (const Row& row : {Row{10, job.instanceBuffer.get()},
                         {11, job.meshBuffer.get()},
                         {12, job.indexBuffer.get()},
                         {13, job.valueBuffer.get()},
                         {14, job.bindingBuffer.get()},
                         {15, job.parameterBuffer.get()},
                         {19, textures_.records.buffer()},
                         {20, textures_.pageTable.buffer()},
                         {21, textures_.pages.buffer()}}) {
    if (row.buffer == nullptr) continue;
    if (Status s = job.set->WriteTexels(row.binding, *row.buffer); !s) return s;
  }
  return job.set->Write(7, *job.output);
}

// All triangles of a slot, a slice at a time.
Status Displacer::Run(Job& job, std::size_t slot, std::vector<Float3>& offsets) {
  const std::vector<uint32_t>& list = job.triangles[slot];
  auto pipeline = Pipeline(*job.mesh.displacements[slot]);
  if (!pipeline) return pipeline.error();
  Times& times = times_[job.mesh.displacements[slot]->kernelKey];
  std::vector<Float3> slice;
  for (uint64_t first = 0; first < list.size(); first += kSliceTriangles) {
    const auto count = static_cast<uint32_t>(std::min<uint64_t>(kSliceTriangles, list.size() - first));
    if (Status s = stream_->Begin(); !s) return s;
    stream_->BindSet(*job.set);
    stream_->BindPipeline(*pipeline.value());
    const uint32_t push[4] = {count, job.listBase[slot] + static_cast<uint32_t>(first), job.bindingTexel[slot],
                              job.positionBase};
    stream_->PushConstants(std::as_bytes(std::span(push)));
    const uint32_t groups = (3 * count + kGroupSize - 1) / kGroupSize;
    stream_->Dispatch(std::min(groups, kMaxGroups), (groups + kMaxGroups - 1) / kMaxGroups);
    const auto start = std::chrono::steady_clock::now();
    auto value = stream_->Submit();
    if (!value) return value.error();
    if (auto done = stream_->Wait(value.value()); !done) return done.error();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (times.dispatches++ == 0) times.firstDispatchSeconds = seconds;
    times.seconds += seconds;
    times.corners += 3 * uint64_t{count};
    slice.resize(3 * std::size_t{count});
    if (Status s = job.output->Download(0, std::as_writable_bytes(std::span(slice))); !s) return s;
    for (std::size_t i = 0; i < count; ++i)
      std::copy_n(slice.begin() + static_cast<std::ptrdiff_t>(3 * i), 3,
                  offsets.begin() + static_cast<std::ptrdiff_t>(3 * std::size_t{list[first + i]}));
  }
  return {};
}

Status Displacer::Displace(MeshData& mesh, const DiagnosticSink& sink) {
  const std::vector<Float3> cornerNormals = CornerNormals(mesh);
  Job job{mesh, PointNormals(mesh, cornerNormals), {}, {}, 0, {}};
  job.Lay();
  if (std::all_of(job.triangles.begin(), job.triangles.end(), [](const auto& list) { return list.empty(); })) {
    mesh.displacements.clear();
    return {};
  }
  if (Status s = Prepare(job); !s) return s;
  std::vector<Float3> offsets(3 * mesh.triangles.size());
  std::vector<uint8_t> moves(mesh.triangles.size(), 0);
  for (std::size_t slot = 0; slot < job.triangles.size(); ++slot) {
    if (job.triangles[slot].empty()) continue;
    for (const uint32_t triangle : job.triangles[slot]) moves[triangle] = 1;
    if (Status s = Run(job, slot, offsets); !s) return s;
  }
  const uint64_t stayed = MovePoints(mesh, offsets, moves);
  if (stayed != 0 && sink)
    sink({Severity::Warning, "displacement-not-finite", mesh.path,
          "The displacement of " + std::to_string(stayed) +
              " points is not a number or too far to be drawn; they stay where they are."});
  RenewNormals(mesh, cornerNormals);
  mesh.displacements.clear();
  return {};
}

}  // namespace wavefront
