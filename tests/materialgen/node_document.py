# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Writes materialgen/NODES.md: which pattern nodes work. A test compares it with what is written there."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
DOCUMENT = ROOT / "materialgen" / "NODES.md"

HEAD = """<!-- SPDX-License-Identifier: Apache-2.0 -->
# Pattern nodes
Every node of MaterialX {version}'s libraries whose outputs are values. "yes": all its variants are compiled, run on the
device and compared with a reference of their own by `tests/materialgen/test_nodes.py`, with inputs that vary over the
surface (the kernel computes them) and with authored ones (the CPU does); "partly": but for what the remark names. Written
by `tests/materialgen/node_document.py`; the test fails where this list is not what the library has and the tests cover.

![Thirty pattern nodes](../resources/pictures/pattern_nodes.png)

Rendered on lavapipe, 8 samples, row by row: noise2d, fractal2d, noise3d, fractal3d, cellnoise2d, worleynoise2d;
worleynoise2d's cells, worleynoise3d, unifiednoise2d (fractal), randomcolor, flake2d (normals), checkerboard; line, circle,
cloverleaf, hexagon, grid, crosshatch; tiledcircles, tiledcloverleafs, tiledhexagons, ramplr, ramptb, ramp4; ramp (radial),
splitlr, tiledimage, hextiledimage, image, heighttonormal of worleynoise2d. Negative colours are black.

"""

# What a reader should know, by category.
NOTES = {
    "blur": "passes its input through, as MaterialX's own graph does",
    "heighttonormal": "heights are compared at two points a ray cone's width (at least a thousandth of an edge) away",
    "bump": "see heighttonormal",
    "splitlr": "the step is as soft as the ray cone is wide",
    "splittb": "the step is as soft as the ray cone is wide",
    "switch": "0 where `which` is 10 or more, as in MaterialX's graph",
    "frame": "render setting `frame`; hosts set it to the time code that they show. In displacement always 1, with a diagnostic",
    "time": "render setting `time`, seconds; hosts set it. In displacement always 0, with a diagnostic",
    "geomcolor": "primvar `displayColor`; `index` n > 0: `displayColor<n>`",
    "texcoord": "primvar `st`; `index` n > 0: `st<n>`",
    "position": "`model` is `object`",
    "tangent": "along `st`",
    "bitangent": "along `st`",
}


# Inputs that no node reads, which say so where they would count; a test in generator_test.cpp.
UNREAD = ("layer", "layerx", "framerange")


def document() -> str:
    import MaterialX as mx
    from node_cases import TEXT_READERS
    from node_harness import pattern_definitions

    rows: dict[tuple[str, str], list[Any]] = {}
    for definition in pattern_definitions():
        rows.setdefault((definition.getNodeGroup(), definition.getNodeString()), []).append(definition)
    some = 0
    text = HEAD.format(version=mx.getVersionString())
    text += "| group | node | variants | works | remarks |\n|---|---|---|---|---|\n"
    for (group, node), definitions in sorted(rows.items()):
        silent = sorted(d.getName() for d in definitions if d.getName() in TEXT_READERS)
        unread = [name for name in UNREAD if group.startswith("texture") and definitions[0].getActiveInput(name)]
        some += len(definitions) if unread else 0
        works = "yes" if not silent and not unread else "no" if len(silent) == len(definitions) else "partly"
        remarks = [NOTES[node]] if node in NOTES else []
        if silent:
            names = ", ".join(f"`{name}`" for name in silent)
            remarks.append(f"{names}: a kernel reads no text primvars; the default, and `material-unsupported-feature`")
        if unread:
            what = "image sequences" if unread == ["framerange"] else "layers and image sequences"
            remarks.append(f"{what} are not read, and `material-unsupported-feature` says so")
        text += f"| {group} | {node} | {len(definitions)} | {works} | {'; '.join(remarks)} |\n"
    total = sum(len(d) for d in rows.values())
    return text + f"\n{total} definitions of {len(rows)} nodes; {total - len(TEXT_READERS)} work, {some} of them partly.\n"


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT / "tests"))
    DOCUMENT.write_text(document())
