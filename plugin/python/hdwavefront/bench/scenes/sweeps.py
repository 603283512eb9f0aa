# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Scenes of which one number grows while the rest stays: materials, operations, triangles, instances, lights."""

from __future__ import annotations

import colorsys
import os
from collections.abc import Callable

import numpy as np

from .builder import Builder, NetworkMaker, Scene
from .materials import File, Network, Output
from .shapes import Array, Mesh, ellipsoid, merge, quad, surface

# Arithmetic operations of one octave of MaterialX's fractal3d, as counted in its GLSL: eight gradients and their mix.
OPERATIONS_PER_OCTAVE = 125
_CHOICES = 10  # operations of a material that are one or another
MAX_TOPOLOGIES = 1 << _CHOICES
_CELLS = 32  # of the field of bodies, each way


def _field(seed: int = 5) -> tuple[Array, Array]:
    """Places and radii of bodies that lie side by side."""
    rng = np.random.default_rng(seed)
    x, z = np.meshgrid(np.arange(_CELLS), np.arange(_CELLS), indexing="ij")
    radius = rng.uniform(0.34, 0.49, _CELLS * _CELLS)
    return np.stack([x.ravel() - _CELLS / 2 + 0.5, radius, z.ravel() - _CELLS / 2 + 0.5], 1), radius


def _sky(b: Builder) -> None:
    b.sun(2.5, 2.0, (-50, 30, 0))
    b.dome(0.8, (0.75, 0.85, 1.0))


def _grey(n: Network) -> None:
    n.surface(n.node("surface", bsdf=n.node("oren_nayar_diffuse_bsdf", color=(0.5, 0.5, 0.5), roughness=0.0)))


def _write_texture(folder: str, number: int, side: int) -> str:
    """An image of its own for each number. Gives its name, which is relative to the stage."""
    from ...image_io.writer import write_display

    name = f"texture{number}.png"
    rgba = np.random.default_rng(number).random((side, side, 4), np.float32)
    write_display(os.path.join(folder, name), rgba, {})
    return f"./{name}"


def _material(number: int, topology: int, octaves: int, texture: str = "") -> NetworkMaker:
    """Fractal noise, of so many octaves, through operations that the bits of `topology` choose, between two colours.
    The brighter one is the texture's where there is one."""

    def make(n: Network) -> None:
        value: Output = n.fractal(n.position(1.5 + 0.01 * (number % 97), space="world"), octaves=octaves)
        for bit in range(_CHOICES):
            value = n.node("multiply_float" if topology >> bit & 1 else "min_float", in1=value, in2=1.0 - 0.01 * bit)
        hue = (0.381966 * number) % 1.0
        low: tuple[float, ...] = colorsys.hsv_to_rgb(hue, 0.7, 0.25)
        high: tuple[float, ...] | Output = colorsys.hsv_to_rgb(hue, 0.5, 0.8)
        if texture:
            place = n.node("convert_vector3_vector2", in_=n.position(1.0))
            high = n.node("image_color3", file=File(texture), texcoord=place)
        n.standard_surface(
            base_color=n.mixed(low, high, value), specular_roughness=0.15 + 0.5 * ((number * 0.618) % 1.0)
        )

    return make


def materials(folder: str, count: int, topologies: int, operations: int, texture: int = 0) -> Scene:
    """1024 bodies of `count` materials in turn, of so many topologies, of about so many operations each. `texture`:
    texels a side of the texture that each material has for itself; 0: none."""
    if topologies > min(count, MAX_TOPOLOGIES):
        raise ValueError(f"{count} materials cannot have {topologies} topologies")
    b = Builder(f"materials-{count}-{topologies}-{operations}-{texture}", folder)
    octaves = max(1, round(operations / OPERATIONS_PER_OCTAVE))
    places, radii = _field()
    ball = ellipsoid((1, 1, 1), 6, 10)
    # A stride that has no common divisor with the number of bodies: neighbours differ.
    owner = (np.arange(len(places)) * 397) % len(places) % count
    files = [_write_texture(folder, i, texture) if texture else "" for i in range(count)]
    paths = [b.material(f"m{i}", _material(i, i % topologies, octaves, files[i])) for i in range(count)]
    # A mesh for each body, so that rays meet the same geometry whatever the count.
    for k, i in enumerate(owner):
        b.mesh(f"Bodies/b{k}", ball.scaled([radii[k]] * 3).moved(places[k]), paths[i])
    _sky(b)
    b.camera((0, 19, 19), (0, 0, 1.5), 22.0)
    return b.finish(maxBounces=4)


