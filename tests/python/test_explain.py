# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What `hdwavefront explain` prints of a kernel that it was told about; testenv asks it about real ones."""

from __future__ import annotations

from typing import Any

from hdwavefront.cli.explain import _cost

KERNEL: dict[str, Any] = {
    "state": "ready",
    "generateMilliseconds": 2.0,
    "codeMilliseconds": 30.0,
    "codeFromCache": False,
    "createMilliseconds": 50.0,
    "firstDispatchMilliseconds": 280.0,
    "spirvBytes": 41000,
    "spirvInstructions": 2500,
    "driverStatistics": [],
    "paths": 0,
}


def test_what_the_driver_tells_is_shown_and_that_it_tells_nothing_is_said():
    told = _cost(KERNEL | {"driverStatistics": ["surface: Register Count: 64", "surface: Binary Size: 20480"]})
    assert told[1:3] == ["driver: surface: Register Count: 64", "driver: surface: Binary Size: 20480"]
    assert _cost(KERNEL)[1].startswith("driver: tells nothing")
    assert not any(line.startswith("driver:") for line in _cost(KERNEL | {"state": "compiling"}))


def test_times_of_the_render_need_paths():
    assert _cost(KERNEL)[-1] == "render: no path met it"
    measured = _cost(KERNEL | {"paths": 4000, "nanosecondsPerPath": 212.4, "share": 0.25})
    assert measured[-1] == "render: 212 ns a path, 4000 paths, 25.0% of all kernels' time"
    assert "driver 330 ms" in measured[0]
