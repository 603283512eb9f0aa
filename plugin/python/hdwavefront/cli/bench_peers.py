# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`hdwavefront bench --peer`: the scenes against other renderers."""

from __future__ import annotations

import argparse
import os
import sys
import tempfile
from collections.abc import Sequence
from typing import Any

from ..errors import HdWavefrontError, UsageError

_RAY_TURNS = 9
_MILLION = "a million triangles"  # the sweep's step, for rays
_LEAST_SECONDS = 5.0  # that are worth beginning with a scene


def check(args: argparse.Namespace, names: Sequence[str], sweeps: Sequence[str]) -> None:
    """Of what was named, what has nothing to be compared with is an error: it would be left out without a word."""
    if not args.what:
        return
    for sweep in sweeps:
        if sweep != "triangles" or "embree" not in args.peer:
            raise UsageError(f"'{sweep}' is no scene that --peer {args.peer[0]} compares.")
    for peer in args.peer:
        if not names and peer != "embree":
            raise UsageError(f"--peer {peer} compares scenes and USD files, and none is named.")


def compare_peers(
    args: argparse.Namespace, names: Sequence[str], sweeps: Sequence[str], clock: Any, report: dict[str, Any]
) -> bool:
    """Fills the report's "peers". False where a comparison failed."""
    from ..bench.peers.compare import OutOfTime, why_absent
    from ..bench.tables import peer_table

    work: list[tuple[str, str]] = []
    for peer in args.peer:
        absent = why_absent(peer)
        if absent:
            print(f"{peer} is not compared: {absent}.")
            continue
        work += [(peer, name) for name in names]
        work += [(peer, _MILLION)] if peer == "embree" and "triangles" in sweeps else []
    rows: list[dict[str, Any]] = report["peers"]
    good = True
    try:
        for place, (peer, name) in enumerate(work):
            limit = clock.left / (len(work) - place)
            if limit < _LEAST_SECONDS:
                print(f"{name} by {peer}: left out: {clock.passed:.0f} s have passed")
                continue
            print(f"{name} by {peer} ...", file=sys.stderr, flush=True)
            try:
                rows += _rows_of(args, peer, name, limit)
            except OutOfTime as over:
                print(f"{name} by {peer}: left out: {over}")
            except HdWavefrontError as error:
                good = False
                print(f"{name}: {error}")
    finally:
        if rows:
            print("\n" + peer_table(rows))
    return good


def _rows_of(args: argparse.Namespace, peer: str, name: str, limit: float) -> list[dict[str, Any]]:
    from ..bench.peers.compare import compare, compare_rays
    from ..bench.scenes import SCENES, stage_scene, sweep_scene

    with tempfile.TemporaryDirectory(prefix="hdwavefront-bench-") as folder:
        if name == _MILLION:
            scene = sweep_scene(folder, "triangles", count=1_000_000)
        else:
            scene = SCENES[name](folder) if name in SCENES else stage_scene(os.path.abspath(name))
        if peer == "embree":
            return compare_rays(scene, folder, args.width, args.turns or _RAY_TURNS, args.device, limit)
        return [compare(peer, scene, folder, args.width, args.peer_samples, args.device, args.variant, limit)]
