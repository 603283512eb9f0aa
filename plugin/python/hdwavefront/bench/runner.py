# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Starts workers, hears what they find, and ends them when their time is over."""

from __future__ import annotations

import contextlib
import json
import os
import selectors
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
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


class Worker:
    """A process at a task. Ends with the `with` block, whatever it does."""

    def __init__(self, task: Task) -> None:
        self.outcome = Outcome()
        self._begin = time.monotonic()
        self._errors = tempfile.TemporaryFile("w+")  # closed in __exit__
        self._process = subprocess.Popen(
            [sys.executable, "-m", "hdwavefront.bench.worker", task.text()],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            env={**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
        )
        assert self._process.stdin is not None and self._process.stdout is not None
        self._in, self._out = self._process.stdin, self._process.stdout
        os.set_blocking(self._out.fileno(), False)
        self._buffer = b""
        self._over = False

    def __enter__(self) -> Worker:
        return self

    def __exit__(self, *_: object) -> None:
        self.end()
        self._out.close()
        with contextlib.suppress(OSError):
            self._in.close()
        self._errors.close()

    def go_on(self) -> None:
        """What it waits for."""
        with contextlib.suppress(OSError):  # it has ended: listening finds that out
            self._in.write(b"\n")
            self._in.flush()

    def listen(self, seconds: float) -> bool:
        """Until it waits (True), or has ended or is ended since its time is over (False)."""
        end = time.monotonic() + seconds
        with selectors.DefaultSelector() as selector:
            selector.register(self._out, selectors.EVENT_READ)
            while not self._over:
                if b"\n" in self._buffer:
                    line, self._buffer = self._buffer.split(b"\n", 1)
                    if line.startswith(b'{"event": "waiting"'):
                        return True
                    if line.startswith(b'{"event"'):
                        self.outcome.take(json.loads(line))
                    continue
                left = end - time.monotonic()
                if left <= 0:
                    self.outcome.timed_out = True
                    self.end()
                elif selector.select(min(left, 3600.0)):
                    chunk = self._out.read()
                    self._buffer += chunk or b""
                    if not chunk:
                        self._process.wait()
                        self.end()
        return False

    def end(self) -> None:
        """Idempotent. A killed process that a compiler filled may take half a minute to be gone: not waited for."""
        if self._over:
            return
        self._over = True
        if self._process.poll() is None:
            self._process.kill()
        try:
            code = self._process.wait(2.0)
        except subprocess.TimeoutExpired:
            code = -9
        if code != 0 and not self.outcome.timed_out:
            self._errors.seek(0)
            said = [line for line in self._errors.read().splitlines() if line.strip()]
            self.outcome.error = said[-1] if said else f"the process ended with code {code}"
        self.outcome.seconds = time.monotonic() - self._begin


def run_task(task: Task, limit: float) -> Outcome:
    """Runs a worker for at most `limit` seconds."""
    with Worker(task) as worker:
        begin = time.monotonic()
        while worker.listen(limit - (time.monotonic() - begin)):
            worker.go_on()
        return worker.outcome


def run_side_by_side(
    tasks: Mapping[str, Task],
    clock: Clock,
    measuring: float,
    say: Callable[[str], None],
    outcomes: dict[str, Outcome],
) -> None:
    """Tasks of two modes, of which the second takes long to compile: all compile it at once, nothing is measured
    meanwhile. Each is given `measuring` seconds for what comes then, out of the clock's. `outcomes` has what they say
    at any time, so that what comes in between loses none."""
    with contextlib.ExitStack() as stack:
        workers: dict[str, Worker] = {}
        waiting: set[str] = set()
        for name, task in tasks.items():
            say(f"{name}: first mode ...")
            workers[name] = stack.enter_context(Worker(replace(task, waits=True)))
            outcomes[name] = workers[name].outcome
            if workers[name].listen(clock.left - measuring * len(tasks)):
                waiting.add(name)
        say(f"compiling the second mode of {', '.join(sorted(waiting))} ...")
        for name in waiting:
            workers[name].go_on()
        ready = [n for n in tasks if n in waiting and workers[n].listen(clock.left - measuring * len(waiting))]
        for place, name in enumerate(ready):
            say(f"{name}: in turns ...")
            workers[name].go_on()
            workers[name].listen(clock.left - measuring * (len(ready) - place - 1))
            workers[name].end()
