# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""A stage as other renderers take it: triangle meshes, placements, plain materials, lights, one camera.

What is translated: meshes with their normals, point instancers and transforms; of a material the numbers of its
standard_surface or UsdPreviewSurface, where a pattern drives a number the mean of what it mixes; networks of single
lobes by their colour, roughness and kind. Patterns, flakes, sheen of cloth and layers of MaterialX's own have no
equal there. Dome, distant, rect and sphere lights keep their radiance, and so do meshes that shine.
"""

from __future__ import annotations

import json
import math
import os
from typing import Any

import numpy as np
import numpy.typing as npt

Matrix = npt.NDArray[np.float64]  # 4 x 4, of column vectors

_PLAIN: dict[str, Any] = {
    "color": [0.8, 0.8, 0.8],
    "roughness": 0.5,
    "metallic": 0.0,
    "specular": 0.5,
    "coat": 0.0,
    "coatRoughness": 0.1,
    "transmission": 0.0,
    "emission": [0.0, 0.0, 0.0],
}


def _matrix(prim: Any) -> Matrix:
    from pxr import Usd, UsdGeom

    return np.array(UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())).T


def _mean(values: list[Any]) -> Any:
    arrays = [np.asarray(v, float) for v in values]
    size = max(a.size for a in arrays)
    mean = np.mean([np.broadcast_to(a, (size,)) if size > 1 else a for a in arrays], axis=0)
    return mean.tolist() if size > 1 else float(mean)


def _value(shader: Any, name: str, default: Any) -> Any:
    """A constant of an input; the mean of the ends of what a mix drives it with."""
    from pxr import UsdShade

    found = shader.GetInput(name)
    if not found:
        return default
    sources, _ = found.GetConnectedSources()
    if not sources:
        value = found.Get()
        return default if value is None else (list(value) if hasattr(value, "__len__") else value)
    node = UsdShade.Shader(sources[0].source.GetPrim())
    ends = [_value(node, n, None) for n in ("bg", "fg", "in1", "in2", "low", "high", "in", "color")]
    numbers = [e for e in ends if e is not None]
    kind = str(node.GetIdAttr().Get())
    if "multiply" in kind and len(numbers) == 2:
        return (np.asarray(numbers[0]) * np.asarray(numbers[1])).tolist()
    return _mean(numbers) if numbers else 0.5


def _rgb(shader: Any, name: str, default: float) -> list[float]:
    values: list[float] = np.broadcast_to(np.asarray(_value(shader, name, default), float), (3,)).tolist()
    return values


def _material(material: Any) -> dict[str, Any]:
    from pxr import UsdShade

    plain = dict(_PLAIN)
    shaders = {c.GetName(): UsdShade.Shader(c) for c in material.GetPrim().GetChildren()}
    for shader in shaders.values():
        kind = str(shader.GetIdAttr().Get())
        if kind == "ND_standard_surface_surfaceshader":
            color = np.asarray(_value(shader, "base_color", [0.8] * 3), float) * float(_value(shader, "base", 1.0))
            return {
                **plain,
                "color": np.broadcast_to(color, (3,)).tolist(),
                "roughness": float(_value(shader, "specular_roughness", 0.2)),
                "metallic": float(_value(shader, "metalness", 0.0)),
                "specular": 0.5 * float(_value(shader, "specular", 1.0)),
                "coat": float(_value(shader, "coat", 0.0)),
                "coatRoughness": float(_value(shader, "coat_roughness", 0.1)),
                "transmission": float(_value(shader, "transmission", 0.0)),
            }
        if kind == "UsdPreviewSurface":
            return {
                **plain,
                "color": _rgb(shader, "diffuseColor", 0.18),
                "roughness": float(_value(shader, "roughness", 0.5)),
                "metallic": float(_value(shader, "metallic", 0.0)),
                "coat": float(_value(shader, "clearcoat", 0.0)),
                "coatRoughness": float(_value(shader, "clearcoatRoughness", 0.01)),
                "emission": _rgb(shader, "emissiveColor", 0.0),
            }
        if "diffuse_bsdf" in kind:
            plain["color"] = _rgb(shader, "color", 0.5)
            plain["specular"] = 0.0
        if kind in ("ND_generalized_schlick_bsdf", "ND_conductor_bsdf"):
            plain["metallic"] = 0.4  # flakes over the base
        if kind == "ND_dielectric_bsdf":
            plain["coat"] = 1.0
            plain["coatRoughness"] = float(np.mean(_value(shader, "roughness", 0.05)))
    return plain


def _mesh(prim: Any) -> tuple[npt.NDArray[np.float32], npt.NDArray[np.int32], npt.NDArray[np.float32] | None]:
    from pxr import UsdGeom

    mesh = UsdGeom.Mesh(prim)
    counts = np.asarray(mesh.GetFaceVertexCountsAttr().Get())
    indices = np.asarray(mesh.GetFaceVertexIndicesAttr().Get())
    points = np.asarray(mesh.GetPointsAttr().Get(), np.float32)
    starts = np.cumsum(counts) - counts
    fans = [
        np.stack([indices[starts[counts > k + 1]], indices[starts[counts > k + 1] + k],
                  indices[starts[counts > k + 1] + k + 1]], 1)
        for k in range(1, int(counts.max()) - 1)
    ]  # fmt: skip
    normals = mesh.GetNormalsAttr().Get()
    smooth = None if normals is None or len(normals) != len(points) else np.asarray(normals, np.float32)
    return points, np.concatenate(fans).astype(np.int32), smooth


def _light(prim: Any) -> dict[str, Any] | None:
    from pxr import UsdLux

    if not prim.HasAPI(UsdLux.LightAPI):
        return None
    api = UsdLux.LightAPI(prim)
    intensity = api.GetIntensityAttr().Get() * 2.0 ** api.GetExposureAttr().Get()
    radiance = (np.asarray(api.GetColorAttr().Get(), float) * intensity).tolist()
    light: dict[str, Any] = {"radiance": radiance, "matrix": _matrix(prim).tolist()}
    if prim.IsA(UsdLux.DomeLight):
        return {**light, "kind": "dome"}
    if prim.IsA(UsdLux.RectLight):
        rect = UsdLux.RectLight(prim)
        return {**light, "kind": "rect", "width": rect.GetWidthAttr().Get(), "height": rect.GetHeightAttr().Get()}
    if prim.IsA(UsdLux.SphereLight):
        return {**light, "kind": "sphere", "radius": UsdLux.SphereLight(prim).GetRadiusAttr().Get()}
    if prim.IsA(UsdLux.DistantLight):
        angle = UsdLux.DistantLight(prim).GetAngleAttr().Get()
        if not api.GetNormalizeAttr().Get():  # radiance over the disc that is seen
            half = math.radians(angle) / 2
            light["radiance"] = [r * math.pi * math.sin(half) ** 2 for r in radiance]
        return {**light, "kind": "distant", "angle": angle}
    return None


def _placements(prim: Any) -> list[tuple[str, list[Matrix]]]:
    """Of a point instancer: prototypes and where they stand."""
    from pxr import Usd, UsdGeom

    instancer = UsdGeom.PointInstancer(prim)
    matrices = np.array(
        instancer.ComputeInstanceTransformsAtTime(
            Usd.TimeCode.Default(), Usd.TimeCode.Default(), UsdGeom.PointInstancer.ExcludeProtoXform
        )
    ).transpose(0, 2, 1)
    which = np.asarray(instancer.GetProtoIndicesAttr().Get())
    world = _matrix(prim)
    targets = instancer.GetPrototypesRel().GetTargets()
    return [(str(path), [world @ m for m in matrices[which == i]]) for i, path in enumerate(targets)]


def write(stage_path: str, folder: str) -> str:
    """Writes scene.json and meshes.npz into the folder; gives the path of the former."""
    from pxr import Gf, Usd, UsdGeom, UsdShade

    stage = Usd.Stage.Open(stage_path)
    arrays: dict[str, Any] = {}
    meshes: list[dict[str, Any]] = []
    materials: dict[str, dict[str, Any]] = {}
    groups: dict[str, list[Matrix]] = {}
    for prim in stage.Traverse():
        if prim.IsA(UsdGeom.PointInstancer):
            for path, matrices in _placements(prim):
                groups.setdefault(path, []).extend(matrices)
    for prim in stage.TraverseAll():
        if not prim.IsA(UsdGeom.Mesh):
            continue
        group = next((g for g in groups if str(prim.GetPath()).startswith(g + "/")), "")
        if not group and (prim.IsAbstract() or not prim.IsActive()):
            continue
        points, triangles, normals = _mesh(prim)
        number = len(meshes)
        arrays[f"p{number}"], arrays[f"t{number}"] = points, triangles
        if normals is not None:
            arrays[f"n{number}"] = normals
        material = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
        name = str(material.GetPath()) if material else ""
        if name not in materials:
            materials[name] = _material(material) if material else dict(_PLAIN)
        meshes.append(
            {"material": name, "group": group, "matrix": np.eye(4).tolist() if group else _matrix(prim).tolist()}
        )
    camera = next(p for p in stage.Traverse() if p.IsA(UsdGeom.Camera))
    lens = UsdGeom.Camera(camera).GetCamera(Usd.TimeCode.Default())
    lights = [light for p in stage.Traverse() if (light := _light(p)) is not None]
    scene = {
        "meshes": meshes,
        "materials": materials,
        "groups": {name: [m.tolist() for m in matrices] for name, matrices in groups.items()},
        "lights": lights,
        "camera": {
            "matrix": np.array(lens.transform).T.tolist(),
            "horizontalDegrees": lens.GetFieldOfView(Gf.Camera.FOVHorizontal),
        },
    }
    np.savez(os.path.join(folder, "meshes.npz"), **arrays)
    path = os.path.join(folder, "scene.json")
    with open(path, "w", encoding="utf-8") as file:
        json.dump(scene, file)
    return path
