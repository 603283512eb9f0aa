# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""A flat scene (flat.py) in Mitsuba 3. Started in a process of its own: `python mitsuba_peer.py scene.json '{...}'`
prints a line of JSON for each picture. Materials become `principled` and `dielectric`; what flat.py leaves out is left
out."""

from __future__ import annotations

import json
import os
import sys
import time
from typing import Any

import numpy as np


def _bsdf(mi: Any, plain: dict[str, Any]) -> dict[str, Any]:
    if plain["transmission"] > 0.5:
        return {"type": "dielectric"}
    color = {"type": "rgb", "value": [min(max(c, 0.0), 1.0) for c in plain["color"]]}
    principled = {
        "type": "principled",
        "base_color": color,
        "roughness": max(plain["roughness"], 0.03),
        "metallic": plain["metallic"],
        "specular": plain["specular"],
        "clearcoat": plain["coat"],
        "clearcoat_gloss": 1.0 - min(plain["coatRoughness"], 1.0),
    }
    return {"type": "twosided", "bsdf": principled}


def _light(mi: Any, light: dict[str, Any]) -> dict[str, Any]:
    to_world = mi.ScalarTransform4f(np.array(light["matrix"]))
    rgb = {"type": "rgb", "value": light["radiance"]}
    if light["kind"] == "dome":
        return {"type": "constant", "radiance": rgb}
    if light["kind"] == "distant":
        return {"type": "directional", "direction": (-np.array(light["matrix"])[:3, 2]).tolist(), "irradiance": rgb}
    emitter = {"type": "area", "radiance": rgb}
    if light["kind"] == "rect":  # USD's shines along -z, the rectangle of Mitsuba along +z
        turn = mi.ScalarTransform4f().rotate([0, 1, 0], 180)
        scale = mi.ScalarTransform4f().scale([light["width"] / 2, light["height"] / 2, 1])
        return {"type": "rectangle", "to_world": to_world @ turn @ scale, "emitter": emitter}
    scale = mi.ScalarTransform4f().scale(light["radius"])
    return {"type": "sphere", "to_world": to_world @ scale, "emitter": emitter}


def _shape(mi: Any, number: int, arrays: Any, plain: dict[str, Any], matrix: np.ndarray) -> Any:
    points = arrays[f"p{number}"] @ matrix[:3, :3].T + matrix[:3, 3]
    triangles = arrays[f"t{number}"]
    normals = arrays.get(f"n{number}")
    props = mi.Properties()
    props["bsdf"] = mi.load_dict(_bsdf(mi, plain))
    if any(plain["emission"]):
        props["emitter"] = mi.load_dict({"type": "area", "radiance": {"type": "rgb", "value": plain["emission"]}})
    mesh = mi.Mesh(f"m{number}", len(points), len(triangles), props=props, has_vertex_normals=normals is not None)
    params = mi.traverse(mesh)
    params["vertex_positions"] = np.ascontiguousarray(points, np.float32).ravel()
    params["faces"] = triangles.astype(np.uint32).ravel()
    if normals is not None:
        params["vertex_normals"] = np.ascontiguousarray(normals @ np.linalg.inv(matrix[:3, :3]), np.float32).ravel()
    params.update()
    return mesh


def scene_of(mi: Any, path: str, options: dict[str, Any]) -> Any:
    with open(path, encoding="utf-8") as file:
        flat = json.load(file)
    arrays = dict(np.load(os.path.join(os.path.dirname(path), "meshes.npz")))
    scene: dict[str, Any] = {"type": "scene", "integrator": {"type": "path", "max_depth": options["maxBounces"] + 1}}
    if "rouletteBounce" in options:
        scene["integrator"]["rr_depth"] = options["rouletteBounce"] + 1
    grouped: dict[str, list[Any]] = {}
    for number, mesh in enumerate(flat["meshes"]):
        shape = _shape(mi, number, arrays, flat["materials"][mesh["material"]], np.array(mesh["matrix"]))
        if mesh["group"]:
            grouped.setdefault(mesh["group"], []).append(shape)
        else:
            scene[f"mesh{number}"] = shape
    for index, (name, shapes) in enumerate(grouped.items()):
        group = {"type": "shapegroup", **{f"s{i}": s for i, s in enumerate(shapes)}}
        scene[f"group{index}"] = group
        for i, matrix in enumerate(flat["groups"][name]):
            place = {"type": "ref", "id": f"group{index}"}
            scene[f"i{index}_{i}"] = {
                "type": "instance",
                "to_world": mi.ScalarTransform4f(np.array(matrix)),
                "g": place,
            }
    for index, light in enumerate(flat["lights"]):
        scene[f"light{index}"] = _light(mi, light)
    turn = mi.ScalarTransform4f().rotate([0, 1, 0], 180)
    scene["sensor"] = {
        "type": "perspective",
        "fov": flat["camera"]["horizontalDegrees"],
        "fov_axis": "x",
        "to_world": mi.ScalarTransform4f(np.array(flat["camera"]["matrix"])) @ turn,
        "film": {
            "type": "hdrfilm",
            "width": options["width"],
            "height": options["height"],
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
        },
        "sampler": {"type": "independent"},
    }
    return mi.load_dict(scene)


def main() -> int:
    path, options = sys.argv[1], json.loads(sys.argv[2])
    import mitsuba

    mi: Any = mitsuba
    mi.set_variant(options["variant"])
    begin = time.perf_counter()
    scene = scene_of(mi, path, options)
    mi.render(scene, spp=1, seed=99).numpy()  # what is compiled or built at first use
    print(json.dumps({"event": "opened", "seconds": time.perf_counter() - begin}), flush=True)
    for seed in (1, 2):
        wall, cpu = time.perf_counter(), time.process_time()
        image = np.array(mi.render(scene, spp=options["samples"], seed=seed))
        wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
        file = os.path.join(os.path.dirname(path), f"mitsuba{seed}.npy")
        np.save(file, image[..., :3].astype(np.float32))
        print(json.dumps({"event": "picture", "wall": wall, "cpu": cpu, "file": file}), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
