# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""UsdGeomCamera: raw attributes at the frame; a free camera that frames the stage; the camera's image aspect."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from ..errors import Diagnostics, HdWavefrontError
from .context import Update, matrix_array

FREE_CAMERA_PATH = "/__hdwavefront_free_camera"
_MAX_COORDINATE = 1e18  # as for the points of meshes

_ATTRIBUTES = (
    "projection",
    "horizontalAperture",
    "verticalAperture",
    "horizontalApertureOffset",
    "verticalApertureOffset",
    "focalLength",
    "clippingRange",
    "fStop",
    "focusDistance",
    "exposure",
    "exposure:time",
    "exposure:iso",
    "exposure:fStop",
    "exposure:responsivity",
    "shutter:open",
    "shutter:close",
)


def _plain(value: Any) -> Any:
    if isinstance(value, Gf.Vec2f):
        return (float(value[0]), float(value[1]))
    return str(value) if isinstance(value, str) else float(value)


def camera_params(camera: UsdGeom.Camera, time: Usd.TimeCode, diagnostics: Diagnostics) -> Update:
    prim = camera.GetPrim()
    params: Update = {}
    for name in _ATTRIBUTES:
        attribute = prim.GetAttribute(name)
        value = attribute.Get(time) if attribute else None
        if value is not None:
            params[name] = _plain(value)
    planes = camera.GetClippingPlanesAttr().Get(time)
    if planes:
        params["clippingPlanes"] = np.array(planes, dtype=np.float32).reshape(-1, 4)
    if params.get("shutter:close", 0.0) > params.get("shutter:open", 0.0):
        diagnostics.info(
            "motion-blur-unsupported",
            prim.GetPath(),
            "motion blur is not rendered yet; all is shown at the frame's time",
        )
    return params


def camera_transform(camera: UsdGeom.Camera, time: Usd.TimeCode) -> np.ndarray:
    return matrix_array(UsdGeom.XformCache(time).GetLocalToWorldTransform(camera.GetPrim()))


def aspect_ratio(params: Update) -> float:
    """The aperture's width to height; 1 where that makes no sense, as usdrecord has it."""
    width, height = params.get("horizontalAperture", 20.955), params.get("verticalAperture", 15.2908)
    ratio = width / height if height else 0.0
    return ratio if math.isfinite(ratio) and ratio > 1e-4 else 1.0


def find_camera(stage: Usd.Stage, name: str) -> UsdGeom.Camera | None:
    """The camera at a path, or the first one of that name."""
    if not Sdf.Path.IsValidPathString(name):
        return None
    path = Sdf.Path(name)
    if not path.IsAbsolutePath() and path.pathElementCount == 1:
        for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()):
            if prim.GetName() == name and prim.IsA(UsdGeom.Camera):
                return UsdGeom.Camera(prim)
        return None
    prim = stage.GetPrimAtPath(path.MakeAbsolutePath(Sdf.Path.absoluteRootPath))
    return UsdGeom.Camera(prim) if prim and prim.IsA(UsdGeom.Camera) else None


def all_cameras(stage: Usd.Stage) -> list[UsdGeom.Camera]:
    return [
        UsdGeom.Camera(prim)
        for prim in Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies())
        if prim.IsA(UsdGeom.Camera)
    ]


def require_camera(stage: Usd.Stage, name: str) -> UsdGeom.Camera:
    camera = find_camera(stage, name)
    if camera is None:
        known = [str(c.GetPath()) for c in all_cameras(stage)]
        hint = (
            f"The stage's cameras: {', '.join(known[:8])}." if known else "The stage has no camera; leave --camera out."
        )
        raise HdWavefrontError(f"There is no camera '{name}' in the stage. {hint}")
    return camera


def _stage_bound(stage: Usd.Stage, time: Usd.TimeCode, purposes: frozenset[str]) -> tuple[Gf.Vec3d, Gf.Vec3d]:
    """Centre and size of what can be framed."""
    cache = UsdGeom.BBoxCache(time, sorted(purposes), True)
    box = cache.ComputeWorldBound(stage.GetPseudoRoot())
    extent, center = box.ComputeAlignedRange(), box.ComputeCentroid()
    if not extent.IsEmpty() and _is_sane(extent):
        return center, extent.GetSize()
    # One broken prim spoils the bound of all: those that make sense are gathered one by one.
    extent = Gf.Range3d()
    prims = iter(Usd.PrimRange.Stage(stage, Usd.TraverseInstanceProxies()))
    for prim in prims:
        if not prim.IsA(UsdGeom.Boundable):
            continue
        prims.PruneChildren()  # a Boundable's bound holds what is below it
        part = cache.ComputeWorldBound(prim).ComputeAlignedRange()
        if not part.IsEmpty() and _is_sane(part):
            extent.UnionWith(part)
    if extent.IsEmpty():
        return Gf.Vec3d(0), Gf.Vec3d(2)
    return extent.GetMidpoint(), extent.GetSize()


def _is_sane(extent: Gf.Range3d) -> bool:
    return all(math.isfinite(x) and abs(x) < _MAX_COORDINATE for x in (*extent.GetMin(), *extent.GetMax()))


def _single(value: float) -> float:
    return float(np.float32(value))


def free_camera(stage: Usd.Stage, time: Usd.TimeCode, purposes: frozenset[str]) -> tuple[Update, np.ndarray]:
    """Params and transform of a 50 mm camera that frames the stage, by the rule of OpenUSD's usdrecord.

    It counts in single precision and passes the camera on as matrices; so does this, for the same picture to the bit.
    """
    camera = Gf.Camera()
    center, size = _stage_bound(stage, time, purposes)
    y_up = UsdGeom.GetStageUpAxis(stage) == UsdGeom.Tokens.y
    plane = Gf.Vec2d(size[0], size[1] if y_up else size[2]) / 2
    radius = _single(math.sqrt(Gf.Dot(plane, plane)))
    half_angle = math.radians(_single(camera.GetFieldOfView(Gf.Camera.FOVHorizontal) / 2))
    distance = _single(_single(radius / math.tan(half_angle)) + (size[2] if y_up else size[1]) / 2)
    near = 1.0
    if distance < near:
        distance = _single(distance + near)
    transform = Gf.Matrix4d(1)
    if y_up:
        transform.SetTranslate(center + Gf.Vec3d(0, 0, distance))
    else:
        transform.SetRotate(Gf.Rotation(Gf.Vec3d(1, 0, 0), 90))
        transform.SetTranslateOnly(center + Gf.Vec3d(0, -distance, 0))
    camera.transform = transform
    transform = camera.frustum.ComputeViewMatrix().GetInverse()
    projection = camera.frustum.ComputeProjectionMatrix()
    params: Update = {
        "projection": "perspective",
        "horizontalAperture": 2 / projection[0][0],
        "verticalAperture": 2 / projection[1][1],
        "focalLength": 1.0,
        "apertureUnit": 1.0,
        "clippingRange": (near, max(1e6, 10 * distance)),
    }
    return params, matrix_array(transform)
