# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""CITY: blocks of houses, streets, trees and cars, all of them instances, under sun and sky. The class of the paper's
scene of that name: 879K triangles, counted as they are seen, and at most 24 materials of middling complexity."""

from __future__ import annotations

import numpy as np

from .builder import Builder, NetworkMaker, Scene
from .materials import Network, Output, Vector
from .shapes import Array, Mesh, box, ellipsoid, lathe, merge, quad, rounded_box

BLOCKS = 6  # each way
BLOCK, STREET = 42.0, 16.0
TRIANGLES = 879_000


def _joints(n: Network, position: Output, index: int, width: float) -> Output:
    """1 in the joints between courses along an axis, whose cells are 1 high."""
    place = n.node("modulo_float", in1=n.node("extract_vector3", in_=position, index=index), in2=1.0)
    return n.node("ifgreater_float", value1=place, value2=width, in1=0.0, in2=1.0)


def bricks(low: tuple[float, ...], high: tuple[float, ...], mortar: tuple[float, ...]) -> NetworkMaker:
    def make(n: Network) -> None:
        cells = n.position(Vector(2.2, 6.0, 2.2))
        brick = n.mixed(low, high, n.node("cellnoise3d_float", position=cells))
        dirt = n.fractal(n.position(0.35, space="world"), octaves=3)
        color = n.mixed(brick, mortar, _joints(n, cells, 1, 0.12))
        n.standard_surface(
            base_color=n.mixed(n.node("multiply_color3FA", in1=color, in2=0.55), color, dirt),
            specular=0.3,
            specular_roughness=n.mixed_float(0.5, 0.8, dirt),
        )

    return make


def plaster(low: tuple[float, ...], high: tuple[float, ...]) -> NetworkMaker:
    def make(n: Network) -> None:
        stain = n.fractal(n.position(Vector(0.5, 0.12, 0.5), space="world"), octaves=4)
        grain = n.fractal(n.position(9.0), octaves=2)
        n.standard_surface(
            base_color=n.mixed(low, high, stain),
            diffuse_roughness=0.4,
            specular=0.25,
            specular_roughness=n.mixed_float(0.45, 0.85, grain),
        )

    return make


def panels(low: tuple[float, ...], high: tuple[float, ...]) -> NetworkMaker:
    """Metal cladding with a thin coat."""

    def make(n: Network) -> None:
        cells = n.position(Vector(0.4, 0.5, 0.4))
        shade = n.node("cellnoise3d_float", position=cells)
        wear = n.fractal(n.position(1.5, space="world"), octaves=3)
        joint = _joints(n, cells, 1, 0.05)
        n.standard_surface(
            base_color=n.mixed(n.mixed(low, high, shade), (0.02, 0.02, 0.02), joint),
            metalness=0.7,
            specular_roughness=n.mixed_float(0.2, 0.5, wear),
            coat=0.4,
            coat_roughness=0.12,
        )

    return make


def window(tint: tuple[float, ...]) -> NetworkMaker:
    """Dark glass, each pane of a shade of its own."""

    def make(n: Network) -> None:
        pane = n.node("cellnoise3d_float", position=n.position(Vector(0.45, 0.33, 0.45), space="world"))
        wave = n.fractal(n.position(0.8, space="world"), octaves=2)
        n.standard_surface(
            base_color=n.mixed((0.01, 0.012, 0.016), tint, pane),
            specular=1.0,
            specular_roughness=n.mixed_float(0.02, 0.12, wave),
            coat=0.6,
            coat_roughness=0.02,
        )

    return make


def ground(low: tuple[float, ...], high: tuple[float, ...], scale: float, octaves: int) -> NetworkMaker:
    def make(n: Network) -> None:
        large = n.fractal(n.position(scale, space="world"), octaves=octaves)
        fine = n.node("worleynoise3d_float", position=n.position(scale * 12, space="world"))
        amount = n.node("multiply_float", in1=large, in2=n.node("add_float", in1=fine, in2=0.5))
        n.standard_surface(base_color=n.mixed(low, high, n.clamped(amount)), specular=0.2, specular_roughness=0.7)

    return make


def leaves(low: tuple[float, ...], high: tuple[float, ...]) -> NetworkMaker:
    def make(n: Network) -> None:
        clump = n.fractal(n.position(2.5, space="world"), octaves=3)
        n.standard_surface(
            base_color=n.mixed(low, high, clump), specular=0.3, specular_roughness=0.55, sheen=0.3, sheen_roughness=0.4
        )

    return make


def lacquer(color: tuple[float, ...]) -> NetworkMaker:
    def make(n: Network) -> None:
        flake = n.node("cellnoise3d_float", position=n.position(90.0))
        n.standard_surface(
            base_color=n.node("multiply_color3FA", in1=color, in2=n.mixed_float(0.7, 1.1, flake)),
            metalness=0.3,
            specular_roughness=0.35,
            coat=1.0,
            coat_roughness=0.03,
        )

    return make


_WALLS: dict[str, NetworkMaker] = {
    "BrickRed": bricks((0.28, 0.07, 0.045), (0.48, 0.16, 0.09), (0.42, 0.39, 0.35)),
    "BrickBrown": bricks((0.16, 0.085, 0.05), (0.3, 0.18, 0.11), (0.36, 0.33, 0.3)),
    "BrickPale": bricks((0.5, 0.42, 0.3), (0.64, 0.56, 0.42), (0.55, 0.52, 0.47)),
    "PlasterWhite": plaster((0.5, 0.48, 0.44), (0.8, 0.78, 0.74)),
    "PlasterOchre": plaster((0.42, 0.28, 0.12), (0.66, 0.48, 0.24)),
    "PlasterGrey": plaster((0.22, 0.23, 0.25), (0.42, 0.43, 0.45)),
    "PlasterRose": plaster((0.45, 0.26, 0.22), (0.68, 0.46, 0.4)),
    "PanelSteel": panels((0.3, 0.34, 0.38), (0.5, 0.54, 0.58)),
    "PanelBronze": panels((0.24, 0.17, 0.11), (0.42, 0.32, 0.22)),
}
_WINDOWS = {"GlassBlue": (0.03, 0.06, 0.1), "GlassGreen": (0.03, 0.07, 0.06), "GlassWarm": (0.25, 0.17, 0.08)}
_OTHERS: dict[str, NetworkMaker] = {
    "Asphalt": ground((0.025, 0.025, 0.027), (0.075, 0.075, 0.08), 0.4, 4),
    "Pavement": ground((0.18, 0.175, 0.165), (0.36, 0.35, 0.33), 0.9, 3),
    "Grass": ground((0.03, 0.07, 0.012), (0.1, 0.19, 0.04), 0.5, 4),
    "LeafGreen": leaves((0.025, 0.07, 0.012), (0.11, 0.22, 0.04)),
    "LeafYellow": leaves((0.1, 0.09, 0.01), (0.34, 0.24, 0.04)),
    "Bark": ground((0.05, 0.03, 0.018), (0.14, 0.09, 0.06), 4.0, 3),
    "Roof": ground((0.09, 0.085, 0.08), (0.2, 0.19, 0.18), 0.6, 3),
    "CarRed": lacquer((0.5, 0.02, 0.02)),
    "CarBlue": lacquer((0.02, 0.08, 0.35)),
    "CarSilver": lacquer((0.55, 0.56, 0.58)),
    "Rubber": ground((0.012, 0.012, 0.012), (0.03, 0.03, 0.03), 3.0, 2),
}


def _house(width: float, depth: float, floors: int, bays: int, storey: float) -> tuple[Mesh, Mesh, Mesh]:
    """Walls, panes and roof of a house on the ground, its front at +z. Panes stand before the walls, on all sides."""
    height = floors * storey + 1.0
    walls = [box((width, height, depth), (0, height / 2, 0)), box((width + 0.5, 0.5, depth + 0.5), (0, height, 0))]
    panes = []
    for side, (length, reach) in enumerate(((width, depth), (depth, width), (width, depth), (depth, width))):
        count = max(1, round(bays * length / width))
        pitch = length / count
        for column in range(count):
            for floor in range(floors):
                x, y, z = (column + 0.5) * pitch - length / 2, floor * storey + 0.9, reach / 2 + 0.04
                w, h = 0.62 * pitch, 0.62 * storey
                panes.append(quad((x - w / 2, y, z), (w, 0, 0), (0, h, 0)).turned(1, 90.0 * side))
                walls.append(box((w + 0.3, 0.16, 0.3), (x, y - 0.08, z)).turned(1, 90.0 * side))
    roof = [
        quad((-width / 2, height + 0.26, depth / 2), (width, 0, 0), (0, 0, -depth)),
        box((width * 0.3, 2.2, depth * 0.3), (width * 0.15, height + 1.1, -depth * 0.1)),
        box((1.6, 1.4, 1.6), (-width * 0.25, height + 0.7, depth * 0.2)),
    ]
    return merge(walls), merge(panes), merge(roof)


def _tree(height: float, spread: float, seed: int) -> tuple[Mesh, Mesh]:
    rng = np.random.default_rng(seed)
    trunk = lathe([(0.26, 0), (0.17, 0.5), (0.13, 0.6 * height), (0.05, 0.85 * height)], 7)
    crown = []
    for i in range(5):
        angle, lift = 2 * np.pi * i / 5 + rng.uniform(0, 1), rng.uniform(0.58, 0.86) * height
        ball = ellipsoid((spread * rng.uniform(0.5, 0.7), spread * 0.5, spread * rng.uniform(0.5, 0.7)), 5, 8)
        reach = 0.4 * spread if i else 0.0
        crown.append(ball.moved((reach * np.cos(angle), lift if i else 0.92 * height, reach * np.sin(angle))))
    return trunk, merge(crown)


def _car() -> tuple[Mesh, Mesh, Mesh]:
    body = rounded_box((4.2, 0.62, 1.75), 0.24, 2).moved((0, 0.62, 0))
    roof = rounded_box((1.7, 0.14, 1.35), 0.06, 1).moved((-0.2, 1.4, 0))
    cabin = rounded_box((2.3, 0.62, 1.5), 0.26, 2).moved((-0.2, 1.06, 0))
    wheels = []
    for x in (-1.3, 1.3):
        for z in (-0.78, 0.78):
            tyre = lathe([(0.0, -0.11), (0.31, -0.11), (0.31, 0.11), (0.0, 0.11)], 10)
            wheels.append(tyre.turned(0, 90).moved((x, 0.31, z)))
    return merge([body, roof]), cabin, merge(wheels)


def _prototypes(b: Builder, looks: dict[str, str]) -> tuple[list[str], list[str], list[str]]:
    houses = []
    low, high, glass = [*_WALLS][:7], [*_WALLS][7:], [*_WINDOWS]
    for i in range(12):
        floors = (4, 6, 5, 9, 4, 7, 12, 5, 8, 6, 16, 5)[i]
        tower = floors > 8
        width = (11.5, 12.5, 10.5, 13.0)[i % 4] + (2.0 if tower else 0.0)
        house = _house(width, 11.0 + (i % 3), floors, (4, 5, 3, 6)[i % 4], 3.4)
        walls = high if tower else low
        wall = walls[0]
        walls.append(walls.pop(0))  # the next house wears the next one
        parts = (looks[wall], looks[glass[i % 3]], looks["Roof"])
        houses.append(b.prototype(f"House{i}", list(zip(house, parts, strict=True))))
    trees = []
    for i in range(4):
        tree = _tree(6.0 + i, 2.2 + 0.3 * i, i)
        trees.append(
            b.prototype(
                f"Tree{i}", [(tree[0], looks["Bark"]), (tree[1], looks["LeafYellow" if i == 3 else "LeafGreen"])]
            )
        )
    body, cabin, wheels = _car()
    cars = [
        b.prototype(f"Car{i}", [(body, looks[name]), (cabin, looks["GlassBlue"]), (wheels, looks["Rubber"])])
        for i, name in enumerate(("CarRed", "CarBlue", "CarSilver"))
    ]
    return houses, trees, cars


def _streets(b: Builder, looks: dict[str, str]) -> Array:
    """Ground and blocks; gives the blocks' middles."""
    pitch = BLOCK + STREET
    reach = BLOCKS * pitch
    b.mesh("Asphalt", quad((-reach, 0, reach), (2 * reach, 0, 0), (0, 0, -2 * reach)), looks["Asphalt"])
    ticks = (np.arange(BLOCKS) - (BLOCKS - 1) / 2) * pitch
    middles = np.array([(x, z) for x in ticks for z in ticks])
    b.mesh("Pavement", merge([box((BLOCK, 0.3, BLOCK), (x, 0.15, z)) for x, z in middles]), looks["Pavement"])
    b.mesh("Lawns", merge([box((BLOCK - 30, 0.2, BLOCK - 30), (x, 0.28, z)) for x, z in middles]), looks["Grass"])
    return middles


