# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Asset-valued attributes: what was authored, what the resolver found, and the colour space that goes with it."""

from __future__ import annotations

import os
from typing import Any

from pxr import Ar, Sdf, Usd

from .context import Update


def asset_value(attribute: Usd.Attribute, time: Usd.TimeCode) -> Update | None:
    """None where no file is named. `resolved` is empty where the resolver finds nothing; <UDIM> patterns are kept."""
    value = attribute.Get(time)
    if value is None:
        return None
    authored = value.path if isinstance(value, Sdf.AssetPath) else str(value)
    if not authored:
        return None
    resolved = value.resolvedPath if isinstance(value, Sdf.AssetPath) else ""
    if ("<UDIM>" in authored or "<UVTILE>" in authored) and not resolved:
        resolved = _anchor(attribute, authored, time)
    return {"authored": authored, "resolved": resolved, "colorSpace": str(attribute.GetColorSpace())}


def _anchor(attribute: Usd.Attribute, authored: str, time: Usd.TimeCode) -> str:
    """A pattern beside the layer that authored it; the resolver only finds files that exist under their own name."""
    for spec in attribute.GetPropertyStack(time):
        if spec.HasInfo("default") or spec.HasInfo("timeSamples"):
            path = os.path.normpath(spec.layer.ComputeAbsolutePath(authored))
            # USD leaves a search path ("t.<UDIM>.png", without "./") as it is where no file has that very name.
            beside = os.path.dirname(spec.layer.realPath)
            return path if os.path.isabs(path) or not beside else os.path.normpath(os.path.join(beside, path))
    return authored


def open_asset(resolved: str) -> Any:
    """The bytes of an asset that is no plain file (inside a .usdz package); None where it cannot be opened."""
    asset = Ar.GetResolver().OpenAsset(Ar.ResolvedPath(resolved))
    return asset.GetBuffer() if asset else None
