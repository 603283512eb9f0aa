# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Keeps a delegate in step with a stage: tells what is there, removes what is not there any more."""

from __future__ import annotations

from typing import Any


class TrackingSink:
    """Passes updates on to a delegate and knows which paths were told since `begin`."""

    def __init__(self, delegate: Any) -> None:
        self._delegate = delegate
        self._old: dict[str, str] = {}
        self._new: dict[str, str] = {}

    def begin(self) -> None:
        self._new = {}

    def finish(self) -> None:
        """Destroys what was told before and was not told again. Instancers last: Rprims may still name them."""
        gone = [(path, kind) for path, kind in self._old.items() if self._new.get(path) != kind]
        for path, kind in sorted(gone, key=lambda item: item[1] == "instancer"):
            getattr(self._delegate, f"destroy_{kind}")(path)
        self._old = self._new

    def sync_mesh(self, path: str, **update: Any) -> None:
        self._new[path] = "rprim"
        self._delegate.sync_mesh(path, **update)

    def sync_implicit(self, path: str, **update: Any) -> None:
        self._new[path] = "rprim"
        self._delegate.sync_implicit(path, **update)

    def sync_instancer(self, path: str, **update: Any) -> None:
        self._new[path] = "instancer"
        self._delegate.sync_instancer(path, **update)

    def sync_light(self, path: str, **update: Any) -> None:
        self._new[path] = "sprim"
        self._delegate.sync_light(path, **update)

    def sync_material(self, path: str, contexts: Any) -> None:
        self._new[path] = "sprim"
        self._delegate.sync_material(path, contexts)

    def sync_camera(self, path: str, **update: Any) -> None:
        self._new[path] = "sprim"
        self._delegate.sync_camera(path, **update)
