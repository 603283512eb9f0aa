# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Time at equal noise: 1 / (relMSE x CPU seconds), ours and a peer's, of the same scene.

Each renderer's noise is that of its own pictures, which differ where the translation does: two pictures of different
random numbers differ by twice the variance, so no reference is needed. relMSE = mean of variance / (mean² + 0.01).
"""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ...errors import HdWavefrontError
from ..scenes.builder import Scene
from . import flat

PEERS = ("mitsuba", "cycles", "embree")
_HERE = Path(__file__).resolve().parent
_LONGEST = 1800.0  # seconds of a peer, which may hang
_OUTLIERS = 0.001  # share of pixels, the noisiest, that do not count: fireflies are decided by chance


class OutOfTime(Exception):  # noqa: N818 - nothing is wrong: the time that was given is over
    """Says what was not ready by then."""


def relative_mse(first: npt.NDArray[np.float32], second: npt.NDArray[np.float32]) -> float:
    """Of one picture, by two of them; rgb."""
    a, b = first[..., :3].astype(np.float64), second[..., :3].astype(np.float64)
    mean = ((a + b) / 2).mean(-1)
    error = ((a - b) ** 2).mean(-1) / 2 / (mean**2 + 0.01)
    kept = np.sort(error.ravel())[: max(1, int(error.size * (1 - _OUTLIERS)))]
    return float(kept.mean())


def _default(token: str) -> Any:
    """Of a render setting."""
    from ... import _core

    return next(setting["default"] for setting in _core.render_settings() if setting["token"] == token)


def _own(scene: Scene, width: int, samples: int, device: str, deadline: float) -> dict[str, Any]:
    from ...api import Render

    def wait() -> None:
        if not render.wait(max(0.0, deadline - time.monotonic())):
            render.stop()
            raise OutOfTime("our own picture was not ready when its time was over")

    render = Render(
        scene.path, width=width, device=device, settings={**scene.settings, "samples": 1}, dome_visible=True
    )
    render.start()
    wait()
    pictures, seconds, wall_seconds = [], 0.0, 0.0
    for seed in (1, 2):
        wall, cpu = time.perf_counter(), time.process_time()
        render.start(samples=samples, seed=seed)
        wait()
        seconds += time.process_time() - cpu
        wall_seconds += time.perf_counter() - wall
        pictures.append(render.map("color"))
    result = _efficiency(pictures, seconds / 2, wall_seconds / 2, samples)
    result["size"] = render.size
    return result


def _efficiency(pictures: list[Any], cpu: float, wall: float, samples: int) -> dict[str, Any]:
    noise = relative_mse(pictures[0], pictures[1])
    brightness = float(np.mean([p[..., :3] for p in pictures]))
    if noise <= 0 or cpu <= 0:
        raise HdWavefrontError(f"a picture without noise or time cannot be compared (mean {brightness:.3g})")
    return {
        "relMse": noise,
        "cpuSeconds": cpu,
        "wallSeconds": wall,
        "samples": samples,
        "brightness": brightness,
        "efficiency": 1 / (noise * cpu),
    }


def why_absent(peer: str) -> str:
    """Empty where the peer is there. Cycles may stand in another Python: $HDWAVEFRONT_BPY_PYTHON."""
    if peer == "cycles":
        python = os.environ.get("HDWAVEFRONT_BPY_PYTHON", sys.executable)
        try:
            found = subprocess.run([python, "-c", "import bpy"], capture_output=True, timeout=120, check=False)
        except (OSError, subprocess.TimeoutExpired) as error:
            return f"$HDWAVEFRONT_BPY_PYTHON does not start: {error}"
        return "" if found.returncode == 0 else "bpy is not installed here, nor where $HDWAVEFRONT_BPY_PYTHON says"
    module = {"mitsuba": "mitsuba", "embree": "embreex"}[peer]
    return "" if importlib.util.find_spec(module) else f"the Python package {module} is not installed"


def _run(peer: str, path: str, options: dict[str, Any], limit: float) -> list[dict[str, Any]]:
    python = os.environ.get("HDWAVEFRONT_BPY_PYTHON", sys.executable) if peer == "cycles" else sys.executable
    command = [python, str(_HERE / f"{peer}_peer.py"), path, json.dumps(options)]
    # Embree's peer is our own, too: rays are compared by one thread of each.
    own = {"PYTHONPATH": os.pathsep.join(p for p in sys.path if p), "LP_NUM_THREADS": "1"} if peer == "embree" else {}
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=limit, check=False, env={**os.environ, **own}
        )
    except subprocess.TimeoutExpired:
        raise OutOfTime(f"{peer} did not end within {limit:.0f} s") from None
    if done.returncode != 0:
        said = [line for line in done.stderr.splitlines() if line.strip()]
        raise HdWavefrontError(f"{peer} failed: {said[-1] if said else done.returncode}")
    return [json.loads(line) for line in done.stdout.splitlines() if line.startswith('{"event"')]


def compare_rays(scene: Scene, folder: str, width: int, turns: int, device: str, limit: float) -> list[dict[str, Any]]:
    """A row for each kind of ray: Mrays/s of a core, ours and Embree's, and the median of their ratios in turns.
    OutOfTime after `limit` seconds."""
    options = {"width": width, "height": width * 9 // 16, "turns": turns, "device": device}
    said = _run("embree", flat.write(scene.path, folder), options, min(limit, _LONGEST))
    return [{"scene": scene.name, "peer": "embree", **line} for line in said if line["event"] == "rays"]


def compare(
    peer: str, scene: Scene, folder: str, width: int, samples: int, device: str, variant: str, limit: float
) -> dict[str, Any]:
    """Both on the scene. OutOfTime after `limit` seconds."""
    deadline = time.monotonic() + limit
    bounces = int(scene.settings.get("maxBounces", 8))
    # Russian roulette is how a renderer gets to the picture, not what it shows: each has its own. (The scenes keep it
    # from the first bounces, so that paths are as long as the paper's.)
    settings = {**scene.settings, "rouletteBounce": _default("rouletteBounce")}
    own_scene = Scene(scene.name, scene.path, 0, 0, 0, 0, 0, {**settings, "maxBounces": bounces})
    ours = _own(own_scene, width, samples, device, deadline)
    options = {
        "width": ours["size"][0],
        "height": ours["size"][1],
        "samples": samples,
        "variant": variant,
        "maxBounces": bounces,
    }
    path = flat.write(scene.path, folder)
    said = _run(peer, path, options, min(max(0.0, deadline - time.monotonic()), _LONGEST))
    result: dict[str, Any] = {"scene": scene.name, "peer": peer, "variant": variant, "ours": ours}
    pictures = [line for line in said if line["event"] == "picture"]
    cpu, wall = (float(np.mean([p[key] for p in pictures])) for key in ("cpu", "wall"))
    images = [np.load(p["file"]) for p in pictures]
    theirs = _efficiency(images, cpu, wall, samples)
    return {**result, "theirs": theirs, "ratio": ours["efficiency"] / theirs["efficiency"]}
