# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The C++ side of hdwavefront: the render delegate, as Python sees it.

Arrays: anything with the buffer protocol or DLPack (numpy arrays, pxr.Vt arrays, Gf matrices); they are read in place,
copied once, and never kept. Float arguments take float32, float64, float16 and integers, index arguments int32, int64
and uint32. Matrices are row-vector double 4x4 as Gf.Matrix4d (p' = p * M).
Samples: where an argument says `Samples`, either one array (a still value) or a list of (time, array) pairs.
None means "not dirty": keep what is known. Equal values mark nothing dirty.
Errors: ValueError or TypeError for arguments that make no sense, RuntimeError for the environment (device, memory).
Scene content that cannot be rendered as authored never raises: see `RenderDelegate.diagnostics`.
Threads: every method may be called from any thread; sync_* from several at once for different prims. The GIL is
released while C++ works.
"""

from collections.abc import Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

__version__: str

Array: TypeAlias = Any
Samples: TypeAlias = Any  # Array | Sequence[tuple[float, Array]]

def build_facts() -> dict[str, str]: ...
def measure_copy_bandwidth(device: str = "") -> dict[str, Any]:
    """name, driver and type of the device that is chosen; bytesPerSecond, read and written, of copies in its memory."""

class RayCaster:
    """Given rays through a mesh (points, triangles: n x 3) by the renderer's trees and traversal; for the benchmark."""

    def __init__(self, points: Array, triangles: Array, device: str = "") -> None: ...
    def set_rays(self, origins: Array, directions: Array) -> None:
        """The rays of the next casts. RuntimeError where there is no device."""

    def cast(self) -> None: ...
    def hits(self) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int32]]:
        """Distances, in lengths of the direction, and triangles, -1 where nothing is hit, of the last cast."""

def list_devices() -> list[dict[str, Any]]:
    """name, driver, type ("discrete GPU", "integrated GPU", "virtual GPU", "CPU", "other"), apiVersion, heapBytes,
    subgroupSize, usable, whyNot, details (list of pairs)."""

def render_settings() -> list[dict[str, Any]]:
    """Every render setting: token, type ("int", "float", "bool", "token"), default, minimum, maximum, choices (of a
    token), doc, flag (CLI name)."""

def aovs() -> list[dict[str, Any]]:
    """Every AOV: token, components, format ("float32", "int32"), clear, rule, doc. "primvars:<name>" stands for any."""

def aov_of_render_var(source_name: str, source_type: str = "raw") -> str:
    """The token of the AOV that a RenderVar asks for, by other renderers' names too; "" for none."""

def aov_channels(aov: str) -> list[str]:
    """The names of an AOV's channels in EXR files."""

class Diagnostic:
    """One distinct problem with scene content."""
    @property
    def severity(self) -> str: ...  # "info", "warning", "error"
    @property
    def code(self) -> str: ...
    @property
    def location(self) -> str: ...
    @property
    def message(self) -> str: ...

class TextureRequest:
    """An image that the committed scene needs. `key` names it in set_texture and set_texture_missing."""
    @property
    def key(self) -> int: ...
    @property
    def resolved_path(self) -> str: ...  # empty: the host's resolver found nothing
    @property
    def authored_path(self) -> str: ...
    @property
    def color_space(self) -> str: ...  # "raw", "sRGB", "auto", a colour space's name, or empty: the file decides
    @property
    def is_color(self) -> bool: ...  # False: data, never colour-managed
    @property
    def location(self) -> str: ...  # the node or light that asked first

class Film:
    """Exact sums of a range of samples; ranges merge to the bit in any order."""
    @property
    def width(self) -> int: ...
    @property
    def height(self) -> int: ...
    @property
    def first_sample(self) -> int: ...
    @property
    def samples(self) -> int: ...
    @property
    def sums(self) -> npt.NDArray[np.int64]: ...  # a copy
    @property
    def first(self) -> npt.NDArray[np.uint32]: ...  # a copy
    def merge(self, other: Film) -> Film:
        """ValueError where sizes differ or ranges do not adjoin."""
    def resolve(self, aov: str) -> npt.NDArray[Any]:
        """(height, width, components), row 0 at the top; see RenderDelegate.map."""

