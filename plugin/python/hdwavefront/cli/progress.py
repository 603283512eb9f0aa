# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""How far a render is: a bar on a terminal, plain lines elsewhere."""

from __future__ import annotations

import sys
import time
from typing import Any, TextIO

_WIDTH = 30
_LINE_SECONDS = 10.0


def _duration(seconds: float) -> str:
    if seconds < 60:
        return f"{seconds:.0f} s"
    if seconds < 3600:
        return f"{seconds // 60:.0f} min {seconds % 60:02.0f} s"
    return f"{seconds // 3600:.0f} h {seconds % 3600 // 60:02.0f} min"


def describe(progress: dict[str, Any], samples: int) -> tuple[float, str]:
    """The fraction that is done, and samples, rate and time left in words."""
    done, total, seconds = progress["pathsDone"], max(1, progress["pathsTotal"]), progress["seconds"]
    fraction = min(1.0, done / total)
    words = f"{progress['samplesDone']}/{samples} samples"
    if done and seconds > 0:
        words += f", {done / seconds / 1e6:.2f} Mpaths/s"
        if fraction < 1:
            words += f", {_duration(seconds * (1 - fraction) / fraction)} left"
    return fraction, words


class ProgressDisplay:
    def __init__(self, samples: int, stream: TextIO | None = None) -> None:
        self._samples = samples
        self._stream = stream or sys.stderr
        self._terminal = self._stream.isatty()
        self._last_line = time.monotonic()
        self._shown = False

    def update(self, progress: dict[str, Any]) -> None:
        fraction, words = describe(progress, self._samples)
        if self._terminal:
            filled = int(fraction * _WIDTH)
            self._stream.write(f"\r\x1b[K[{'#' * filled}{'.' * (_WIDTH - filled)}] {fraction:4.0%} {words}")
            self._stream.flush()
            self._shown = True
        elif time.monotonic() - self._last_line >= _LINE_SECONDS:
            self._last_line = time.monotonic()
            self._stream.write(f"{fraction:.0%} {words}\n")
            self._stream.flush()

    def clear(self) -> None:
        """Makes room for other lines."""
        if self._shown:
            self._stream.write("\r\x1b[K")
            self._stream.flush()
            self._shown = False
