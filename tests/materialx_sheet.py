#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Renders every surface of MaterialX's documents on the shader ball, and a contact sheet of them.

usage: materialx_sheet.py ASSETS FOLDER [--samples N] [--size N] [--only PART]

ASSETS holds materialx/, usdwg_standardshaderball/ and hdri/ (their sources stand in materialx_sheet.md). FOLDER gets a
picture for each material (those that are there are kept), sheet_1.png ... and report.txt: time and diagnostics of each.
"""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import hdwavefront
import OpenImageIO as oiio
from hdwavefront.mtlx import convert_file
from pxr import Sdf, UsdShade

STAGE = """#usda 1.0
(
    upAxis = "Y"
    metersPerUnit = 0.01
)
def "ball" (
    references = @{assets}/usdwg_standardshaderball/material_surface_geo/subdiv.usda@</shader_ball>
)
{{
}}
def Camera "camera" (
    references = @{assets}/usdwg_standardshaderball/layers/camera.usda@</standard_shader_ball_scene/camera>
)
{{
}}
def Mesh "ground" (apiSchemas = ["MaterialBindingAPI"])
{{
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-60, 0, -60), (-60, 0, 60), (60, 0, 60), (60, 0, -60)]
    texCoord2f[] primvars:st = [(0, 0), (0, 30), (30, 30), (30, 0)] (
        interpolation = "vertex"
    )
    rel material:binding = </tiles>
    uniform token subdivisionScheme = "none"
}}
def Material "tiles"
{{
    token outputs:mtlx:surface.connect = </tiles/surface.outputs:out>
    def Shader "surface"
    {{
        uniform token info:id = "ND_standard_surface_surfaceshader"
        color3f inputs:base_color.connect = </tiles/checker.outputs:out>
        float inputs:specular = 0
        token outputs:out
    }}
    def Shader "checker"
    {{
        uniform token info:id = "ND_checkerboard_color3"
        color3f inputs:color1 = (0.4, 0.4, 0.4)
        color3f inputs:color2 = (0.08, 0.08, 0.08)
        float2 inputs:uvtiling = (1, 1)
        color3f outputs:out
    }}
}}
def DomeLight "dome"
{{
    asset inputs:texture:file = @{assets}/hdri/city.exr@
    token inputs:texture:format = "latlong"
    float inputs:intensity = 1.4
    float xformOp:rotateY = 200
    uniform token[] xformOpOrder = ["xformOp:rotateY"]
}}
def Scope "documents"
{{
}}
"""
COLUMNS, ROWS = 8, 8
LABEL = 12


def surfaces(assets: Path) -> list[tuple[Path, str]]:
    """(document, material) of everything that has a surface, examples first."""
    found = []
    for file in sorted((assets / "materialx/resources/Materials").rglob("*.mtlx")):
        layer = convert_file(str(file))
        for material in layer.GetPrimAtPath("/MaterialX/Materials").nameChildren:
            if "outputs:mtlx:surface" in material.attributes:
                found.append((file, material.name))
    return found


def render(stage_file: Path, file: Path, material: str, picture: Path, options: argparse.Namespace) -> str:
    """A line of the report."""
    begin = time.perf_counter()
    session = picture.with_suffix(".usda")
    layer = Sdf.Layer.CreateNew(str(session))
    prim = Sdf.CreatePrimInLayer(layer, "/documents/it")
    prim.specifier = Sdf.SpecifierDef
    prim.referenceList.explicitItems = [Sdf.Reference(str(file), f"/MaterialX/Materials/{material}")]
    ball = Sdf.CreatePrimInLayer(layer, "/ball/material_surface")
    ball.SetInfo("apiSchemas", Sdf.TokenListOp.Create(prependedItems=["MaterialBindingAPI"]))
    Sdf.RelationshipSpec(ball, "material:binding", False).targetPathList.explicitItems = ["/documents/it"]
    layer.Save()
    scene = hdwavefront.open(
        str(stage_file), width=options.size, height=options.size, session_layer=str(session), complexity="medium"
    )
    assert UsdShade.Material(scene.stage.GetPrimAtPath("/documents/it"))
    scene.start(samples=options.samples, maxBounces=8)
    scene.wait()
    scene.save(str(picture))
    session.unlink()
    said = "; ".join(sorted({f"{d.code}: {d.message}" for d in scene.diagnostics}))
    return f"{picture.stem}: {time.perf_counter() - begin:.1f} s {said}"


def sheet(pictures: list[Path], out: Path, size: int) -> None:
    step = size + LABEL
    rows = (len(pictures) + COLUMNS - 1) // COLUMNS
    page = oiio.ImageBuf(oiio.ImageSpec(COLUMNS * size, rows * step, 3, "uint8"))
    oiio.ImageBufAlgo.fill(page, (0.1, 0.1, 0.1))
    for i, picture in enumerate(pictures):
        x, y = i % COLUMNS * size, i // COLUMNS * step
        oiio.ImageBufAlgo.paste(
            page, x, y + LABEL, 0, 0, oiio.ImageBufAlgo.channels(oiio.ImageBuf(str(picture)), (0, 1, 2))
        )
        oiio.ImageBufAlgo.render_text(page, x + 2, y + LABEL - 3, picture.stem[-(size // 6) :], 9, "", (1, 1, 1))
    page.write(str(out))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("assets", type=Path)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--samples", type=int, default=48)
    parser.add_argument("--size", type=int, default=112)
    parser.add_argument("--only", default="")
    options: Any = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    stage_file = options.folder / "stage.usda"
    stage_file.write_text(STAGE.format(assets=options.assets.resolve()))
    pictures = []
    with open(options.folder / "report.txt", "a", encoding="utf-8") as report:
        for file, material in surfaces(options.assets.resolve()):
            picture = options.folder / f"{file.stem}.{material}.png"
            pictures.append(picture)
            if options.only in picture.stem and not picture.exists():
                line = render(stage_file, file, material, picture, options)
                print(line, flush=True)
                report.write(line + "\n")
                report.flush()
    pictures = [p for p in pictures if p.exists()]
    for page, first in enumerate(range(0, len(pictures), COLUMNS * ROWS)):
        sheet(pictures[first : first + COLUMNS * ROWS], options.folder / f"sheet_{page + 1}.png", options.size)


if __name__ == "__main__":
    main()
