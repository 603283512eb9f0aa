# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What goes wrong, in two kinds: errors that end a command, and diagnostics of scene content that do not."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import dataclass

# Exit codes of the command line. argparse uses 2 for a wrong command line as well.
EXIT_OK = 0
EXIT_FAILED = 1  # the input or the environment does not allow the render
EXIT_USAGE = 2
EXIT_INTERRUPTED = 130  # Ctrl-C, as shells count it


class HdWavefrontError(Exception):
    """The input or the environment makes a render impossible. The text is one sentence for the user."""

    exit_code = EXIT_FAILED


class UsageError(HdWavefrontError):
    """A flag or an argument has a value that makes no sense."""

    exit_code = EXIT_USAGE


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """A problem with scene content that is rendered around. `code` is stable; `location` is a prim path or a file."""

    severity: str  # info, warning, error
    code: str
    location: str
    message: str

    def __str__(self) -> str:
        return f"{self.severity}: {self.location}: {self.message} [{self.code}]"


class Diagnostics:
    """Collects diagnostics, each distinct one once, and passes them on as they come. Callable from any thread."""

    def __init__(self, on_new: Callable[[Diagnostic], None] | None = None) -> None:
        self._seen: dict[Diagnostic, None] = {}
        self._lock = threading.Lock()
        self._on_new = on_new

    def __iter__(self):
        with self._lock:
            return iter(list(self._seen))

    def __len__(self) -> int:
        return len(self._seen)

    def add(self, severity: str, code: str, location: str, message: str) -> None:
        diagnostic = Diagnostic(severity, code, str(location), message)
        with self._lock:
            if diagnostic in self._seen:
                return
            self._seen[diagnostic] = None
        if self._on_new:
            self._on_new(diagnostic)

    def info(self, code: str, location: object, message: str) -> None:
        self.add("info", code, str(location), message)

    def warning(self, code: str, location: object, message: str) -> None:
        self.add("warning", code, str(location), message)

    def error(self, code: str, location: object, message: str) -> None:
        self.add("error", code, str(location), message)

    def codes(self) -> set[str]:
        return {d.code for d in self}
