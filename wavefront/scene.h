// SPDX-License-Identifier: Apache-2.0
// Copyright the hdWavefront authors
// What the renderer is told about a scene: typed updates, host-neutral. Ownership: update structs are
// copied or moved in; nothing of the caller is referenced after a call returns.
// Units: scene units as authored; angles in radians; colours scene-linear in the rendering colour space.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "wavefront/types.h"

namespace wavefront {

// One value at one shutter time (seconds or frames as the camera's shutter says). Arrays of length 1 are still.
template <typename T>
struct TimeSample {
  float time = 0;
  T value{};
};

enum class Interpolation : uint8_t { Constant, Uniform, Vertex, FaceVarying, Instance };

// A primvar of a triangulated mesh. `values` holds `components` floats per element.
//   Constant: 1 element. Uniform: one per *face id* (MeshData::faceIds indexes it). Vertex: one per point.
//   FaceVarying: one per triangle corner (3 * triangle + corner), or, if `indices` is not empty,
//   indices[3 * triangle + corner] selects the element. `indices` is used by FaceVarying only.
struct PrimvarData {
  std::string name;
  Interpolation interpolation = Interpolation::Constant;
  uint32_t components = 1;  // 1..4, or 16 (matrix, not readable by materials)
  std::vector<float> values;
  std::vector<uint32_t> indices;
};

// How a material moves the points of a mesh. Kernels and values come from materialgen through the delegate.
struct DisplacementData {
  std::string kernelKey;                                  // equal keys have equal SPIR-V
  std::shared_ptr<const std::vector<uint32_t>> spirv;     // entry "displacement"
  std::vector<std::string> primvars;                      // names that the kernel reads, in slot order
  std::vector<Float4> parameters;                         // as MaterialData::parameters
};

// A triangle mesh as the core renders it; made by delegate/mesh. Right-handed winding is already resolved:
// cross(p1 - p0, p2 - p0) is the outward geometric normal in object space.
struct MeshData {
  std::vector<Float3> positions;        // object space, finite
  std::vector<UInt3> triangles;         // each index < positions.size()
  std::vector<uint32_t> faceIds;        // authored (coarse) face of each triangle; elementId AOV, Uniform primvars
  std::vector<uint16_t> materialSlots;  // per triangle index into InstanceData::materials; empty: all slot 0
  std::vector<PrimvarData> primvars;    // "normals" (3 components, unit, object space) gives smooth shading;
                                        // none: the geometric normal
  bool doubleSided = true;
  std::string path;                     // of the prim, for diagnostics
  // By material slot; null or past the end: not moved. The commit moves the points and makes the normals anew before it
  // builds the BVH (scene/displacement.h says by what rules).
  std::vector<std::shared_ptr<const DisplacementData>> displacements;
};

// Who sees an instance. All bits set = everyone.
enum RayVisibility : uint32_t { kVisibleToCamera = 1, kVisibleToIndirect = 2, kVisibleToShadow = 4, kVisibleToAll = 7 };

using MeshId = uint32_t;
using MaterialId = uint32_t;
using LightId = uint32_t;
using TextureId = uint32_t;
constexpr uint32_t kInvalidId = 0xffffffffu;

// A group of instances of one mesh. Sorted by `path` at commit, so arrival order never shows.
struct InstanceData {
  std::string path;                                 // Rprim path; the sort key, and named in diagnostics
  MeshId mesh = kInvalidId;
  std::vector<MaterialId> materials;                // by material slot; kInvalidId: the default material
  // One entry per instance. Each is an array of time samples (length 1 if still).
  std::vector<std::vector<TimeSample<Matrix4d>>> transforms;  // object to world
  std::vector<int32_t> instanceIds;                 // AOV instanceId per instance; empty: 0 for all (or -1: none)
  std::vector<PrimvarData> instancePrimvars;        // Interpolation::Instance: one element per instance;
                                                    // Constant: shared by all (overrides the mesh's)
  int32_t primId = -1;                              // AOV primId
  uint32_t visibility = kVisibleToAll;
  uint32_t categories = 0;                          // light-linking groups (reserved)
};

enum class LightType : uint32_t { Rect, Disk, Sphere, Cylinder, Distant, Dome };

// UsdLux light in its own space: rect in the xy plane facing -Z; disk likewise; cylinder along X; distant
// shines along -Z; dome pole +Y. `radiance` is what UsdLux calls L before shaping and textures:
// intensity * 2^exposure * colour * blackbody, already divided by sizeFactor where normalised.
enum class LightSampling : uint8_t {
  Auto,   // by the light tree above a handful of lights
  Power,  // by power alone
  Tree,   // by a tree that knows what is near a point and faces it
};

struct LightData {
  std::string path;
  LightType type = LightType::Rect;
  std::vector<TimeSample<Matrix4d>> transforms;  // light to world
  Float3 radiance{1, 1, 1};
  float width = 1, height = 1, radius = 0.5f, length = 1;  // light-space, scene units
  float angle = 0;                                          // distant: full cone angle, radians
  // Shaping (UsdLuxShapingAPI). coneAngle in radians; >= pi means no cone.
  float coneAngle = 3.14159265f * 2, coneSoftness = 0, focus = 0;
  Float3 focusTint{0, 0, 0};
  TextureId texture = kInvalidId;  // rect: multiplies radiance; dome: latlong radiance
  bool visibleToCamera = true;
  bool castsShadows = true;
  uint32_t lightLink = 0, shadowLink = 0, lightGroup = 0;  // reserved groups
};

// The entry points of a material's kernel; each is a pipeline and a bucket of its own.
enum class KernelEntry : uint8_t { Surface, Opacity, Emission };
constexpr std::size_t kKernelEntryCount = 3;

// SPIR-V of one entry, or why there is none.
struct KernelCode {
  std::vector<uint32_t> spirv;
  std::string error;         // with an empty `spirv`
  double milliseconds = 0;   // that making it took
  bool fromCache = false;
};

// Which compiled kernel a material uses, and its values. Kernels come from materialgen through the delegate.
struct MaterialKernelData {
  std::string key;                       // topology key; equal keys share one kernel
  std::vector<uint32_t> surfaceSpirv;    // entry "surface"
  std::vector<uint32_t> opacitySpirv;    // empty: every material with this kernel is opaque
  std::vector<uint32_t> emissionSpirv;   // empty: never emits
  std::vector<std::string> primvars;     // names that the kernel reads, in slot order
  // In place of the SPIR-V above: makes it when an instance wears the kernel first, in a thread of the core's, at most
  // once per entry. It may outlive the call that registered it, and ends with the renderer.
  std::function<KernelCode(KernelEntry)> compile;
  bool hasOpacity = false, hasEmission = false;  // with `compile`: which entries there are
  std::string user;                      // a material that uses it, for diagnostics
};
struct MaterialData {
  std::string path;
  std::string kernelKey;                 // of a kernel registered before
  std::vector<Float4> parameters;        // parameter block, layout by materialgen; texture ids are stored as
                                         // the bits of a uint in one float component. Bodies (kHasTransmission)
                                         // start with absorption, anisotropy; scattering, index of refraction
  uint8_t mediumPriority = 0;            // 0..31: where transmissive bodies overlap, the highest fills the overlap
  bool scatters = false;                 // light scatters below its surfaces or inside of its bodies
  bool lightEnters = false;              // into its bodies: by refraction, or to scatter below their surfaces
};

enum class TexelFormat : uint32_t { Rgba8Unorm, Rgba16Float, Rgba16Unorm, Rgba32Float };
enum class WrapMode : uint32_t { Repeat, Clamp, Mirror, Black };

// A decoded image: level 0 only, row 0 = the *bottom* row (v = 0), RGBA interleaved, rendering colour
// space already applied. The core builds the mip chain.
struct TextureData {
  std::string name;                      // file, for diagnostics and statistics
  uint32_t width = 0, height = 0;
  TexelFormat format = TexelFormat::Rgba8Unorm;
  std::vector<uint8_t> texels;           // width * height * (4, 8 or 16) bytes
};

// Tiles of one image: those of UDIM numbers 1001 to 9999 (1001 + column + 10 * row), each a texture of its own.
struct TextureTile {
  uint32_t udim = 1001;
  TextureId texture = kInvalidId;
};

// Pinhole or thin-lens camera. Camera space: looks along -Z, +Y up.
struct CameraData {
  std::vector<TimeSample<Matrix4d>> transforms;  // camera to world
  bool orthographic = false;
  // Screen window on the plane z = -1 (perspective), or in scene units (orthographic), for the full image.
  float left = -1, right = 1, bottom = -1, top = 1;
  float nearClip = 0, farClip = 3.4e38f;         // distances along -Z; geometry outside is not seen by camera rays
  // Camera space; camera rays see only points with x a + y b + z c + d >= 0 for each (a, b, c, d). At most kMaxClipPlanes.
  static constexpr std::size_t kMaxClipPlanes = 6;
  std::vector<Float4> clipPlanes;
  float lensRadius = 0;                          // scene units; 0: pinhole
  float focusDistance = 0;                       // along -Z, scene units
  float exposureScale = 1;                       // multiplies colour (2^exposure and physical exposure)
  float shutterOpen = 0, shutterClose = 0;
};

}  // namespace wavefront