class RenderDelegate:
    def __init__(
        self,
        *,
        materialx_libraries: str,
        device: str = "",
        validation: bool = False,
        memory_budget: int = 0,
        threads: int = 0,
        capture_only: bool = False,
    ) -> None:
        """`materialx_libraries`: the folder with MaterialX's stdlib, pbrlib, bxdf. RuntimeError: no device fits.
        `capture_only`: takes no device and renders nothing; the committed scene is there for `write_capture`."""

    # -- Rprims. The first sync of a path creates it.
    def sync_mesh(
        self,
        path: str,
        *,
        topology: Mapping[str, Any] | None = None,
        points: Samples | None = None,  # (n, 3)
        primvars: Sequence[tuple[str, str, Array, Array | None]] | None = None,
        transform: Samples | None = None,
        material: str | None = None,
        subset_materials: Sequence[str] | None = None,
        visible: bool | None = None,
        render_tag: str | None = None,
        double_sided: bool | None = None,
        refine_level: int | None = None,
        instancer: str | None = None,
        prototype: int | None = None,
        prim_id: int | None = None,
    ) -> None:
        """
        topology: keys as members of delegate::MeshTopology, absent ones default: scheme, orientation, faceVertexCounts,
            faceVertexIndices, holeIndices, interpolateBoundary, faceVaryingLinearInterpolation,
            triangleSubdivisionRule, cornerIndices, cornerSharpnesses, creaseIndices, creaseLengths, creaseSharpnesses,
            and subsets: [(path, indices), ...].
        primvars: the whole set, each (name, interpolation, values (n,) or (n, components), indices or None);
            interpolation: constant, uniform, vertex, varying, faceVarying. Authored normals are named "normals".
        transform: object to world; under an instancer, object to prototype root (the root's own transform included,
            except where USD says that the instancer replaces it).
        material: path of a material, "" for none; subset_materials: one per subset of the topology.
        render_tag: "geometry" (purpose default), "proxy", "render" or "guide"; see set_render_pass.
        instancer: path of the instancer that draws this prim ("" = drawn once as it is); prototype: which value in
            the instancer's proto_indices is this prim.
        prim_id: the primId AOV; given in order of creation if absent.
        """

    def sync_implicit(
        self,
        path: str,
        *,
        shape: Mapping[str, Any] | None = None,
        primvars: Sequence[tuple[str, str, Array, Array | None]] | None = None,
        transform: Samples | None = None,
        material: str | None = None,
        visible: bool | None = None,
        render_tag: str | None = None,
        double_sided: bool | None = None,
        instancer: str | None = None,
        prototype: int | None = None,
        prim_id: int | None = None,
    ) -> None:
        """
        shape: {"type": "Sphere" | "Cube" | "Cone" | "Cylinder" | "Capsule" | "Plane", and what the schema has of: size,
            radius, radiusTop, radiusBottom, height, width, length, axis}. primvars: constant ones only.
        """

    def destroy_rprim(self, path: str) -> None: ...

    # -- Instancers: native instances (transforms) or a PointInstancer's raw arrays (positions ...), never both.
    def sync_instancer(
        self,
        path: str,
        *,
        transforms: Samples | None = None,  # (n, 4, 4)
        positions: Samples | None = None,  # (n, 3)
        orientations: Samples | None = None,  # (n, 4): i, j, k, real, as pxr stores quath and quatf
        scales: Samples | None = None,  # (n, 3)
        proto_indices: Array | None = None,  # (n,); empty: every prototype is drawn at every instance
        ids: Array | None = None,  # PointInstancer.ids; empty: 0 .. n-1
        invisible_ids: Array | None = None,
        inactive_ids: Array | None = None,
        transform: Samples | None = None,  # (4, 4): the instancer's own, to world or to the parent's prototype root
        primvars: Sequence[tuple[str, str, Array, Array | None]] | None = None,
        visible: bool | None = None,
        parent: str | None = None,  # the instancer in whose prototype this one stands; "": none
        parent_prototype: int | None = None,
    ) -> None:
        """
        primvars: the whole set; interpolation "instance" (one element an instance, or through indices) or "constant".
            A primvar that the instanced prim has itself wins over the instancer's.
        An object point goes through: prim transform, scale, orientation, position, `transform`, the parent's chain.
        """

    def destroy_instancer(self, path: str) -> None: ...

    # -- Sprims.
    def sync_light(
        self,
        path: str,
        *,
        params: Mapping[str, Any] | None = None,
        transform: Samples | None = None,
        visible: bool | None = None,
        instancer: str | None = None,
        prototype: int | None = None,
    ) -> None:
        """
        params: the whole set: "type" ("RectLight", "DiskLight", "SphereLight", "CylinderLight", "DistantLight",
            "DomeLight") and UsdLux inputs by name without "inputs:", as authored (angles in degrees): intensity,
            exposure, color, enableColorTemperature, colorTemperature, normalize, diffuse, specular, width, height,
            radius, length, angle, treatAsPoint, treatAsLine, texture:file (an asset, see sync_material),
            texture:format, shaping:cone:angle, shaping:cone:softness, shaping:focus, shaping:focusTint,
            shaping:ies:file (only where
            ShapingAPI is applied), shadow:enable, visibleToCamera (bool), poleAxis ("Y" or "Z", domes only).
            Absent ones take UsdLux's fallback. Colours are already in the rendering colour space.
        """

    def sync_camera(
        self, path: str, *, params: Mapping[str, Any] | None = None, transform: Samples | None = None
    ) -> None:
        """
        params: the whole set, UsdGeomCamera's attributes by name: projection, horizontalAperture, verticalAperture,
            horizontalApertureOffset, verticalApertureOffset, focalLength, apertureUnit (scene units of these five:
            0.1), clippingRange, clippingPlanes (n, 4), fStop, focusDistance, exposure, exposure:time, exposure:iso,
            exposure:fStop, exposure:responsivity,
            shutter:open, shutter:close. Absent ones take the schema's fallback.
        """

    def sync_material(self, path: str, contexts: Mapping[str, Mapping[str, Any]]) -> None:
        """
        contexts: "wavefront", "mtlx", "" (universal) -> network, those that exist. A network is
            {"nodes": [{"path": str, "identifier": str, "parameters": {name: value}}, ...],
             "connections": [(upstreamNode, upstreamOutput, downstreamNode, downstreamInput), ...],
             "surface": (nodePath, output), "displacement": (nodePath, output)}; either terminal may be missing.
        value: bool, int, float, str, a sequence of 2, 3, 4, 9 or 16 floats, or an asset
            {"authored": str, "resolved": str, "colorSpace": str}. Types follow Python's: pass float(1) for a float.
        """

    def destroy_sprim(self, path: str) -> None:
        """Removes the light, camera or material of that path."""

    # -- Textures: after all syncs, before commit.
    def set_unconverted_color_spaces(self, names: list[str]) -> None:
        """Colour spaces whose texels set_texture gets as the file has them. Before pending_textures: what is asked for
        in any of these, or as data, is one image."""
    def pending_textures(self) -> list[TextureRequest]:
        """Generates dirty materials and says which images are not loaded yet, or were read coarser than textureMemory
        now asks for; each once a colour space, by path. A file is to be decoded once for all of them."""
    def count_decoded_image(self) -> None:
        """For each file that is decoded, whatever comes of it; counters tell. Any thread."""
    def set_texture(self, key: int, pixels: Array, *, bottom_up: bool = False) -> None:
        """pixels: (height, width, 4), uint8 (0..255), uint16 (0..65535), float16 or float32, in the rendering colour
        space; row 0 at the top."""
    def set_texture_tiles(self, key: int, numbers: Sequence[int], pixels: list[Array]) -> None:
        """For a file pattern with <UDIM> or <UVTILE>: the tiles that there are, by UDIM number (1001 to 9999)."""
    def set_texture_missing(self, key: int, reason: str) -> None:
        """The nodes that asked use their fallback; a diagnostic names them and the file."""

    # -- What is rendered.
    def set_render_pass(
        self,
        *,
        camera: str | None = None,
        width: int | None = None,
        height: int | None = None,
        pixel_aspect_ratio: float | None = None,
        data_window: tuple[float, float, float, float] | None = None,
        window_policy: str | None = None,
        render_tags: Sequence[str] | None = None,
        aovs: Sequence[str] | None = None,
    ) -> None:
        """
        data_window: left, bottom, right, top of what is rendered, in parts of the picture; width and height are its
            pixels. camera: path of a synced camera. window_policy: UsdRender's expandAperture (default), cropAperture,
            adjustApertureWidth, adjustApertureHeight, adjustPixelAspectRatio, or Hydra's fit, crop, matchVertically,
            matchHorizontally, dontConform. ValueError: unknown AOV or policy, size 0 or above 65536 a side.
        aovs: tokens of aovs(), and "primvars:<name>" for up to four primvars.
        """
    def set_setting(self, token: str, value: bool | int | float | str) -> bool:
        """True if the value changed. ValueError: unknown token, wrong type or out of range."""
    def setting(self, token: str) -> bool | int | float | str: ...
    def write_capture(self, path: str, name: str, max_texture_side: int = 0) -> int:
        """Writes the committed scene, called `name`, to a scene file. Textures of a longer side are halved (0: none
        is); returns how many were. RuntimeError where that fails, or where the delegate was not made with
        `capture_only`."""

    # -- Render. commit() stops a running render, makes all edits real and says whether the image restarts.
    def commit(self) -> bool: ...
    def start(self) -> None: ...
    def pause(self) -> None: ...
    def resume(self) -> None: ...
    def stop(self) -> None: ...
    def wait(self, timeout: float = 1e9) -> bool:
        """True: converged or stopped. RuntimeError where the render failed. Ctrl-C is only seen between calls."""
    def progress(self) -> dict[str, Any]:
        """pathsDone, pathsTotal, samplesDone, seconds, running, paused, converged."""
    def is_converged(self) -> bool: ...
    def version(self) -> int: ...
    def map(self, aov: str) -> npt.NDArray[Any]:
        """(height, width, components) float32 or int32, row 0 at the top; what is there now. The caller's own copy."""
    def read_film(self) -> Film: ...
    def stats(self) -> dict[str, Any]:
        """kernels, queues, totals, memory: the members of wavefront::RenderStats, and "counters", and "kernelSources":
        by material kernel its lobes, materials, compile times and cost in the render."""
    def counters(self) -> dict[str, int]:
        """What was done so far: meshesBuilt, meshesUploaded, instancesUploaded, lightsUploaded, camerasUploaded,
        materialsGenerated, materialsUploaded, kernelsCompiled, imagesDecoded, texturesUploaded, commits."""
    def diagnostics(self, since: int = 0) -> list[Diagnostic]:
        """Distinct ones in order of arrival, from index `since` on."""
    def explain_material(self, path: str) -> dict[str, Any]:
        """context, nodes, connections, closureTree, parameters; ValueError for a path that is no material."""
    def camera_matrices(self) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """(worldToCamera, worldToNDC) of the committed camera, row-vector convention, for image metadata."""

    def material_source(self, path: str) -> dict[str, str]:
        """GLSL of a material's kernel by entry: surface, opacity, emission, displacement. Empty: unknown, or not
        generated yet."""

    # -- Colour.
    def run_color_kernel(
        self,
        pixels: Array,
        *,
        glsl: str,
        function: str,
        luts: Sequence[Mapping[str, Any]] = (),
    ) -> npt.NDArray[np.float32]:
        """
        pixels: (height, width, 4) float32. glsl: what OCIO emits for GPU_LANGUAGE_GLSL_VK_4_6; function: its name,
            taking and giving a vec4. luts: {"sampler": name, "dimension": 1 | 2 | 3, "width", "height", "depth",
            "components": 1 | 3, "linear": bool, "values": float array}. Returns the transformed pixels.
        """
