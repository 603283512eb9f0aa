# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Files that `hdwavefront bench` writes: asked for before minutes are spent, written whatever was measured by then."""

from __future__ import annotations

import argparse
import json
import os
from typing import Any

from ..errors import HdWavefrontError


def check(args: argparse.Namespace) -> None:
    """HdWavefrontError where a file that is asked for cannot be written."""
    if args.plots:
        from ..bench import plots

        if not plots.available():
            raise HdWavefrontError("--plots needs matplotlib: pip install 'hdwavefront[bench]'")
    for folder in filter(None, (args.pictures, args.plots)):
        try:
            os.makedirs(folder, exist_ok=True)
        except OSError as error:
            raise HdWavefrontError(f"The folder {folder} cannot be made: {error.strerror}") from None
    if args.json:
        was_there = os.path.exists(args.json)
        _open(args.json, "a").close()
        if not was_there:
            os.remove(args.json)


def _open(path: str, mode: str) -> Any:
    try:
        return open(path, mode, encoding="utf-8")
    except OSError as error:
        raise HdWavefrontError(f"The file {path} cannot be written: {error.strerror}") from None


def write(args: argparse.Namespace, report: dict[str, Any]) -> None:
    if args.json:
        with _open(args.json, "w") as file:
            json.dump(report, file, indent=1)
            file.write("\n")
    if args.plots:
        from ..bench import plots

        for path in plots.draw(args.plots, report):
            print(f"Wrote {path}")
    print(f"{report['seconds']:.0f} s in all", flush=True)