def _place_houses(b: Builder, houses: list[str], middles: Array, rng: np.random.Generator) -> None:
    """Two along each side of a block, fronts to the street."""
    positions, degrees, which = [], [], []
    for x, z in middles:
        for side in range(4):
            for place in range(2):
                across = (-13.2 + 13.3 * place, 13.2)
                c, s = np.cos(np.pi / 2 * side), np.sin(np.pi / 2 * side)
                positions.append((x + c * across[0] + s * across[1], 0.3, z - s * across[0] + c * across[1]))
                degrees.append(90.0 * side)
                near = np.hypot(x, z) < 110
                pool = range(12) if near else (0, 1, 2, 4, 5, 7, 8, 9, 11)
                which.append(int(rng.choice(list(pool))))
    heights = rng.uniform(0.92, 1.1, len(which))
    scales = np.stack([np.ones_like(heights), heights, np.ones_like(heights)], 1)
    b.place("Houses", houses, np.array(which, np.int32), np.array(positions), np.array(degrees), scales)


def _along_streets(count: int, offset: float, rng: np.random.Generator) -> tuple[Array, Array]:
    """Places at a distance from the middle of streets, and the streets' directions in degrees."""
    pitch = BLOCK + STREET
    lines = (np.arange(BLOCKS + 1) - BLOCKS / 2) * pitch
    line = lines[rng.integers(0, len(lines), count)]
    along = rng.uniform(-0.5, 0.5, count) * BLOCKS * pitch
    # Not where streets cross.
    crossing = np.abs((along / pitch + BLOCKS / 2 + 0.5) % 1 - 0.5) * pitch < STREET * 0.75
    along = np.where(crossing, along + STREET * 1.6, along)
    side = rng.choice([-1.0, 1.0], count)
    turned = rng.integers(0, 2, count) == 1
    x, z = np.where(turned, along, line + side * offset), np.where(turned, line + side * offset, along)
    degrees = np.where(turned, 0.0, 90.0) + np.where(side > 0, 180.0, 0.0)
    return np.stack([x, np.zeros(count), z], 1), degrees


