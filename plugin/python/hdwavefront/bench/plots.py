# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Pictures of the results, PNG and SVG. Needs matplotlib, the extra [bench]."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any

from .measure import GROUPS
from .sweeps import SWEEPS

_COLORS = ("#4878a8", "#8fb4d4", "#d98c40", "#6a9a58")


def available() -> bool:
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        return False
    return True


def _save(figure: Any, folder: str, name: str) -> list[str]:
    paths = [os.path.join(folder, f"{name}.{ending}") for ending in ("png", "svg")]
    for path in paths:
        figure.savefig(path, dpi=130, bbox_inches="tight", metadata={"Date": None} if path.endswith("svg") else None)
    return paths


def draw(folder: str, result: Mapping[str, Any]) -> list[str]:
    """Writes a plot of the scenes and one of each sweep into the folder; gives the files."""
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot

    os.makedirs(folder, exist_ok=True)
    written = []
    if result["scenes"]:
        figure, axes = pyplot.subplots(1, 2, figsize=(10, 3.6))
        _draw_rates(axes[0], result["scenes"])
        _draw_shares(axes[1], result["scenes"])
        figure.suptitle(f"{result['machine']['device']}, {result['machine']['driver']}", fontsize=9)
        written += _save(figure, folder, "scenes")
        pyplot.close(figure)
    for name, rows in result["sweeps"].items():
        if not rows:
            continue
        figure, axis = pyplot.subplots(figsize=(5.5, 3.4))
        _draw_sweep(axis, name, rows)
        written += _save(figure, folder, name)
        pyplot.close(figure)
    return written


def _draw_rates(axis: Any, scenes: Sequence[Mapping[str, Any]]) -> None:
    for i, mode in enumerate(("megakernel", "wavefront")):
        rates = [(s[mode] or {}).get("mpathsPerSecond", 0) for s in scenes]
        errors = [(s[mode] or {}).get("mpathsPerSecondSpread", 0) for s in scenes]
        places = [k + 0.4 * i - 0.2 for k in range(len(scenes))]
        axis.bar(places, rates, 0.38, yerr=errors, label=mode, color=_COLORS[2 if i == 0 else 0])
    axis.set_xticks(range(len(scenes)), [s["name"] for s in scenes])
    axis.set_ylabel("Mpaths/s")
    axis.legend(frameon=False)


def _draw_shares(axis: Any, scenes: Sequence[Mapping[str, Any]]) -> None:
    left = [0.0] * len(scenes)
    for group, color in zip(GROUPS, _COLORS, strict=True):
        shares = [100 * s["wavefront"]["share"][group] for s in scenes]
        axis.barh(range(len(scenes)), shares, left=left, color=color, label=group)
        left = [a + b for a, b in zip(left, shares, strict=True)]
    axis.set_yticks(range(len(scenes)), [s["name"] for s in scenes])
    axis.set_xlabel("% of the kernels' time")
    axis.invert_yaxis()
    axis.legend(frameon=False, ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize=8)


def _draw_sweep(axis: Any, name: str, rows: Sequence[Mapping[str, Any]]) -> None:
    sweep = SWEEPS[name]
    values = [sweep.values(row) for row in rows]
    axis.plot(range(len(rows)), values, "o-", color=_COLORS[0])
    axis.set_xticks(range(len(rows)), [row["name"] for row in rows], rotation=30, ha="right", fontsize=8)
    axis.set_ylim(0, 1.15 * max(values))
    axis.set_ylabel(sweep.values_title)
    axis.set_xlabel(sweep.axis)
