# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Colours that stand in attributes."""

from __future__ import annotations

from typing import Any

from pxr import Usd

from .context import Translation


def rendering_color(translation: Translation, rgb: tuple[float, ...], attribute: Usd.Attribute) -> Any:
    """A colour in the rendering space, by the attribute's colour space. One that nobody knows is said."""
    space = str(attribute.GetColorSpace())
    if space and not translation.options.knows_color_space(space):
        translation.diagnostics.warning(
            "color-space-unknown",
            attribute.GetPath(),
            f"no configuration knows the colour space '{space}'; the value is taken as it is",
        )
    return translation.options.convert_color(rgb, space)