def build(folder: str) -> Scene:
    b = Builder("city", folder)
    rng = np.random.default_rng(2013)
    makers = {**_WALLS, **{name: window(tint) for name, tint in _WINDOWS.items()}, **_OTHERS}
    looks = {name: b.material(name, make) for name, make in makers.items()}
    houses, trees, cars = _prototypes(b, looks)
    middles = _streets(b, looks)
    _place_houses(b, houses, middles, rng)
    positions, degrees = _along_streets(220, 3.2, rng)
    b.place("Cars", cars, rng.integers(0, 3, 220).astype(np.int32), positions, degrees)
    # Trees last: as many as bring the count to that of the paper.
    per_tree = b.triangles_of(trees[0])
    count = round((TRIANGLES - b.triangles) / per_tree)
    along, _ = _along_streets(count, STREET / 2 + 1.4, rng)
    inner = middles[rng.integers(0, len(middles), count)] + rng.uniform(-5, 5, (count, 2))
    lawn = rng.uniform(0, 1, count) < 0.3
    places = np.where(lawn[:, None], np.stack([inner[:, 0], np.full(count, 0.3), inner[:, 1]], 1), along)
    size = np.repeat(rng.uniform(0.75, 1.25, count)[:, None], 3, 1)
    b.place("Trees", trees, rng.integers(0, 4, count).astype(np.int32), places, rng.uniform(0, 360, count), size)
    b.sun(3.6, 0.53, (-42, 38, 0), (1.0, 0.93, 0.82))
    b.dome(1.1, (0.6, 0.78, 1.0))
    b.camera((4, 24, 192), (-10, 2, 70), 20.0)
    return b.finish(maxBounces=12, rouletteBounce=5)
