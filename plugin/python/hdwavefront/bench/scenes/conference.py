# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""CONFERENCE: a meeting room, lit from its ceiling, whose pale walls make paths long. The class of the paper's scene of
that name: 283K triangles and at most 40 layered procedural materials."""

from __future__ import annotations

import numpy as np

from . import conference_materials as looks
from .builder import Builder, Scene
from .shapes import Mesh, box, ellipsoid, extruded, lathe, merge, quad, rounded_box, superellipse, surface, torus, tube

TRIANGLES = 283_000
WIDTH, HEIGHT, DEPTH = 9.0, 3.1, 12.0
TABLE_HEIGHT = 0.74
CHAIRS = 20


def _room(b: Builder, m: dict[str, str]) -> None:
    w, h, d = WIDTH / 2, HEIGHT, DEPTH / 2
    b.mesh("Room/Floor", quad((-w, 0, d), (2 * w, 0, 0), (0, 0, -2 * d)), m["Carpet"])
    b.mesh("Room/Ceiling", quad((-w, h, -d), (2 * w, 0, 0), (0, 0, 2 * d)), m["CeilingTiles"])
    b.mesh("Room/Back", quad((-w, 0, -d), (2 * w, 0, 0), (0, h, 0)), m["WallWarm"])
    b.mesh("Room/Front", quad((w, 0, d), (-2 * w, 0, 0), (0, h, 0)), m["WallWhite"])
    b.mesh("Room/Left", quad((-w, 0, d), (0, 0, -2 * d), (0, h, 0)), m["WallWhite"])
    b.mesh("Room/Right", quad((w, 0, -d), (0, 0, 2 * d), (0, h, 0)), m["WallBlue"])
    skirting = [rounded_box((0.03, 0.1, 2 * d), 0.01, 2).moved((x, 0.05, 0)) for x in (-w + 0.015, w - 0.015)] + [
        rounded_box((2 * w, 0.1, 0.03), 0.01, 2).moved((0, 0.05, z)) for z in (-d + 0.015, d - 0.015)
    ]
    b.mesh("Room/Skirting", merge(skirting), m["SkirtingOak"])
    panels = [
        rounded_box((0.05, 2.2, 1.5), 0.015, 2).moved((w - 0.03, 1.5, z)) for z in (-4.5, -2.7, -0.9, 0.9, 2.7, 4.5)
    ]
    b.mesh("Room/Panels", merge(panels), m["PanelFelt"])


def _table(b: Builder, m: dict[str, str]) -> None:
    outline = superellipse(1.05, 3.3, 3.2, 120)
    top = extruded(outline, 0.055, 0.018, 4).moved((0, TABLE_HEIGHT - 0.055, 0))
    b.mesh("Table/Top", top, m["TableWalnut"])
    inlay = extruded(superellipse(0.42, 2.4, 3.5, 80), 0.004, 0.001, 1).moved((0, TABLE_HEIGHT - 0.0005, 0))
    b.mesh("Table/Inlay", inlay, m["LeatherBlack"])
    legs = [
        lathe([(0.42, 0), (0.42, 0.02), (0.36, 0.05), (0.12, 0.12), (0.1, 0.5), (0.2, 0.66), (0.3, 0.69)], 48).moved(
            (0, 0, z)
        )
        for z in (-2.0, 0, 2.0)
    ]
    b.mesh("Table/Legs", merge(legs), m["BrushedSteel"])


def _cushion(width: float, depth: float, height: float, detail: int) -> Mesh:
    """A pillow: thickest in its middle."""
    u = np.linspace(-1, 1, detail)
    x, z = np.meshgrid(u, u, indexing="ij")
    puff = (1 - x**4) * (1 - z**4)
    sides = []
    for sign in (-1.0, 1.0):
        y = sign * height * (0.25 + 0.75 * puff) * (1 - np.maximum(np.abs(x), np.abs(z)) ** 16)
        ripple = 0.004 * np.sin(9 * x) * np.sin(9 * z) * puff
        points = np.stack([x * width / 2, y / 2 + sign * ripple, z * depth / 2], -1)
        sides.append(surface(points if sign < 0 else points.transpose(1, 0, 2)))
    return merge(sides)


def _chair(detail: int) -> dict[str, Mesh]:
    """Looks at +z."""
    seat = _cushion(0.52, 0.5, 0.11, detail).moved((0, 0.46, 0))
    back = _cushion(0.5, 0.62, 0.09, detail).turned(0, -80).moved((0, 0.82, -0.26))
    arms = []
    for x in (-0.3, 0.3):
        bow = [(x, 0.42, -0.16), (x, 0.56, -0.2), (x, 0.66, -0.1), (x, 0.67, 0.1), (x, 0.6, 0.22), (x, 0.43, 0.2)]
        knots = np.linspace(0, 1, len(bow))
        fine = np.linspace(0, 1, 36)
        arms.append(tube(np.stack([np.interp(fine, knots, c) for c in np.array(bow).T], 1), 0.02, 12))
    post = lathe([(0.032, 0.08), (0.032, 0.25), (0.022, 0.26), (0.022, 0.42)], 20)
    base = [rounded_box((0.3, 0.03, 0.04), 0.012, 2).moved((0.16, 0.09, 0)).turned(1, 72.0 * k + 18) for k in range(5)]
    wheels = [
        torus(0.026, 0.016, 18, 8).turned(0, 90).moved((0.29, 0.042, 0)).turned(1, 72.0 * k + 18) for k in range(5)
    ]
    return {"cloth": merge([seat, back]), "arms": merge(arms), "frame": merge([post, *base]), "wheels": merge(wheels)}


def _chairs(b: Builder, m: dict[str, str], detail: int) -> None:
    parts = _chair(detail)
    cloths = ("FabricRed", "FabricGreen", "LeatherBrown", "FabricGrey")
    kinds = [
        b.prototype(
            f"Chair{i}",
            [
                (parts["cloth"], m[cloth]),
                (parts["arms"], m["PlasticBlack"]),
                (parts["frame"], m["Chrome"]),
                (parts["wheels"], m["PlasticBlack"]),
            ],
        )
        for i, cloth in enumerate(cloths)
    ]
    rng = np.random.default_rng(7)
    places, turns = [], []
    for z in np.linspace(-2.5, 2.5, (CHAIRS - 2) // 2):
        for side in (-1.0, 1.0):
            places.append((side * 1.42 + rng.uniform(-0.06, 0.06), 0, z))
            turns.append(-90.0 * side + rng.uniform(-14, 14))
    places += [(0.0, 0, -3.75), (0.1, 0, 3.8)]
    turns += [4.0, 176.0]
    which = np.array([(i // 2 + i) % 4 for i in range(CHAIRS)], np.int32)
    b.place("Chairs", kinds, which, np.array(places), np.array(turns))


def _cup() -> tuple[Mesh, Mesh, Mesh]:
    cup = lathe([(0, 0), (0.026, 0), (0.03, 0.01), (0.036, 0.075), (0.033, 0.075), (0.028, 0.02), (0, 0.014)], 32)
    plate = lathe([(0, 0), (0.04, 0), (0.07, 0.012), (0.069, 0.016), (0.03, 0.006), (0, 0.006)], 36)
    handle = torus(0.018, 0.0045, 20, 8).turned(0, 90).moved((0.045, 0.042, 0))
    coffee = lathe([(0.0335, 0.058), (0, 0.058)], 24).moved((0, 0.006, 0))
    return merge([cup.moved((0, 0.006, 0)), handle.moved((0, 0.006, 0))]), plate, coffee


def _on_the_table(b: Builder, m: dict[str, str]) -> None:
    rng = np.random.default_rng(11)
    cup, plate, coffee = _cup()
    cups = [
        b.prototype(f"Cup{i}", [(cup, m[look]), (plate, m["PorcelainWhite"]), (coffee, m["Coffee"])])
        for i, look in enumerate(("PorcelainWhite", "PorcelainBlue"))
    ]
    rows = np.linspace(-2.5, 2.5, 9)
    seats = np.array([(s * 0.72, TABLE_HEIGHT, z) for z in rows for s in (-1, 1)])
    b.place(
        "Cups", cups, rng.integers(0, 2, 18).astype(np.int32), seats + rng.uniform(-0.05, 0.05, (18, 3)) * (1, 0, 1)
    )
    for i, (look, paper) in enumerate((("BinderRed", "Paper"), ("BinderBlue", "Paper"), ("BinderGreen", "Paper"))):
        binders, sheets = [], []
        for k in range(6):
            x, z = (-1) ** k * 0.6, rows[(3 * k + i) % 9] + 0.22
            turn = rng.uniform(-25, 25)
            binders.append(rounded_box((0.22, 0.02, 0.3), 0.006, 2).turned(1, turn).moved((x, TABLE_HEIGHT + 0.011, z)))
            sheets.append(
                box((0.21, 0.004, 0.297)).turned(1, turn + 11).moved((x * 0.75, TABLE_HEIGHT + 0.003, z + 0.1))
            )
        b.mesh(f"Table/Binders{i}", merge(binders), m[look])
        b.mesh(f"Table/Sheets{i}", merge(sheets), m[paper])
    carafe = lathe(
        [
            (0, 0),
            (0.06, 0),
            (0.075, 0.05),
            (0.07, 0.12),
            (0.035, 0.2),
            (0.042, 0.25),
            (0.038, 0.25),
            (0.031, 0.2),
            (0.066, 0.12),
            (0.07, 0.05),
            (0.055, 0.006),
            (0, 0.006),
        ],
        40,
    )
    b.mesh("Table/Carafes", merge([carafe.moved((0.1, TABLE_HEIGHT + 0.004, z)) for z in (-1.2, 1.2)]), m["GlassClear"])
    laptop = [
        rounded_box((0.33, 0.016, 0.23), 0.006, 2).moved((0, TABLE_HEIGHT + 0.009, 0)),
        rounded_box((0.33, 0.23, 0.01), 0.004, 2)
        .moved((0, 0.115, 0))
        .turned(0, -18)
        .moved((0, TABLE_HEIGHT + 0.015, -0.12)),
    ]
    b.mesh("Table/Laptop", merge(laptop).turned(1, -76).moved((0.68, 0, -0.35)), m["AnodisedGrey"])


def _furniture(b: Builder, m: dict[str, str]) -> None:
    w, d = WIDTH / 2, DEPTH / 2
    board = rounded_box((3.4, 1.5, 0.04), 0.015, 3).moved((0, 1.65, -d + 0.03))
    b.mesh("Wall/Screen", board, m["ScreenMatte"])
    frame = [rounded_box((3.6, 0.08, 0.08), 0.02, 2).moved((0, y, -d + 0.05)) for y in (0.88, 2.42)]
    frame += [rounded_box((0.08, 1.62, 0.08), 0.02, 2).moved((x, 1.65, -d + 0.05)) for x in (-1.76, 1.76)]
    b.mesh("Wall/Frame", merge(frame), m["AnodisedGrey"])
    doors = [rounded_box((0.05, 2.1, 0.95), 0.012, 2).moved((-w + 0.03, 1.05, z)) for z in (-4.4, 4.4)]
    b.mesh("Wall/Doors", merge(doors), m["DoorOak"])
    knobs = [ellipsoid((0.035, 0.035, 0.035), 14, 24).moved((-w + 0.1, 1.05, z + 0.38)) for z in (-4.4, 4.4)]
    b.mesh("Wall/Knobs", merge(knobs), m["Brass"])
    cupboard = rounded_box((0.5, 0.85, 3.4), 0.02, 3).moved((-w + 0.27, 0.43, 0))
    b.mesh("Sideboard", cupboard, m["CabinetWhite"])
    for i, (z, look, pot) in enumerate(((-5.2, "Leaf", "PotTerracotta"), (5.2, "LeafDark", "PotStone"))):
        b.mesh(
            f"Plant{i}/Pot",
            lathe([(0, 0), (0.17, 0), (0.23, 0.4), (0.21, 0.4), (0.2, 0.35), (0, 0.35)], 40).moved((w - 0.5, 0, z)),
            m[pot],
        )
        b.mesh(f"Plant{i}/Leaves", _leaves(70, i).moved((w - 0.5, 0.36, z)), m[look])
    pictures = [(-3.4, "PaintingA"), (3.4, "PaintingB")]
    for x, look in pictures:
        b.mesh(f"Wall/{look}", rounded_box((1.0, 1.2, 0.03), 0.008, 2).moved((x, 1.7, -d + 0.02)), m[look])
    vases = lathe(
        [(0, 0), (0.06, 0), (0.1, 0.12), (0.05, 0.26), (0.07, 0.32), (0.06, 0.32), (0.04, 0.26), (0, 0.2)], 48
    )
    b.mesh("SideboardVase", vases.moved((-w + 0.27, 0.855, 0.9)), m["Marble"])
    b.mesh(
        "SideboardBowl",
        lathe([(0, 0), (0.08, 0), (0.2, 0.1), (0.19, 0.105), (0.07, 0.015), (0, 0.012)], 56).moved(
            (-w + 0.27, 0.855, -0.9)
        ),
        m["Copper"],
    )


def _leaves(count: int, seed: int) -> Mesh:
    rng = np.random.default_rng(seed)
    u, v = np.meshgrid(np.linspace(0, 1, 14), np.linspace(-1, 1, 5), indexing="ij")
    leaves = []
    for _ in range(count):
        length, lean = rng.uniform(0.5, 0.95), rng.uniform(15, 70)
        half = 0.055 * np.sin(np.pi * np.clip(u, 0.02, 1) ** 0.7)
        points = np.stack([v * half, length * u, 0.35 * length * u**2.2 - 0.02 * np.abs(v)], -1)
        leaves.append(surface(points).turned(0, lean).turned(1, rng.uniform(0, 360)))
    return merge(leaves)


def _curtains(b: Builder, m: dict[str, str], columns: int) -> None:
    """On the front wall, in folds: as many triangles as are missing to the paper's count."""
    u, v = np.meshgrid(np.linspace(0, 1, columns + 1), np.linspace(0, 1, 41), indexing="ij")
    for i, x0 in enumerate((-4.2, 1.0)):
        fold = 0.07 * np.sin(2 * np.pi * (17 * u + 0.15 * np.sin(5 * v))) * (0.4 + 0.6 * v)
        points = np.stack([x0 + 3.2 * u, 2.9 - 2.8 * v, DEPTH / 2 - 0.14 + fold], -1)
        b.mesh(f"Curtain{i}", surface(points), m["CurtainLinen" if i else "CurtainVelvet"])


