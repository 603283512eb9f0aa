# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Starts workers, hears what they find, and ends them when their time is over."""

from __future__ import annotations

import json
import os
import selectors
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from typing import Any

from .worker import Task


@dataclass
class Outcome:
    """What a worker said, as far as it came."""

    scene: dict[str, Any] = field(default_factory=dict)
    modes: dict[str, dict[str, Any]] = field(default_factory=dict)  # results
    why_not: dict[str, str] = field(default_factory=dict)  # by mode
    identical: bool | None = None
    error: str = ""
    timed_out: bool = False
    seconds: float = 0.0

    def take(self, line: dict[str, Any]) -> None:
        event = line["event"]
        if event == "unavailable":
            self.why_not[line["mode"]] = line["why"]
        elif event == "result":
            self.scene = line["scene"]
            self.modes[line["mode"]] = line["result"]
        elif event == "compared":
            self.identical = line["identical"]


class Clock:
    """The time that the benchmark may take, of which each step gets what is left."""

    def __init__(self, seconds: float | None) -> None:
        self._begin = time.monotonic()
        self._seconds = seconds

    @property
    def passed(self) -> float:
        return time.monotonic() - self._begin

    @property
    def left(self) -> float:
        return float("inf") if self._seconds is None else self._seconds - self.passed


def run_task(task: Task, limit: float) -> Outcome:
    """Runs a worker for at most `limit` seconds."""
    outcome = Outcome()
    begin = time.monotonic()
    with tempfile.TemporaryFile("w+") as errors:
        worker = subprocess.Popen(
            [sys.executable, "-m", "hdwavefront.bench.worker", task.text()],
            stdout=subprocess.PIPE,
            stderr=errors,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
        )
        try:
            _listen(worker, outcome, begin + limit)
        finally:
            code = _end(worker)
            assert worker.stdout is not None
            worker.stdout.close()
        if code != 0 and not outcome.timed_out:
            errors.seek(0)
            said = [line for line in errors.read().splitlines() if line.strip()]
            outcome.error = said[-1] if said else f"the process ended with code {code}"
    outcome.seconds = time.monotonic() - begin
    return outcome


def _end(worker: subprocess.Popen[bytes]) -> int:
    """The exit code. A killed process that a compiler filled may take half a minute to be gone: not waited for."""
    if worker.poll() is None:
        worker.kill()
    try:
        return worker.wait(2.0)
    except subprocess.TimeoutExpired:
        return -9


def _listen(worker: subprocess.Popen[bytes], outcome: Outcome, end: float) -> None:
    assert worker.stdout is not None
    os.set_blocking(worker.stdout.fileno(), False)
    buffer = b""
    with selectors.DefaultSelector() as selector:
        selector.register(worker.stdout, selectors.EVENT_READ)
        while True:
            left = end - time.monotonic()
            if left <= 0:
                outcome.timed_out = True
                return
            if not selector.select(min(left, 3600.0)):
                continue
            chunk = worker.stdout.read()
            if not chunk:
                worker.wait()
                return
            *lines, buffer = (buffer + chunk).split(b"\n")
            for line in lines:
                if line.startswith(b'{"event"'):
                    outcome.take(json.loads(line))
