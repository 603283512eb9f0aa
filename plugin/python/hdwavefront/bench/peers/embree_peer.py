# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The same rays through Embree's kernel for one ray (rtcIntersect1, by the package `embreex`) and through our
traversal, in turns, one thread each, on a flat scene (flat.py) as one mesh. Started in a process of its own, with
LP_NUM_THREADS=1: `python embree_peer.py scene.json '{...}'` prints lines of JSON.

Rays: of the camera, in the order of pixels; from what they hit, in cosine-distributed directions (bounce 1); and from
what those hit again (bounce 2). Nothing is sorted.
"""

from __future__ import annotations

import json
import math
import os
import statistics
import sys
import time
from typing import Any

import numpy as np
import numpy.typing as npt

Vectors = npt.NDArray[np.float32]
_FEWEST = 512  # rays of a kind worth measuring


def flattened(path: str) -> tuple[Vectors, npt.NDArray[np.uint32], dict[str, Any]]:
    with open(path, encoding="utf-8") as file:
        flat = json.load(file)
    arrays = np.load(os.path.join(os.path.dirname(path), "meshes.npz"))
    points, triangles, base = [], [], 0
    for number, mesh in enumerate(flat["meshes"]):
        p, t = arrays[f"p{number}"], arrays[f"t{number}"]
        for matrix in flat["groups"][mesh["group"]] if mesh["group"] else [mesh["matrix"]]:
            m = np.array(matrix)
            points.append((p @ m[:3, :3].T + m[:3, 3]).astype(np.float32))
            triangles.append(t + base)
            base += len(p)
    return np.concatenate(points), np.concatenate(triangles).astype(np.uint32), flat["camera"]


def camera_rays(camera: dict[str, Any], width: int, height: int) -> tuple[Vectors, Vectors]:
    """Through a random point of each pixel, row by row."""
    rng = np.random.default_rng(1)
    half = math.tan(math.radians(camera["horizontalDegrees"]) / 2)
    y, x = np.meshgrid(np.arange(height), np.arange(width), indexing="ij")
    jitter = rng.uniform(0, 1, (2, x.size))
    u = ((x.ravel() + jitter[0]) / width * 2 - 1) * half
    v = (1 - (y.ravel() + jitter[1]) / height * 2) * half * height / width
    matrix = np.array(camera["matrix"])
    directions = np.stack([u, v, -np.ones_like(u)], 1) @ matrix[:3, :3].T
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.repeat(matrix[None, :3, 3], len(u), 0).astype(np.float32), directions.astype(np.float32)


def bounced(
    points: Vectors, triangles: npt.NDArray[np.uint32], rays: tuple[Vectors, Vectors], t: Vectors, hit: Any, seed: int
) -> tuple[Vectors, Vectors]:
    """From where the rays ended, on the side that they came from, in cosine-distributed directions."""
    rng = np.random.default_rng(seed)
    found = hit >= 0
    origins, directions = (r[found].astype(np.float64) for r in rays)
    a, b, c = (points[triangles[hit[found], k]].astype(np.float64) for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True) + 1e-30
    normals *= -np.sign((normals * directions).sum(1, keepdims=True))
    ends = origins + t[found, None] * directions + normals * (1e-5 * np.abs(points).max())
    chosen = rng.normal(size=ends.shape)
    chosen = chosen / np.linalg.norm(chosen, axis=1, keepdims=True) + normals
    chosen /= np.linalg.norm(chosen, axis=1, keepdims=True) + 1e-30
    return ends.astype(np.float32), chosen.astype(np.float32)


def _in_turns(contestants: list[Any], turns: int) -> list[list[float]]:
    """CPU seconds of each, of each turn; who begins changes."""
    times: list[list[float]] = [[] for _ in contestants]
    for turn in range(turns):
        for i in range(len(contestants)):
            which = (i + turn) % len(contestants)
            begin = time.process_time()
            contestants[which]()
            times[which].append(time.process_time() - begin)
    return times


def main() -> int:
    path, options = sys.argv[1], json.loads(sys.argv[2])
    from embreex import rtcore_scene  # type: ignore
    from embreex.mesh_construction import TriangleMesh  # type: ignore

    from hdwavefront.api import core

    points, triangles, camera = flattened(path)
    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, points, triangles.astype(np.int32))
    caster = core().RayCaster(points, triangles, options["device"])
    rays = camera_rays(camera, options["width"], options["height"])
    scene.run(rays[0][:1], rays[1][:1])  # builds the tree
    for number, kind in enumerate(("camera", "bounce 1", "bounce 2")):
        if len(rays[0]) < _FEWEST:
            break
        caster.set_rays(*rays)
        ours, theirs = _in_turns([caster.cast, lambda r=rays: scene.run(*r)], options["turns"])
        t, hit = caster.hits()
        agree = float(np.mean((np.asarray(scene.run(*rays)) >= 0) == (hit >= 0)))
        said = {
            "event": "rays",
            "kind": kind,
            "triangles": len(triangles),
            "rays": len(hit),
            "hit": float(np.mean(hit >= 0)),
            "agree": agree,
            "ours": len(hit) / statistics.median(ours) * 1e-6,
            "theirs": len(hit) / statistics.median(theirs) * 1e-6,
            "ratio": statistics.median(b / a for a, b in zip(ours, theirs, strict=True)),
        }
        print("\n" + json.dumps(said), flush=True)
        rays = bounced(points, triangles, rays, t, hit, number + 2)
    return 0


if __name__ == "__main__":
    sys.exit(main())
