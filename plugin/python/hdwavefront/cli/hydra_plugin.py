# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""For `doctor`: the Hydra plugin, where it is, which OpenUSD it was built for, and whether it loads in this one."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from dataclasses import dataclass

RENDERER = "HdWavefrontRendererPlugin"
HOW_TO_BUILD = "configure with -Dpxr_DIR=... or -DHDWAVEFRONT_OPENUSD_ROOT=..., see plugin/hydra/README.md"


@dataclass(frozen=True)
class HydraPlugin:
    folder: str  # holds plugInfo.json
    openusd: str  # version that it was built for; "" where build.json does not say


def _candidates() -> Iterator[str]:
    yield os.environ.get("HDWAVEFRONT_HYDRA", "")
    yield from os.environ.get("PXR_PLUGINPATH_NAME", "").split(os.pathsep)
    # The build folder holds the package and the plugin side by side.
    package = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    yield os.path.join(package, "..", "..", "hydra", "hdWavefront", "resources")


def _is_ours(folder: str) -> bool:
    try:
        with open(os.path.join(folder, "plugInfo.json"), encoding="utf-8") as file:
            return RENDERER in file.read()
    except (OSError, UnicodeDecodeError):
        return False


def find_hydra_plugin() -> HydraPlugin | None:
    """The first that is found: $HDWAVEFRONT_HYDRA, $PXR_PLUGINPATH_NAME, the build folder."""
    for folder in _candidates():
        if not folder or not _is_ours(folder):
            continue
        openusd = ""
        try:
            with open(os.path.join(folder, "build.json"), encoding="utf-8") as file:
                openusd = str(json.load(file).get("openusd", ""))
        except (OSError, ValueError, AttributeError):
            pass
        return HydraPlugin(os.path.realpath(folder), openusd)
    return None


def why_not_loaded(plugin: HydraPlugin) -> str | None:
    """None: it loads in the `pxr` of this process. Raises ImportError where that `pxr` has no imaging."""
    from pxr import Plug, Tf, UsdImagingGL  # noqa: F401  (the last: not there without imaging)

    registry = Plug.Registry()
    registry.RegisterPlugins(plugin.folder)
    found = registry.GetPluginWithName("hdWavefront")
    if not found:
        return f"OpenUSD takes no plugin from {plugin.folder}"
    try:
        return None if found.Load() else "OpenUSD refuses to load it"
    except Tf.ErrorException as error:
        return " ".join(str(error).split())
