# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Writes a scene as a USD file, and counts what is in it."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import numpy.typing as npt

from .materials import Network
from .shapes import Array, Mesh

NetworkMaker = Callable[[Network], None]


@dataclass(frozen=True)
class Scene:
    """A scene file and what it holds. Triangles and instances are counted as they are seen: a mesh that a hundred
    instances share counts a hundred times."""

    name: str
    path: str
    triangles: int
    instances: int
    materials: int
    width: int
    height: int
    settings: Mapping[str, int] = field(default_factory=dict)  # render settings by token


class Builder:
    """One stage, y up, metres. Everything stands below /World; materials below /World/Looks."""

    def __init__(self, name: str, folder: str) -> None:
        from pxr import Usd, UsdGeom

        self.name = name
        self.path = os.path.join(folder, f"{name}.usdc")
        self.stage = Usd.Stage.CreateInMemory()
        world = UsdGeom.Xform.Define(self.stage, "/World")
        self.stage.SetDefaultPrim(world.GetPrim())
        UsdGeom.SetStageUpAxis(self.stage, UsdGeom.Tokens.y)
        UsdGeom.SetStageMetersPerUnit(self.stage, 1.0)
        self.triangles = self.instances = self.materials = 0
        self._sizes: dict[str, tuple[int, int]] = {}  # prototype -> triangles, meshes

    # -- Materials

    def material(self, name: str, make: NetworkMaker) -> str:
        """Path of a material whose network `make` fills."""
        from pxr import UsdShade

        path = f"/World/Looks/{name}"
        make(Network(UsdShade.Material.Define(self.stage, path)))
        self.materials += 1
        return path

    def _bind(self, prim: Any, material: str) -> None:
        from pxr import UsdShade

        UsdShade.MaterialBindingAPI.Apply(prim).Bind(UsdShade.Material.Get(self.stage, material))

    # -- Geometry

    def mesh(self, path: str, mesh: Mesh, material: str) -> int:
        """At /World/<path>. Gives its number of triangles."""
        count = self._write_mesh(f"/World/{path}", mesh, material)
        self.triangles += count
        self.instances += 1
        return count

    def _write_mesh(self, path: str, mesh: Mesh, material: str) -> int:
        from pxr import Gf, UsdGeom, Vt

        prim = UsdGeom.Mesh.Define(self.stage, path)
        points = mesh.points.astype(np.float32)
        prim.CreatePointsAttr(Vt.Vec3fArray.FromNumpy(points))
        prim.CreateFaceVertexCountsAttr(Vt.IntArray.FromNumpy(np.full(mesh.size, 3, np.int32)))
        prim.CreateFaceVertexIndicesAttr(Vt.IntArray.FromNumpy(mesh.triangles.astype(np.int32).ravel()))
        prim.CreateSubdivisionSchemeAttr(UsdGeom.Tokens.none)
        low, high = points.min(0), points.max(0)
        prim.CreateExtentAttr([Gf.Vec3f(*map(float, low)), Gf.Vec3f(*map(float, high))])
        if mesh.normals is not None:
            prim.CreateNormalsAttr(Vt.Vec3fArray.FromNumpy(mesh.normals.astype(np.float32)))
            prim.SetNormalsInterpolation(UsdGeom.Tokens.vertex)
        self._bind(prim.GetPrim(), material)
        return mesh.size

    def prototype(self, name: str, parts: Sequence[tuple[Mesh, str]]) -> str:
        """Meshes with their materials, to be placed by `place`. They stand below a class, which draws nothing."""
        path = f"/World/Prototypes/{name}"
        self.stage.CreateClassPrim("/World/Prototypes")
        from pxr import UsdGeom

        UsdGeom.Xform.Define(self.stage, path)
        sizes = [self._write_mesh(f"{path}/p{i}", mesh, material) for i, (mesh, material) in enumerate(parts)]
        self._sizes[path] = (sum(sizes), len(sizes))
        return path

    def triangles_of(self, prototype: str) -> int:
        return self._sizes[prototype][0]

    def place(
        self,
        name: str,
        prototypes: Sequence[str],
        which: npt.NDArray[np.int32],
        positions: Array,
        degrees: Array | None = None,
        scales: Array | None = None,
    ) -> None:
        """A point instancer: instance i is prototypes[which[i]], turned by degrees[i] about y, scaled (n, 3), moved."""
        from pxr import UsdGeom, Vt

        prim = UsdGeom.PointInstancer.Define(self.stage, f"/World/{name}")
        prim.CreatePrototypesRel().SetTargets(list(prototypes))
        prim.CreateProtoIndicesAttr(Vt.IntArray.FromNumpy(np.asarray(which, np.int32)))
        prim.CreatePositionsAttr(Vt.Vec3fArray.FromNumpy(np.asarray(positions, np.float32)))
        if degrees is not None:
            half = np.radians(np.asarray(degrees, float)) / 2
            turns = np.zeros((len(half), 4), np.float16)
            turns[:, 1], turns[:, 3] = np.sin(half), np.cos(half)
            prim.CreateOrientationsAttr(Vt.QuathArray.FromNumpy(turns))
        if scales is not None:
            prim.CreateScalesAttr(Vt.Vec3fArray.FromNumpy(np.asarray(scales, np.float32)))
        for index, prototype in enumerate(prototypes):
            count = int(np.count_nonzero(np.asarray(which) == index))
            triangles, meshes = self._sizes[prototype]
            self.triangles += count * triangles
            self.instances += count * meshes

    # -- Light and camera

    def dome(self, intensity: float, color: Sequence[float] = (1, 1, 1)) -> None:
        from pxr import Gf, UsdLux

        light = UsdLux.DomeLight.Define(self.stage, "/World/Sky")
        light.CreateIntensityAttr(intensity)
        light.CreateColorAttr(Gf.Vec3f(*color))

    def sun(self, intensity: float, angle: float, turn: Sequence[float], color: Sequence[float] = (1, 1, 1)) -> None:
        from pxr import Gf, UsdGeom, UsdLux

        light = UsdLux.DistantLight.Define(self.stage, "/World/Sun")
        light.CreateIntensityAttr(intensity)  # of the light that falls, whatever the angle
        light.CreateNormalizeAttr(True)
        light.CreateAngleAttr(angle)
        light.CreateColorAttr(Gf.Vec3f(*color))
        UsdGeom.Xformable(light).AddRotateXYZOp().Set(Gf.Vec3f(*turn))

    def rect_light(
        self,
        name: str,
        size: tuple[float, float],
        position: Sequence[float],
        target: Sequence[float],
        intensity: float,
        color: Sequence[float] = (1, 1, 1),
    ) -> None:
        from pxr import Gf, UsdGeom, UsdLux

        light = UsdLux.RectLight.Define(self.stage, f"/World/Lights/{name}")
        light.CreateWidthAttr(size[0])
        light.CreateHeightAttr(size[1])
        light.CreateIntensityAttr(intensity)
        light.CreateColorAttr(Gf.Vec3f(*color))
        UsdGeom.Xformable(light).AddTransformOp().Set(_look_at(position, target))

    def sphere_light(self, name: str, radius: float, position: Sequence[float], intensity: float) -> None:
        from pxr import Gf, UsdGeom, UsdLux

        light = UsdLux.SphereLight.Define(self.stage, f"/World/Lights/{name}")
        light.CreateRadiusAttr(radius)
        light.CreateIntensityAttr(intensity)
        UsdGeom.Xformable(light).AddTranslateOp().Set(Gf.Vec3d(*map(float, position)))

    def camera(self, position: Sequence[float], target: Sequence[float], focal_length: float) -> None:
        """24 mm wide film of 16:9."""
        from pxr import Gf, UsdGeom

        camera = UsdGeom.Camera.Define(self.stage, "/World/main_cam")
        camera.CreateFocalLengthAttr(focal_length)
        camera.CreateHorizontalApertureAttr(24.0)
        camera.CreateVerticalApertureAttr(13.5)
        camera.CreateClippingRangeAttr(Gf.Vec2f(0.01, 10000))
        UsdGeom.Xformable(camera).AddTransformOp().Set(_look_at(position, target))

    def finish(self, width: int = 640, height: int = 360, **settings: int) -> Scene:
        """Writes the file; size and settings stand in it too, for those who open it without this Scene."""
        self._write_render_settings(width, height, settings)
        layer = self.stage.GetRootLayer()
        if not layer.Export(self.path):
            raise OSError(f"the scene {self.path} cannot be written")
        return Scene(self.name, self.path, self.triangles, self.instances, self.materials, width, height, settings)

    def _write_render_settings(self, width: int, height: int, settings: Mapping[str, int]) -> None:
        from pxr import Gf, Sdf, UsdRender

        prim = UsdRender.Settings.Define(self.stage, "/Render/Settings")
        prim.CreateResolutionAttr(Gf.Vec2i(width, height))
        prim.CreateCameraRel().SetTargets(["/World/main_cam"])
        for token, value in settings.items():
            prim.GetPrim().CreateAttribute(f"wavefront:{token}", Sdf.ValueTypeNames.Int).Set(value)
        self.stage.SetMetadata("renderSettingsPrimPath", str(prim.GetPath()))


def _look_at(position: Sequence[float], target: Sequence[float]) -> Any:
    """A transform whose -z looks at the target, y up."""
    from pxr import Gf

    eye, aim = Gf.Vec3d(*map(float, position)), Gf.Vec3d(*map(float, target))
    up = Gf.Vec3d(0, 1, 0) if abs(Gf.Dot((aim - eye).GetNormalized(), Gf.Vec3d(0, 1, 0))) < 0.999 else Gf.Vec3d(0, 0, 1)
    return Gf.Matrix4d().SetLookAt(eye, aim, up).GetInverse()
