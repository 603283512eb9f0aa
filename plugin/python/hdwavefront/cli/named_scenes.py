# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The benchmark's scenes by their names, wherever a command takes a USD file."""

from __future__ import annotations

import argparse
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

NAMES = ("carpaint", "city", "conference")
HELP = f"USD file, or the name of one of the benchmark's scenes ({', '.join(NAMES)})"


@contextmanager
def built(args: argparse.Namespace) -> Iterator[None]:
    """Where `args.usdFilePath` is no file but the name of a scene: the scene, built for as long as the block lasts."""
    name = args.usdFilePath
    if name not in NAMES or os.path.isfile(name):
        yield
        return
    from ..stage import import_pxr

    import_pxr()
    from ..bench.scenes import SCENES

    with tempfile.TemporaryDirectory(prefix="hdwavefront-scene-") as folder:
        args.usdFilePath = SCENES[name](folder).path
        yield