def _lamps(b: Builder, m: dict[str, str]) -> None:
    shade = lathe(
        [(0.24, 0.0), (0.2, 0.12), (0.05, 0.2), (0.03, 0.22), (0.028, 0.215), (0.19, 0.115), (0.232, 0.002)], 48
    )
    for i, z in enumerate((-2.0, 0.0, 2.0)):
        b.mesh(f"Lamp{i}/Shade", shade.moved((0, 1.95, z)), m["LacquerRed"])
        b.mesh(f"Lamp{i}/Cord", tube([(0, 2.16, z), (0, 2.6, z), (0, HEIGHT, z)], 0.006, 8), m["PlasticBlack"])
        b.sphere_light(f"Bulb{i}", 0.05, (0, 2.0, z), 160.0)
    for i, (x, z) in enumerate((x, z) for x in (-2.3, 2.3) for z in (-3.4, 0.0, 3.4)):
        frame = [rounded_box((1.3, 0.04, 0.04), 0.01, 1).moved((x, HEIGHT - 0.02, z + s * 0.32)) for s in (-1, 1)]
        b.mesh(f"Ceiling{i}", merge(frame), m["BrushedSteel"])
        b.rect_light(f"Panel{i}", (1.2, 0.6), (x, HEIGHT - 0.03, z), (x, 0, z), 26.0, (1.0, 0.95, 0.88))


def build(folder: str) -> Scene:
    b = Builder("conference", folder)
    m = {name: b.material(name, make) for name, make in looks.MATERIALS.items()}
    _room(b, m)
    _table(b, m)
    _on_the_table(b, m)
    _furniture(b, m)
    _lamps(b, m)
    _chairs(b, m, 20)
    _curtains(b, m, round((TRIANGLES - b.triangles) / 160))
    b.camera((-3.3, 1.75, 4.9), (0.25, 0.82, -0.6), 16.0)
    return b.finish(maxBounces=16, rouletteBounce=6)
