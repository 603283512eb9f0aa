# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Third-party stages that say the same thing twice, once in MaterialX: both must look equal within their noise.

OpenUSD's testUsdImagingGLMaterialXvsNative: UsdPreviewSurface by .mtlx reference, and native. Two pairs differ by
what their authors wrote; the native side then gets MaterialX's values:
- clearcoat: the coat's roughness of the last three spheres is 1 there, 0.01 here;
- normalMap: the plane is white there, dark here.
The Cornell box: its materials by .mtlx reference, and as networks of UsdShade.

Each side is rendered with seeds of its own, so that equal pictures are two estimates of one expectation: the difference
of each block of pixels is held against the standard error that the seeds show.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_assets import assets, folder_of  # noqa: F401 (a fixture)

SEEDS = 8
WIDTH, HEIGHT, BLOCK = 96, 72, 6
NATIVE = "openusd_imaging/testUsdImagingGLMaterialXvsNative/"

COATS = "\n".join(
    f"""    over "USD_Clearcoat_{i:02}" {{
        over "Surface" {{
            float inputs:clearcoatRoughness = 1
        }}
    }}"""
    for i in (6, 7, 8)
)
SAME_VALUES = {
    "Clearcoat": f'over "Materials" {{\n{COATS}\n}}\n',
    "NormalMap": """over "Materials" {
    over "Usd_PreviewSurface" {
        over "Usd_PreviewSurface" {
            color3f inputs:diffuseColor = (1, 1, 1)
        }
    }
}
""",
}
NAMES = ["Clearcoat", "Default", "Emissive", "Metallic", "NormalMap", "Opacity", "Workflow"]
PAIRS = {
    **{n: (f"{NATIVE}materialX{n[0].lower()}{n[1:]}.usda", f"{NATIVE}native{n}.usda") for n in NAMES},
    "CornellBox": ("cornellbox/mtlx-ref/cornell-box.usda", "cornellbox/mtlx-usdshade/cornell-box.usda"),
}


def pictures(stage: Path, first_seed: int, **options: Any) -> np.ndarray:
    """(seeds, blocks, channels): means of the blocks of pixels."""
    import hdwavefront

    render = hdwavefront.open(str(stage), width=WIDTH, height=HEIGHT, complexity="high", **options)
    found = []
    for seed in range(SEEDS):
        render.start(samples=8, seed=first_seed + seed)
        assert render.wait(200), "the render does not end"
        stats = render.stats()
        assert stats["validationMessages"] == 0 and stats["errorFlags"] == 0
        blocks = render.map().reshape(HEIGHT // BLOCK, BLOCK, WIDTH // BLOCK, BLOCK, 4)
        found.append(blocks.mean(axis=(1, 3)).reshape(-1, 4))
    assert not {d.code for d in render.diagnostics} & {"material-missing", "mtlx-reference-unsupported"}
    return np.stack(found).astype(np.float64)


@pytest.mark.parametrize("name", PAIRS)
def test_materialx_and_native_look_equal(assets, tmp_path, name):  # noqa: F811
    folder_of(assets, "openusd_imaging")
    first, second = (assets / path for path in PAIRS[name])
    session = tmp_path / "same.usda"
    session.write_text("#usda 1.0\n" + SAME_VALUES.get(name, ""))
    a = pictures(first, 1)
    b = pictures(second, 1001, session_layer=str(session))
    assert a[..., :3].mean() > 0.01, "there is nothing to see"
    error = np.sqrt((a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / SEEDS)
    floor = 1e-3 * max(a.mean(), b.mean())  # what no eye sees; also where nothing varies
    z = (a.mean(axis=0) - b.mean(axis=0)) / np.maximum(error, floor)
    # Of some 800 blocks and channels; Student's t with 14 degrees of freedom passes 7 once in 300,000.
    assert np.abs(z).max() < 7, f"a block differs by {np.abs(z).max():.1f} standard errors"
    seen = error > floor
    # The square of Student's t has the mean 14 / 12; a difference everywhere raises it.
    assert (z[seen] ** 2).mean() < 1.6, f"blocks differ by {np.sqrt((z[seen] ** 2).mean()):.2f} standard errors"
