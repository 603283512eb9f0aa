# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Answers the delegate's requests for images. Each file is decoded once for all that ask for it in a commit: colour
spaces, patterns whose tile it is, plain paths. Two files at a time, so that large images do not pile up.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..color.manager import ColorManager
from ..errors import Diagnostics
from .textures import Conversion, TextureError, is_tiled, load_texture, missing_tiles, tile_files

_AT_ONCE = 2


@dataclass
class _Use:
    """What is made of a file: an image, or a tile of one."""

    request: Any
    tiles: _Tiles | None = None
    number: int = 0


@dataclass
class _Tiles:
    """The tiles of a request that have come."""

    numbers: Sequence[int]
    left: int
    pixels: dict[int, np.ndarray] = field(default_factory=dict)
    reasons: dict[int, str] = field(default_factory=dict)


def load_pending(delegate: Any, colors: ColorManager, diagnostics: Diagnostics) -> None:
    """Every request is answered, by texels or by why there are none."""
    files: dict[str, list[_Use]] = {}
    for request in delegate.pending_textures():
        path = request.resolved_path
        if not is_tiled(path):
            files.setdefault(path, []).append(_Use(request))
            continue
        found = tile_files(path)
        if not found:
            delegate.set_texture_missing(request.key, "no tile of the pattern exists.")
        tiles = _Tiles(list(found), len(found))
        for number, file in found.items():
            files.setdefault(file, []).append(_Use(request, tiles, number))

    def decode(path: str, uses: list[_Use]) -> list[np.ndarray]:
        delegate.count_decoded_image()
        conversions = [Conversion(use.request.color_space, use.request.is_color) for use in uses]
        return load_texture(path, conversions, colors, diagnostics)

    def hand_over(uses: list[_Use], decoding: Future[list[np.ndarray]]) -> None:
        try:
            images, reason = decoding.result(), ""
        except TextureError as error:
            images, reason = [], str(error)
        for i, use in enumerate(uses):
            if use.tiles is not None:
                _take_tile(delegate, diagnostics, use, use.tiles, images[i] if images else reason)
            elif images:
                delegate.set_texture(use.request.key, images[i])
            else:
                delegate.set_texture_missing(use.request.key, f"{reason}.")

    with ThreadPoolExecutor(_AT_ONCE) as pool:
        waiting: list[tuple[list[_Use], Future[list[np.ndarray]]]] = []
        for file, uses in _by_file(files).items():
            waiting.append((uses, pool.submit(decode, file, uses)))
            if len(waiting) == _AT_ONCE:
                hand_over(*waiting.pop(0))
        for item in waiting:
            hand_over(*item)


def _by_file(paths: dict[str, list[_Use]]) -> dict[str, list[_Use]]:
    """Paths that lead to one file, by links or ".." inside, are one."""
    first: dict[str, str] = {}
    files: dict[str, list[_Use]] = {}
    for path, uses in paths.items():
        files.setdefault(first.setdefault(os.path.realpath(path), path), []).extend(uses)
    return files


def _take_tile(delegate: Any, diagnostics: Diagnostics, use: _Use, tiles: _Tiles, tile: np.ndarray | str) -> None:
    """Hands the image over with its last tile. Tiles that cannot be used, or lie between others and are not there, are
    said once, at the node that asked."""
    if isinstance(tile, str):
        tiles.reasons[use.number] = tile
    else:
        tiles.pixels[use.number] = tile
    tiles.left -= 1
    if tiles.left > 0:
        return
    request = use.request
    reasons = [f"{number}: {reason}" for number, reason in sorted(tiles.reasons.items())]
    if not tiles.pixels:
        delegate.set_texture_missing(request.key, f"no tile can be used ({'; '.join(reasons)}).")
        return
    missing = missing_tiles(tiles.numbers)
    if missing:
        reasons.append(f"there is no file for {missing}")
    if reasons:
        text = f'Tiles of the texture "{request.resolved_path}" show the fallback value: {"; ".join(reasons)}.'
        diagnostics.warning("texture-tiles-missing", request.location, text)
    numbers = sorted(tiles.pixels)
    delegate.set_texture_tiles(request.key, numbers, [tiles.pixels[number] for number in numbers])
    tiles.pixels.clear()
