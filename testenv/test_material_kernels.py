# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Kernels of a whole stage: how many, how they come, what they cost, and what `hdwavefront explain` says of them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from many_materials import TOPOLOGIES, stage_text


def run(command: str, stage: Path, *arguments: str, caches: Path | None = None) -> str:
    """Standard output of a command, with caches in a folder of the test's own where one is given."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(path for path in sys.path if path)}
    if caches:
        environment.pop("MESA_SHADER_CACHE_DISABLE", None)
        for name, folder in (("MESA_SHADER_CACHE_DIR", "mesa"), ("HDWAVEFRONT_CACHE_DIR", "own")):
            (caches / folder).mkdir(parents=True, exist_ok=True)
            environment[name] = str(caches / folder)
        environment["MESA_DISK_CACHE_MULTI_FILE"] = "1"  # an entry, a file
    line = [sys.executable, "-m", "hdwavefront", command, str(stage), *arguments]
    ended = subprocess.run(line, env=environment, capture_output=True, text=True, timeout=300)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


def explain(stage: Path, *arguments: str, caches: Path | None = None) -> str:
    return run("explain", stage, *arguments, caches=caches)


def test_500_materials_of_20_topologies_make_20_kernels_and_compile_once(tmp_path):
    stage = tmp_path / "many.usda"
    stage.write_text(stage_text(), encoding="utf-8")
    cold: dict[str, Any] = json.loads(
        explain(stage, "--json", "--samples", "1", "-w", "150", caches=tmp_path / "caches")
    )
    kernels = cold["kernels"]
    assert TOPOLOGIES == len(kernels) == 20
    assert [len(kernel["materials"]) for kernel in kernels] == [25] * 20
    assert all(kernel["state"] == "ready" and kernel["paths"] > 0 for kernel in kernels)
    assert not any(kernel["codeFromCache"] for kernel in kernels)
    # No order of the two: where commit takes as long as the compilers (memory that the system must find first), the
    # picture begins last. That paths run while a kernel is being made is what
    # tests/wavefront/scheduler/kernel_compile_test.cpp sees, with a compiler that it holds back.
    assert cold["firstPathSeconds"] > 0 and cold["kernelsReadySeconds"] > 0
    # The next process finds SPIR-V and the driver's code.
    warm = json.loads(explain(stage, "--json", "--samples", "1", "-w", "150", caches=tmp_path / "caches"))
    assert all(kernel["codeFromCache"] for kernel in warm["kernels"])
    # 10.5 s cold beside a test run on two cores; times are printed, not asserted: the machine's load is not known.
    print(f"kernels ready after {cold['kernelsReadySeconds']:.1f} s cold, {warm['kernelsReadySeconds']:.1f} s warm")


def test_lavapipe_compiles_every_kernel_once(tmp_path):
    """The machine code made in the background serves the render, and scenes of all sizes.

    Every compilation leaves an entry in Mesa's cache; what the driver compiles for are the formats and sizes of buffers
    (vulkan/buffer.cpp, SpareBytes).
    """
    from hdwavefront import _core

    if "llvmpipe" not in _core.list_devices()[0]["name"]:
        pytest.skip("not lavapipe")
    stage, caches, stats = tmp_path / "few.usda", tmp_path / "caches", tmp_path / "stats.json"
    made = []
    lens = 'token projection = "perspective"\n        float fStop = 0.1\n        float focusDistance = 20'
    # Of three topologies; of no other, in another size; with another camera: drivers may compile for values, too.
    for materials, width, camera in (([15, 7, 35], 40, ""), ([15, 7, 35, 75, 115], 150, ""), ([15, 7, 35], 40, lens)):
        text = stage_text(materials, 3)
        stage.write_text(text.replace('token projection = "orthographic"', camera) if camera else text, encoding="utf-8")
        options = ("-w", str(width), "--samples", "1", "--stats", str(stats))
        run("record", stage, str(tmp_path / "image.exr"), *options, caches=caches)
        made.append(sum(1 for f in (caches / "mesa").rglob("*") if f.is_file() and f.name != "index"))
    dispatched = [k["name"] for k in json.loads(stats.read_text())["kernels"] if k["firstDispatchMilliseconds"] > 0]
    assert sum(name.startswith("material:") for name in dispatched) >= 3
    assert made == [len(dispatched)] * 3


def test_explain_one_material(tmp_path):
    stage = tmp_path / "few.usda"
    stage.write_text(stage_text([15, 7, 35], 3), encoding="utf-8")
    text = explain(stage, "m15", "--samples", "2", "-w", "60")  # standard_surface under a fractal
    for part in (
        "/World/Materials/m15",
        "Network (mtlx terminal), 2 nodes",
        "ND_fractal3d_float",
        "specular_roughness <- /World/Materials/m15/pattern.out",
        "Closure tree",
        "layer: the first over the second",
        "(left out)",
        "Kernel ",
        "ns a path",
        "driver: ",  # what it tells of its code, or that it tells nothing: lavapipe
        "shared with 1 other materials: /World/Materials/m35",
        "GLSL of surface",
        "void closureMake(",
    ):
        assert part in text, part
    facts = json.loads(explain(stage, "/World/Materials/m7", "--json", "--samples", "0"))
    assert {"surface", "emission"} == set(facts["kernel"]["glsl"])
    assert facts["kernel"]["paths"] == 0
    assert facts["context"] == "mtlx"
    assert facts["kernel"]["materials"] == ["/World/Materials/m7"]


def test_material_cost_shows_where_time_goes_and_changes_nothing_else(tmp_path):
    import hdwavefront

    stage = tmp_path / "few.usda"
    stage.write_text(stage_text([0, 2, 15, 20], 2), encoding="utf-8")

    def images(*aovs: str) -> tuple[dict[str, Any], dict[str, Any]]:
        render = hdwavefront.open(str(stage), width=100, aovs=aovs, settings={"samples": 16})
        render.start()
        assert render.wait(300)
        return {aov: render.delegate.map(aov) for aov in ("color", "primId", *aovs[1:])}, render.stats()

    plain, _ = images("primId")
    costed, stats = images("primId", "materialCost")
    assert np.array_equal(plain["color"], costed["color"])
    cost = costed["materialCost"][..., 0]
    empty = costed["primId"][..., 0] < 0
    seen = ~empty & (cost > 0)
    assert seen.sum() > 0.9 * (~empty).sum()
    assert cost[seen].mean() > 20 * cost[empty].mean()
    # All of it together is what the kernels took, as far as a mean over a run can say.
    nanoseconds = sum(kernel["milliseconds"] for kernel in stats["kernelSources"]) * 1e6
    assert 0.4 < cost.sum() * 16 / nanoseconds < 2.5
    shares = [kernel["share"] for kernel in stats["kernelSources"]]
    assert 0 < sum(shares) < 1
