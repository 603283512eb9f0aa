# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Scenes of the benchmark. Each is built from nothing by a function `build(folder) -> Scene`, the same to the byte each
time: no clock, no machine, and random numbers of a fixed seed."""

from __future__ import annotations

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