def _relief(side: int) -> Mesh:
    """A smooth relief of 2 side² triangles, rough at every scale that it can show."""
    u = np.linspace(-1, 1, side + 1)
    x, z = np.meshgrid(u, u, indexing="ij")
    y = np.zeros_like(x)
    frequency, amplitude, turn = 3.0, 0.16, 0.0
    while frequency < side / 3:
        c, s = np.cos(turn), np.sin(turn)
        y += amplitude * np.sin(frequency * (c * x + s * z) + turn) * np.sin(frequency * (c * z - s * x) + 2 * turn)
        frequency, amplitude, turn = 1.9 * frequency, 0.56 * amplitude, turn + 1.1
    return surface(np.stack([10 * x, 10 * y, 10 * z], -1).transpose(1, 0, 2))


def triangles(folder: str, count: int) -> Scene:
    """One indexed mesh with smooth normals, of about so many triangles; no other primvar."""
    b = Builder(f"triangles-{count}", folder)
    side = max(2, round(np.sqrt(count / 2)))
    b.mesh("Relief", _relief(side), b.material("Grey", _grey))
    _sky(b)
    b.camera((0, 9, 13), (0, 0, 1.2), 24.0)
    return b.finish(maxBounces=4)


def instances(folder: str, count: int) -> Scene:
    """Stones in a cloud; all of one mesh."""
    b = Builder(f"instances-{count}", folder)
    stone = b.prototype("Stone", [(ellipsoid((0.5, 0.35, 0.45), 6, 8), b.material("Grey", _grey))])
    rng = np.random.default_rng(3)
    side = max(1, round(count ** (1 / 3)))
    cell = np.stack(np.unravel_index(np.arange(count) % side**3, (side, side, side)), 1)
    spot = (cell + rng.uniform(0, 1, (count, 3))) / side - 0.5
    size = np.repeat(10 / side * rng.uniform(0.5, 1.2, (count, 1)), 3, 1)
    b.place("Stones", [stone], np.zeros(count, np.int32), 14 * spot, rng.uniform(0, 360, count), size)
    _sky(b)
    b.camera((5, 9, 22), (0, 0, 0), 26.0)
    return b.finish(maxBounces=4)


def lights(folder: str, count: int) -> Scene:
    """Bodies on a floor under so many small lights, which together shine as one would."""
    b = Builder(f"lights-{count}", folder)
    grey = b.material("Grey", _grey)
    places, radii = _field()
    ball = ellipsoid((1, 1, 1), 6, 10)
    b.mesh("Bodies", merge(ball.scaled([r] * 3).moved(p) for p, r in zip(places, radii, strict=True)), grey)
    b.mesh("Floor", quad((-20, 0, 20), (40, 0, 0), (0, 0, -40)), grey)
    rng = np.random.default_rng(9)
    radius = 0.03
    for i in range(count):
        x, y, z = rng.uniform(-16, 16), rng.uniform(1.2, 3.5), rng.uniform(-16, 16)
        b.sphere_light(f"l{i}", radius, (x, y, z), 600.0 / (4 * np.pi * np.pi * radius**2) / count)
    b.camera((0, 19, 19), (0, 0, 1.5), 22.0)
    return b.finish(maxBounces=4)


MAKERS: dict[str, Callable[..., Scene]] = {
    "materials": materials,
    "triangles": triangles,
    "instances": instances,
    "lights": lights,
}
