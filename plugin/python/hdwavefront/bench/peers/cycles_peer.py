# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""A flat scene (flat.py) in Blender's Cycles, on the processor. Runs by itself in a Python that has `bpy`:
`python cycles_peer.py scene.json '{...}'` prints a line of JSON for each picture. Materials become Principled BSDFs."""

from __future__ import annotations

import json
import math
import os
import sys
import time
from typing import Any

import bpy  # type: ignore
import numpy as np
from mathutils import Matrix  # type: ignore

_Y_TO_Z = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))  # Blender's z is up


def _material(name: str, plain: dict[str, Any]) -> Any:
    material = bpy.data.materials.new(name or "default")
    material.use_nodes = True
    inputs = material.node_tree.nodes["Principled BSDF"].inputs
    inputs["Base Color"].default_value = (*plain["color"], 1.0)
    inputs["Roughness"].default_value = plain["roughness"]
    inputs["Metallic"].default_value = plain["metallic"]
    inputs["Specular IOR Level"].default_value = plain["specular"]
    inputs["Coat Weight"].default_value = plain["coat"]
    inputs["Coat Roughness"].default_value = plain["coatRoughness"]
    inputs["Transmission Weight"].default_value = plain["transmission"]
    peak = max(plain["emission"])
    if peak > 0:
        inputs["Emission Color"].default_value = (*(e / peak for e in plain["emission"]), 1.0)
        inputs["Emission Strength"].default_value = peak
    return material


def _mesh(number: int, arrays: Any, material: Any) -> Any:
    mesh = bpy.data.meshes.new(f"m{number}")
    points, triangles = arrays[f"p{number}"], arrays[f"t{number}"]
    mesh.vertices.add(len(points))
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.astype(np.int32).ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    smooth = f"n{number}" in arrays
    mesh.polygons.foreach_set("use_smooth", np.full(len(triangles), smooth))
    mesh.materials.append(material)
    mesh.update(calc_edges=True)
    return mesh


def _light(index: int, light: dict[str, Any]) -> None:
    radiance = np.array(light["radiance"])
    peak = max(float(radiance.max()), 1e-9)
    if light["kind"] == "dome":
        world = bpy.context.scene.world
        world.use_nodes = True
        background = world.node_tree.nodes["Background"].inputs
        background["Color"].default_value = (*(radiance / peak), 1.0)
        background["Strength"].default_value = peak
        return
    kind = {"rect": "AREA", "sphere": "POINT", "distant": "SUN"}[light["kind"]]
    data = bpy.data.lights.new(f"l{index}", kind)
    data.color = radiance / peak
    if kind == "SUN":
        data.angle = math.radians(light["angle"])
        data.energy = peak
    elif kind == "AREA":  # watts: radiance times pi times the area
        data.shape, data.size, data.size_y = "RECTANGLE", light["width"], light["height"]
        data.energy = peak * math.pi * light["width"] * light["height"]
    else:  # radiance times pi times the sphere's area
        data.shadow_soft_size = light["radius"]
        data.use_soft_falloff = False  # a sphere; with it, a disc that turns to whoever looks
        data.energy = peak * math.pi * 4 * math.pi * light["radius"] ** 2
    made = bpy.data.objects.new(f"l{index}", data)
    made.visible_camera = kind != "SUN"  # Blender hides lights from the camera unless it is told otherwise
    made.matrix_world = _Y_TO_Z @ Matrix(light["matrix"])
    bpy.context.scene.collection.objects.link(made)


def build(path: str, options: dict[str, Any]) -> None:
    with open(path, encoding="utf-8") as file:
        flat = json.load(file)
    arrays = dict(np.load(os.path.join(os.path.dirname(path), "meshes.npz")))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("world")
    scene.world.color = (0.0, 0.0, 0.0)  # a new world shines with a radiance of .05 where no dome is given
    materials = {name: _material(name, plain) for name, plain in flat["materials"].items()}
    for number, mesh in enumerate(flat["meshes"]):
        data = _mesh(number, arrays, materials[mesh["material"]])
        places = flat["groups"][mesh["group"]] if mesh["group"] else [mesh["matrix"]]
        for i, matrix in enumerate(places):
            made = bpy.data.objects.new(f"o{number}_{i}", data)
            made.matrix_world = _Y_TO_Z @ Matrix(matrix)
            scene.collection.objects.link(made)
    for index, light in enumerate(flat["lights"]):
        _light(index, light)
    lens = bpy.data.cameras.new("camera")
    lens.sensor_fit, lens.angle = "HORIZONTAL", math.radians(flat["camera"]["horizontalDegrees"])
    camera = bpy.data.objects.new("camera", lens)
    camera.matrix_world = _Y_TO_Z @ Matrix(flat["camera"]["matrix"])
    scene.collection.objects.link(camera)
    scene.camera = camera
    _settings(scene, options)


def _settings(scene: Any, options: dict[str, Any]) -> None:
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = options["width"], options["height"]
    scene.render.resolution_percentage = 100
    cycles = scene.cycles
    cycles.device = "CPU"
    cycles.use_adaptive_sampling = cycles.use_denoising = False
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 1.0
    bounces = options["maxBounces"]
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.view_settings.view_transform = "Raw"


def _render(folder: str, name: str) -> np.ndarray:
    path = os.path.join(folder, name + ".exr")
    bpy.context.scene.render.filepath = path
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(path)
    pixels = np.array(image.pixels[:], np.float32).reshape(image.size[1], image.size[0], -1)[::-1, :, :3]
    bpy.data.images.remove(image)
    return pixels


def main() -> int:
    path, options = sys.argv[1], json.loads(sys.argv[2])
    folder = os.path.dirname(path)
    begin = time.perf_counter()
    build(path, options)
    cycles = bpy.context.scene.cycles
    cycles.samples = 1
    _render(folder, "warm")
    print("\n" + json.dumps({"event": "opened", "seconds": time.perf_counter() - begin}), flush=True)
    # What a picture of one sample takes is taken off: building its trees again is no rendering.
    wall, cpu = time.perf_counter(), time.process_time()
    _render(folder, "one")
    one_wall, one_cpu = time.perf_counter() - wall, time.process_time() - cpu
    for seed in (1, 2):
        cycles.samples, cycles.seed = options["samples"] + 1, seed
        wall, cpu = time.perf_counter(), time.process_time()
        pixels = _render(folder, f"cycles{seed}")
        wall, cpu = time.perf_counter() - wall - one_wall, time.process_time() - cpu - one_cpu
        file = os.path.join(folder, f"cycles{seed}.npy")
        np.save(file, pixels)
        said = {"event": "picture", "wall": max(wall, 1e-6), "cpu": max(cpu, 1e-6), "file": file}
        print("\n" + json.dumps(said), flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
