# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Plots of `hdwavefront bench --plots`: what was measured is drawn, and what was not is not."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest
from hdwavefront.bench import plots
from hdwavefront.bench.measure import GROUPS

pytest.importorskip("matplotlib")

SHARE = dict.fromkeys(GROUPS, 0.25)


def mode(value: float) -> dict[str, Any]:
    return {
        **{"mpathsPerSecond": value, "mpathsPerSecondSpread": 0.1, "compileSeconds": 10 * value, "share": SHARE},
        **{"nanosecondsPerSegment": 100 * value, "nanosecondsPerSegmentSpread": 7.0},
    }


def step(name: str, value: float, mega: float | None) -> dict[str, Any]:
    return {**mode(value), "name": name, "wavefront": mode(value), "megakernel": mega and mode(mega)}


REPORT: dict[str, Any] = {
    "machine": {"device": "none", "driver": "none"},
    "scenes": [{"name": "a", "wavefront": mode(3.0), "megakernel": None}],
    "sweeps": {
        "materials": [step("1", 1.0, 2.0), step("16", 1.5, 3.0), step("100", 2.0, None)],
        "pool": [step("4096", 1.0, None)],
        "lights": [],
    },
    "peers": [{"scene": "a", "peer": "embree", "kind": "camera", "ratio": 0.5}],
}


@pytest.fixture()
def figures(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> dict[str, list[dict[str, Any]]]:
    """Of each figure its axes: labels of the legend, and points or bars by label."""
    seen: dict[str, list[dict[str, Any]]] = {}
    save = plots._save

    def look(figure: Any, folder: str, name: str) -> list[str]:
        seen[name] = [axis_of(axis) for axis in figure.axes]
        return save(figure, folder, name)

    def axis_of(axis: Any) -> dict[str, Any]:
        drawn = {str(c.get_label()): c for c in axis.containers}
        points = {k: list(c.lines[0].get_ydata()) for k, c in drawn.items() if getattr(c, "lines", [None])[0]}
        bars = {k: [p.get_height() for p in c.patches] for k, c in drawn.items() if hasattr(c, "patches")}
        lines = {line.get_label(): list(line.get_ydata()) for line in axis.lines if line.get_label()[0] != "_"}
        has_spreads = {k for k, c in drawn.items() if getattr(c, "has_yerr", False)}
        return {"points": points, "bars": bars, "lines": lines, "spreads": has_spreads}

    monkeypatch.setattr(plots, "_save", look)
    written = plots.draw(str(tmp_path), REPORT)
    expected = [f"{name}.{ending}" for name in ("scenes", "materials", "pool", "peers") for ending in ("png", "svg")]
    assert [os.path.basename(path) for path in written] == expected
    assert all(os.path.getsize(path) > 1000 for path in written)
    return seen


def test_a_mode_that_was_not_measured_has_no_bar(figures: dict[str, list[dict[str, Any]]]) -> None:
    assert list(figures["scenes"][0]["bars"]) == ["wavefront"]


def test_a_sweep_has_both_modes_with_spreads_and_what_compiling_took(figures: dict[str, list[dict[str, Any]]]) -> None:
    times, compiling = figures["materials"]
    assert times["points"] == {"megakernel": [200, 300], "wavefront": [100, 150, 200]}
    assert times["spreads"] == {"megakernel", "wavefront"}
    assert compiling["lines"] == {"megakernel": [20, 30], "wavefront": [10, 15, 20]}
    (alone,) = figures["pool"]
    assert list(alone["points"]) == ["wavefront"]
