# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""hdWavefront renders USD stages: a queue-based wavefront path tracer on Vulkan compute.

    import hdwavefront
    render = hdwavefront.open("scene.usda", width=640)
    render.start(samples=64)
    render.wait()
    render.save("image.exr")

The render runs in the background: `progress`, `pause`, `resume`, `stop` and `map` (the picture so far, as a numpy
array) may be called at any time. See `hdwavefront.open` and `hdwavefront.Render` for the rest.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .api import Render, open
    from .errors import Diagnostic, HdWavefrontError, UsageError

__all__ = ["Diagnostic", "HdWavefrontError", "Render", "UsageError", "open"]

# Nothing heavy is imported before it is used: `hdwavefront --help` stays fast.
_HOME = {
    "Render": "api",
    "open": "api",
    "Diagnostic": "errors",
    "HdWavefrontError": "errors",
    "UsageError": "errors",
}


def __getattr__(name: str) -> Any:
    import importlib

    if name == "__version__":
        return importlib.import_module("._core", __name__).__version__
    if name in _HOME:
        return getattr(importlib.import_module("." + _HOME[name], __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
