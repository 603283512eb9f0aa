# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The megakernel is the oracle of the wavefront loop: the same kernels in another order, so every bit of every AOV must
be the same. The scenes are those of the other tests that have work for every stage."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from harness import FOLDER, render
from test_assets import assets, folder_of  # noqa: F401 - a fixture

AOVS = ["albedo", "normal", "Neye", "depth", "cameraDepth", "primId", "instanceId", "elementId", "sampleCount"]

CASES: dict[str, dict[str, Any]] = {
    "Material.OpacityShadow": {"camera": "/c_quarter"},  # opacity entries, on extension and on shadow rays
    "Mitsuba.Cornell": {},  # emissive triangles
    "Mitsuba.Lights": {},  # many lights
    "Mitsuba.Absorption": {},  # media
    "Instance.PointInstancer": {"camera": "/cam"},
    "Aov.Primvars": {"camera": "/cam", "aovs": ["primvars:tint", "primvars:st"]},
}
ASSETS: dict[str, dict[str, Any]] = {
    "cornellbox/mtlx-usdshade/cornell-box.usda": {},
    "wrappers/shaderball_usdpreview.usda": {"complexity": "low"},
}


def compare(scene: Path, options: dict[str, Any]) -> None:
    options = {"width": 48, "samples": 4, "maxBounces": 6, **options}
    options["aovs"] = [*AOVS, *options.get("aovs", ())]
    wave, _ = render(scene, options)
    mega, _ = render(scene, {**options, "executionMode": "megakernel"})
    assert (wave.stats["executionMode"], mega.stats["executionMode"]) == ("wavefront", "megakernel")
    for count in ("paths", "segments", "shadowRays"):
        assert wave.stats[count] == mega.stats[count] > 0 or count == "shadowRays", count
    assert np.ptp(wave.aovs["color"]) > 0, "a picture of nothing proves nothing"
    for aov, image in wave.aovs.items():
        assert np.array_equal(image.view(np.uint32), mega.aovs[aov].view(np.uint32)), aov


@pytest.mark.parametrize("name", CASES)
def test_every_bit_is_the_same(name: str) -> None:
    compare(FOLDER / name / "scene.usda", CASES[name])


@pytest.mark.parametrize("name", ASSETS)
def test_every_bit_is_the_same_on_assets(name: str, assets: Path) -> None:  # noqa: F811
    folder_of(assets, name.split("/")[0])
    compare(assets / name, ASSETS[name])
