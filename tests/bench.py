# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What `./run bench` starts: renders stages with `hdwavefront record --stats` and prints where the time went.

No stage: a scene of its own, 8 x 8 spheres of four materials on a plane under a rect light and a dome. Each stage is
rendered once with one sample first, so that compiled shaders are in the driver's cache and what is timed is rendering.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

MATERIALS = {
    "Clay": "color3f inputs:diffuseColor = (0.7, 0.3, 0.2)\n float inputs:roughness = 0.9",
    "Plastic": "color3f inputs:diffuseColor = (0.1, 0.3, 0.7)\n float inputs:roughness = 0.2",
    "Metal": "color3f inputs:diffuseColor = (0.9, 0.8, 0.5)\n float inputs:metallic = 1\n float inputs:roughness = 0.1",
    "Coated": "color3f inputs:diffuseColor = (0.1, 0.5, 0.2)\n float inputs:clearcoat = 1\n"
    " float inputs:clearcoatRoughness = 0.05",
}


def own_scene(path: Path) -> None:
    materials = "".join(
        f"""
    def Material "{name}" {{
        token outputs:surface.connect = </World/Looks/{name}/Surface.outputs:surface>
        def Shader "Surface" {{
            uniform token info:id = "UsdPreviewSurface"
            {inputs}
            token outputs:surface
        }}
    }}"""
        for name, inputs in MATERIALS.items()
    )
    names = list(MATERIALS)
    spheres = "".join(
        f"""
    def Sphere "S{x}{y}" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
        double radius = 0.45
        double3 xformOp:translate = ({x - 3.5}, 0.45, {y - 3.5})
        uniform token[] xformOpOrder = ["xformOp:translate"]
        rel material:binding = </World/Looks/{names[(x + 3 * y) % len(names)]}>
    }}"""
        for x in range(8)
        for y in range(8)
    )
    path.write_text(f"""#usda 1.0
(
    defaultPrim = "World"
    upAxis = "Y"
    metersPerUnit = 1
)
def Xform "World" {{
    def Scope "Looks" {{{materials}
    }}{spheres}
    def Mesh "Floor" (prepend apiSchemas = ["MaterialBindingAPI"]) {{
        int[] faceVertexCounts = [4]
        int[] faceVertexIndices = [0, 1, 2, 3]
        point3f[] points = [(-20, 0, 20), (20, 0, 20), (20, 0, -20), (-20, 0, -20)]
        uniform token subdivisionScheme = "none"
        rel material:binding = </World/Looks/Clay>
    }}
    def RectLight "Key" {{
        float inputs:intensity = 40
        float inputs:width = 4
        float inputs:height = 4
        double3 xformOp:translate = (0, 8, 0)
        float xformOp:rotateX = -90
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateX"]
    }}
    def DomeLight "Sky" {{
        float inputs:intensity = 0.4
    }}
    def Camera "Camera" {{
        float focalLength = 30
        double3 xformOp:translate = (0, 5, 10)
        float xformOp:rotateX = -25
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateX"]
    }}
}}
""")


def record(stage: Path, samples: int, options: argparse.Namespace, folder: Path) -> dict[str, Any]:
    stats = folder / "stats.json"
    command = [
        str(Path(sys.executable).with_name("hdwavefront")),
        *("record", str(stage), str(folder / "image.exr")),
        *("--samples", str(samples), "--imageWidth", str(options.width), "--stats", str(stats)),
        *options.record,
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\nfailed:\n{done.stdout}{done.stderr}")
    return dict(json.loads(stats.read_text()))


def report(stage: Path, stats: dict[str, Any]) -> None:
    seconds = stats["renderSeconds"]
    rays = stats["extensionRays"] + stats["shadowRays"]
    print(f"\n{stage.name}: {stats['width']} x {stats['height']}, {stats['settings']['samples']} samples")
    print(
        f"  {seconds:.2f} s rendering, {stats['seconds']['total']:.2f} s in all; "
        f"{stats['paths'] / seconds / 1e6:.3f} Mpaths/s, {rays / seconds / 1e6:.3f} Mrays/s, "
        f"{stats['segments'] / max(stats['paths'], 1):.2f} segments a path; "
        f"{stats['hostPeakMemoryBytes'] / 2**20:.0f} MiB"
    )
    kernels = sorted(stats["kernels"], key=lambda kernel: -kernel["milliseconds"])
    total = sum(kernel["milliseconds"] for kernel in kernels) or 1.0
    print(f"  {'kernel':60} {'ms':>10} {'share':>6} {'items':>12} {'ns/item':>8} {'compile ms':>10}")
    for kernel in kernels:
        each = f"{kernel['milliseconds'] * 1e6 / kernel['items']:8.0f}" if kernel["items"] else " " * 8
        compiled = kernel["createMilliseconds"] + kernel["firstDispatchMilliseconds"]
        print(
            f"  {kernel['name'][:60]:60} {kernel['milliseconds']:10.1f} {kernel['milliseconds'] / total:6.1%} "
            f"{kernel['items']:12} {each} {compiled:10.0f}"
        )


def main() -> int:
    parser = argparse.ArgumentParser(prog="./run bench", description=__doc__.splitlines()[0])
    parser.add_argument("stages", nargs="*", type=Path, help="USD stages; none: a scene of its own")
    parser.add_argument("--samples", type=int, default=16, help="samples a pixel (default: %(default)s)")
    parser.add_argument("--width", type=int, default=480, help="image width (default: %(default)s)")
    parser.add_argument("--repeat", type=int, default=1, help="renders of each stage; the fastest is shown")
    parser.add_argument("--json", type=Path, help="also write the statistics of all stages to this file")
    parser.add_argument("--record", nargs=argparse.REMAINDER, default=[], help="what follows goes to `record`")
    options = parser.parse_args()
    results = {}
    with tempfile.TemporaryDirectory(prefix="hdwavefront-bench-") as name:
        folder = Path(name)
        if not options.stages:
            options.stages = [folder / "spheres.usda"]
            own_scene(options.stages[0])
        for stage in options.stages:
            record(stage, 1, options, folder)
            runs = [record(stage, options.samples, options, folder) for _ in range(max(options.repeat, 1))]
            results[str(stage.name)] = min(runs, key=lambda stats: stats["renderSeconds"])
            report(stage, results[str(stage.name)])
    if options.json:
        options.json.write_text(json.dumps(results, indent=2) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
