# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Primary rays of a flat scene (flat.py) through Embree's closest-hit kernel, by the package `embreex`. Started in a
process of its own: `python embree_peer.py scene.json '{...}'` prints a line of JSON. Instances are flattened."""

from __future__ import annotations

import json
import math
import os
import sys
import time
from typing import Any

import numpy as np


def flattened(path: str) -> tuple[np.ndarray, np.ndarray, dict[str, Any]]:
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
    return np.concatenate(points), np.concatenate(triangles).astype(np.int32), flat["camera"]


def camera_rays(camera: dict[str, Any], width: int, height: int, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Through random points of all pixels, row by row."""
    rng = np.random.default_rng(1)
    half = math.tan(math.radians(camera["horizontalDegrees"]) / 2)
    y, x, _ = np.meshgrid(np.arange(height), np.arange(width), np.arange(samples), indexing="ij")
    jitter = rng.uniform(0, 1, (2, x.size))
    u = ((x.ravel() + jitter[0]) / width * 2 - 1) * half
    v = (1 - (y.ravel() + jitter[1]) / height * 2) * half * height / width
    matrix = np.array(camera["matrix"])
    directions = np.stack([u, v, -np.ones_like(u)], 1) @ matrix[:3, :3].T
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    return np.repeat(matrix[None, :3, 3], len(u), 0).astype(np.float32), directions.astype(np.float32)


def main() -> int:
    path, options = sys.argv[1], json.loads(sys.argv[2])
    from embreex import rtcore_scene  # type: ignore
    from embreex.mesh_construction import TriangleMesh  # type: ignore

    points, triangles, camera = flattened(path)
    begin = time.perf_counter()
    scene = rtcore_scene.EmbreeScene()
    TriangleMesh(scene, points, triangles)
    origins, directions = camera_rays(camera, options["width"], options["height"], options["samples"])
    scene.run(origins[:1], directions[:1])  # builds the tree
    print(json.dumps({"event": "opened", "seconds": time.perf_counter() - begin}), flush=True)
    rates = []
    hits = np.zeros(0)
    for _ in range(5):
        cpu = time.process_time()
        hits = scene.run(origins, directions)
        rates.append(len(origins) / (time.process_time() - cpu) * 1e-6)
    hit = float(np.mean(np.asarray(hits) >= 0))
    said = {"event": "rays", "mraysPerCpuSecond": float(np.median(rates)), "rays": len(origins), "hit": hit}
    print(json.dumps(said), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
