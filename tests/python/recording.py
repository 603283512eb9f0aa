# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""A delegate that records what it is told, and holds every call to the signature in `_core.pyi`.

It draws nothing: `map` gives a plain grey. What the image looks like is the business of testenv/.
"""

from __future__ import annotations

import ast
import importlib
import inspect
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np

STUB = Path(__file__).resolve().parents[2] / "plugin/python/hdwavefront/_core.pyi"

AOVS = {
    "color": 4,
    "albedo": 3,
    "normal": 3,
    "depth": 1,
    "cameraDepth": 1,
    "primId": 1,
    "instanceId": 1,
    "elementId": 1,
    "sampleCount": 1,
}


def _signatures() -> dict[str, inspect.Signature]:
    """The methods of RenderDelegate as the stub declares them."""
    tree = ast.parse(STUB.read_text(encoding="utf-8"))
    cls = next(n for n in tree.body if isinstance(n, ast.ClassDef) and n.name == "RenderDelegate")
    signatures = {}
    for node in cls.body:
        if isinstance(node, ast.FunctionDef):
            source = f"def {node.name}({ast.unparse(node.args)}): ..."
            scope: dict[str, Any] = {}
            code = compile("from __future__ import annotations\n" + source, str(STUB), "exec")
            exec(code, scope)
            signatures[node.name] = inspect.signature(scope[node.name])
    return signatures


class RecordingDelegate:
    """`told[path]` is the last update of each prim; `calls` are all calls in order."""

    SIGNATURES = _signatures()

    def __init__(self, **options: Any) -> None:
        self.options = options
        self.calls: list[tuple[str, tuple[Any, ...], dict[str, Any]]] = []
        self.told: dict[str, dict[str, Any]] = {}
        self.kinds: dict[str, str] = {}
        self.settings: dict[str, Any] = {
            "samples": 64,
            "radianceClamp": 0.0,
            "enableShadows": True,
            "domeLightCameraVisibility": True,
        }
        self.render_pass: dict[str, Any] = {}
        self.requests: list[Any] = []
        self.textures: dict[int, Any] = {}
        self.translation: Any = None
        self.waits_left = 0
        self.stopped = False

    def __getattr__(self, name: str) -> Any:
        if name not in self.SIGNATURES:
            raise AttributeError(name)

        def call(*args: Any, **kwargs: Any) -> Any:
            self.SIGNATURES[name].bind(self, *args, **kwargs)
            self.calls.append((name, args, kwargs))
            return getattr(self, "_" + name, lambda *a, **k: None)(*args, **kwargs)

        return call

    def named(self, kind: str) -> list[str]:
        return [path for path, k in self.kinds.items() if k == kind]

    def _remember(self, kind: str, path: str, update: Any) -> None:
        self.told[path], self.kinds[path] = update, kind

    def _sync_mesh(self, path: str, **update: Any) -> None:
        self._remember("mesh", path, update)

    def _sync_implicit(self, path: str, **update: Any) -> None:
        self._remember("implicit", path, update)

    def _sync_instancer(self, path: str, **update: Any) -> None:
        self._remember("instancer", path, update)

    def _sync_light(self, path: str, **update: Any) -> None:
        self._remember("light", path, update)

    def _sync_camera(self, path: str, **update: Any) -> None:
        self._remember("camera", path, update)

    def _sync_material(self, path: str, contexts: Any) -> None:
        self._remember("material", path, contexts)

    def _forget(self, path: str) -> None:
        del self.told[path], self.kinds[path]

    _destroy_rprim = _destroy_sprim = _destroy_instancer = _forget

    def _pending_textures(self) -> list[Any]:
        return self.requests

    def _set_texture(self, key: int, pixels: Any, **_: Any) -> None:
        self.textures[key] = pixels

    def _set_texture_missing(self, key: int, reason: str) -> None:
        self.textures[key] = reason

    def _set_render_pass(self, **update: Any) -> None:
        self.render_pass.update(update)

    def _set_setting(self, token: str, value: Any) -> bool:
        changed = self.settings.get(token) != value
        self.settings[token] = value
        return changed

    def _setting(self, token: str) -> Any:
        return self.settings[token]

    def _wait(self, timeout: float = 0) -> bool:
        self.waits_left -= 1
        return self.waits_left < 0 or self.stopped

    def _stop(self) -> None:
        self.stopped = True

    def _progress(self) -> dict[str, Any]:
        total = self.render_pass["width"] * self.render_pass["height"] * self.settings["samples"]
        return {"samplesDone": 7, "pathsDone": total // 2, "pathsTotal": total, "seconds": 2.0, "converged": True}

    def _map(self, aov: str) -> np.ndarray:
        shape = (self.render_pass["height"], self.render_pass["width"], AOVS[aov])
        if aov.endswith("Id"):
            return np.full(shape, -1, dtype=np.int32)
        return np.full(shape, 0.25, dtype=np.float32)

    def _stats(self) -> dict[str, Any]:
        return {
            "kernels": [],
            "queues": [],
            "renderSeconds": 2.0,
            "paths": 10,
            "segments": 20,
            "extensionRays": 20,
            "shadowRays": 10,
        }

    def _diagnostics(self, since: int = 0) -> list[Any]:
        return []

    def _camera_matrices(self) -> tuple[np.ndarray, np.ndarray]:
        return np.eye(4), np.eye(4)

    def _run_color_kernel(self, pixels: np.ndarray, **_: Any) -> np.ndarray:
        return np.array(pixels)


def fake_core(delegates: list[RecordingDelegate]) -> Any:
    """Stands in for hdwavefront._core; every delegate that is made is put into `delegates`."""

    def make(**options: Any) -> RecordingDelegate:
        delegates.append(RecordingDelegate(**options))
        return delegates[-1]

    names = importlib.import_module("hdwavefront._core")  # pure functions need no stand-in
    return SimpleNamespace(
        aov_channels=names.aov_channels,
        aov_of_render_var=names.aov_of_render_var,
        __version__="0.0.test",
        RenderDelegate=make,
        aovs=lambda: [{"token": token, "components": n} for token, n in AOVS.items()],
        render_settings=lambda: [
            {"token": "samples", "type": "int", "default": 64, "doc": "samples per pixel", "flag": "--samples"},
            {"token": "radianceClamp", "type": "float", "default": 0, "doc": "100 % of it", "flag": "radianceClamp"},
            {"token": "enableShadows", "type": "bool", "default": True, "doc": "shadows", "flag": ""},
            {"token": "domeLightCameraVisibility", "type": "bool", "default": True, "doc": "sky", "flag": ""},
        ],
        build_facts=lambda: {"version": "0.0.test"},
        list_devices=lambda: [
            {"name": "A card", "type": "discrete GPU", "usable": True},
            {"name": "An old processor", "type": "CPU", "usable": False},
            {"name": "A processor", "type": "CPU", "usable": True},
        ],
    )
