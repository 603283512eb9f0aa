# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The scenes of the benchmark are what they say: sizes of the paper's classes, the same bytes each time."""

from __future__ import annotations

import hashlib
from pathlib import Path

import numpy as np
import pytest
from hdwavefront.api import Render
from hdwavefront.bench.scenes import SCENES, shapes, sweep_scene

# Triangles as they are seen (Laine, Karras and Aila 2013, table 1), and materials at most.
CLASSES = {"carpaint": (9_500, 4), "city": (879_000, 24), "conference": (283_000, 40)}


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_has_the_size_of_its_class(name: str, tmp_path: Path) -> None:
    from pxr import Usd, UsdGeom, UsdShade

    scene = SCENES[name](str(tmp_path))
    triangles, materials = CLASSES[name]
    assert scene.triangles == pytest.approx(triangles, rel=0.01)
    assert 2 < scene.materials <= materials
    stage = Usd.Stage.Open(scene.path)
    # Counted again from the file: meshes that are seen by themselves, and those of instancers.
    size = {
        p.GetPath(): len(UsdGeom.Mesh(p).GetFaceVertexCountsAttr().Get())
        for p in stage.TraverseAll()
        if p.IsA(UsdGeom.Mesh)
    }
    counted = sum(n for path, n in size.items() if not path.HasPrefix("/World/Prototypes"))
    for prim in stage.Traverse():
        if not prim.IsA(UsdGeom.PointInstancer):
            continue
        instancer = UsdGeom.PointInstancer(prim)
        each = [
            sum(n for path, n in size.items() if path.HasPrefix(target))
            for target in instancer.GetPrototypesRel().GetTargets()
        ]
        counted += sum(each[i] for i in instancer.GetProtoIndicesAttr().Get())
    assert counted == scene.triangles
    bound = {
        str(UsdShade.MaterialBindingAPI(p).GetDirectBinding().GetMaterialPath())
        for p in stage.TraverseAll()
        if p.IsA(UsdGeom.Mesh)
    }
    assert len(bound) == scene.materials == sum(p.IsA(UsdShade.Material) for p in stage.TraverseAll())


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_is_the_same_each_time(name: str, tmp_path: Path) -> None:
    from pxr import Sdf

    hashes = []
    for folder in (tmp_path / "a", tmp_path / "b"):
        folder.mkdir()
        text = Sdf.Layer.FindOrOpen(SCENES[name](str(folder)).path).ExportToString()
        hashes.append(hashlib.sha256(text.encode()).hexdigest())
    assert hashes[0] == hashes[1]


CLOSED = {
    "box": (shapes.box((1, 2, 3)), 6.0),
    "rounded_box": (shapes.rounded_box((1, 2, 3), 0.1, 4), 5.86),
    "ellipsoid": (shapes.ellipsoid((1, 1, 2), 24, 48), 4 / 3 * np.pi * 2),
    "torus": (shapes.torus(1.0, 0.25, 64, 24), 2 * np.pi * np.pi * 0.25**2),
    "extruded": (shapes.extruded(shapes.superellipse(1, 1, 2, 64), 0.5, 0.001, 2), np.pi * 0.5),
}


@pytest.mark.parametrize("name", CLOSED)
def test_a_closed_shape_holds_its_volume_and_faces_outward(name: str) -> None:
    """By the divergence theorem; a surface that faces inward would give it with the wrong sign."""
    mesh, volume = CLOSED[name]
    a, b, c = (mesh.points[mesh.triangles[:, i]] for i in range(3))
    assert np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6 == pytest.approx(volume, rel=0.02)
    if mesh.normals is not None:
        faces = np.cross(b - a, c - a)
        means = mesh.normals[mesh.triangles].mean(1)
        assert (np.einsum("ij,ij->i", faces, means) > 0).all()
    moved = mesh.turned(1, 90).scaled((2, 1, 1)).moved((5, 0, 0))
    a, b, c = (moved.points[moved.triangles[:, i]] for i in range(3))
    assert np.einsum("ij,ij->i", a - 5, np.cross(b - 5, c - 5)).sum() / 6 == pytest.approx(2 * volume, rel=0.02)


def test_a_turn_about_y_takes_z_to_x() -> None:
    point = shapes.Mesh(np.array([[0.0, 0, 1]]), np.zeros((0, 3), np.int32)).turned(1, 90).points[0]
    assert np.allclose(point, (1, 0, 0))


def test_an_indexed_mesh_takes_at_most_90_bytes_a_triangle(tmp_path: Path) -> None:
    scene = sweep_scene(str(tmp_path), "triangles", count=50_000)
    render = Render(scene.path, width=16, settings={**scene.settings, "samples": 1})
    render.start()
    render.wait()
    assert 70 < render.stats()["memoryBytes"]["geometry"] / scene.triangles <= 90
