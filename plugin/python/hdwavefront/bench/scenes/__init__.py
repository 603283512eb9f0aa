# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Scenes of the benchmark. Each is built from nothing by a function `build(folder) -> Scene`, the same to the byte each
time: no clock, no machine, and random numbers of a fixed seed."""

from __future__ import annotations

import os
from collections.abc import Callable

from .builder import Scene


def _carpaint(folder: str) -> Scene:
    from . import carpaint

    return carpaint.build(folder)


def _city(folder: str) -> Scene:
    from . import city

    return city.build(folder)


def _conference(folder: str) -> Scene:
    from . import conference

    return conference.build(folder)


# To add a scene: a module beside this one, and a row here.
SCENES: dict[str, Callable[[str], Scene]] = {"carpaint": _carpaint, "city": _city, "conference": _conference}


def sweep_scene(folder: str, kind: str, **numbers: int) -> Scene:
    """A scene of scenes/sweeps.py."""
    from .sweeps import MAKERS

    make: Callable[..., Scene] = MAKERS[kind]
    return make(folder, **numbers)


def stage_scene(path: str) -> Scene:
    """Any USD file. What is in it is counted by the renderer."""
    return Scene(os.path.splitext(os.path.basename(path))[0], path, 0, 0, 0, 640, 360)
