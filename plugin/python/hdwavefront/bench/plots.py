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
        compared = any(row["megakernel"] for row in rows)
        figure, axes = pyplot.subplots(1, 2 if compared else 1, figsize=(10 if compared else 5.5, 3.4), squeeze=False)
        _draw_sweep(axes[0][0], name, rows)
        if compared:
            _draw_compiling(axes[0][1], name, rows)
        written += _save(figure, folder, name)
        pyplot.close(figure)
    if result["peers"]:
        figure, axis = pyplot.subplots(figsize=(6.5, 0.9 + 0.35 * len(result["peers"])))
        _draw_peers(axis, result["peers"])
        written += _save(figure, folder, "peers")
        pyplot.close(figure)
    return written


_MODES = {"megakernel": _COLORS[2], "wavefront": _COLORS[0]}


def _draw_rates(axis: Any, scenes: Sequence[Mapping[str, Any]]) -> None:
    """Bars side by side; where a mode was not measured, there is none, and no label where it was nowhere."""
    modes = [mode for mode in _MODES if any(s[mode] for s in scenes)]
    for i, mode in enumerate(modes):
        there = [(k + 0.4 * (i - (len(modes) - 1) / 2), s[mode]) for k, s in enumerate(scenes) if s[mode]]
        rates = [r["mpathsPerSecond"] for _, r in there]
        errors = [r["mpathsPerSecondSpread"] for _, r in there]
        axis.bar([place for place, _ in there], rates, 0.38, yerr=errors, label=mode, color=_MODES[mode])
    axis.set_xticks(range(len(scenes)), [s["name"] for s in scenes])
    axis.set_xlim(-0.6, len(scenes) - 0.4)
    axis.set_ylabel("Mpaths/s")
    axis.legend(frameon=False, ncols=2, loc="lower center", bbox_to_anchor=(0.5, 1.0), fontsize=8)


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


def _label_steps(axis: Any, name: str, rows: Sequence[Mapping[str, Any]]) -> None:
    axis.set_xticks(range(len(rows)), [row["name"] for row in rows], rotation=30, ha="right", fontsize=8)
    axis.set_xlabel(SWEEPS[name].axis)


def _draw_sweep(axis: Any, name: str, rows: Sequence[Mapping[str, Any]]) -> None:
    """The sweep's figure with its spreads, of both modes where the other one was measured."""
    key = SWEEPS[name].figure
    top = 0.0
    for mode, color in _MODES.items():
        there = [(i, row if mode == "wavefront" else row[mode]) for i, row in enumerate(rows) if row[mode]]
        values = [r[key] for _, r in there]
        if there:
            spreads = [r.get(f"{key}Spread", 0.0) for _, r in there]
            axis.errorbar([i for i, _ in there], values, spreads, fmt="o-", capsize=3, color=color, label=mode)
        top = max([top, *values])
    axis.set_ylim(0, 1.15 * top)
    axis.set_ylabel(SWEEPS[name].figure_title)
    axis.legend(frameon=False)
    _label_steps(axis, name, rows)


def _draw_compiling(axis: Any, name: str, rows: Sequence[Mapping[str, Any]]) -> None:
    for mode, color in _MODES.items():
        there = [(i, row[mode]["compileSeconds"]) for i, row in enumerate(rows) if row[mode]]
        axis.plot([i for i, _ in there], [s for _, s in there], "o-", color=color, label=mode)
    axis.set_ylim(0)
    axis.set_ylabel("s of threads to compile")
    axis.legend(frameon=False)
    _label_steps(axis, name, rows)


def _draw_peers(axis: Any, rows: Sequence[Mapping[str, Any]]) -> None:
    """Ours over theirs; beyond the line is in our favour."""
    names = [" ".join([row["scene"], row["peer"], row.get("kind") or row.get("variant", "")]) for row in rows]
    axis.barh(range(len(rows)), [row["ratio"] for row in rows], color=_COLORS[0])
    axis.axvline(1.0, color="black", linewidth=0.8)
    axis.set_yticks(range(len(rows)), names, fontsize=8)
    axis.set_xlabel("ours / theirs")
    axis.invert_yaxis()
