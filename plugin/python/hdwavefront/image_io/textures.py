# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Decodes textures for the delegate: RGBA in the rendering colour space, in the precision of the file. uint8 and uint16
where the file's numbers are the values, half floats where they are converted. Floats stay floats, unless all are halfs
(those of RGBE files are). A file is decoded once for all conversions, in strips, so that the host never holds more than
the results.
"""

from __future__ import annotations

import io
import os
import re
import tempfile
import zipfile
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..color.manager import ColorManager
from ..errors import Diagnostics

_STRIP_BYTES = 16 << 20
_MAX_SIDE = 32768
_HALF_MAX = 65504.0
_FLOAT_MAX = float(np.finfo(np.float32).max)


class TextureError(Exception):
    """Why an image cannot be used; the text goes into a diagnostic that names prim and file."""


class Conversion(NamedTuple):
    """color_space: raw, sRGB, auto, a space's name, or empty, which is auto. Data are never converted."""

    color_space: str
    is_color: bool


def load_texture(
    path: str, conversions: Sequence[Conversion], colors: ColorManager, diagnostics: Diagnostics
) -> list[np.ndarray]:
    """By conversion: (height, width, 4) uint8, uint16, float16 or float32, row 0 at the top; the same array for those
    that are the same for this file. TextureError where the file is no use. It is decoded once.

    Grey images fill red, green and blue; a second channel is alpha, as UsdUVTexture has it.
    """
    if os.path.exists(path):
        return _load_file(path, conversions, colors, diagnostics)
    data = _package_bytes(path)
    if data is None:
        raise TextureError("the file does not exist or cannot be read")
    suffix = os.path.splitext(path.rstrip("]"))[1]
    with tempfile.NamedTemporaryFile(suffix=suffix) as file:
        file.write(data)
        file.flush()
        return _load_file(file.name, conversions, colors, diagnostics)


TILE_TOKENS = ("<UDIM>", "<UVTILE>")


def is_tiled(path: str) -> bool:
    return any(token in path for token in TILE_TOKENS)


def tile_files(pattern: str) -> dict[int, str]:
    """Files of a pattern by UDIM number. <UDIM>: 1001 + column + 10 row; <UVTILE>: u<column + 1>_v<row + 1>."""
    package, _, inner = pattern[:-1].rpartition("[") if pattern.endswith("]") else ("", "", pattern)
    folder, name = os.path.split(inner)
    token = next(t for t in TILE_TOKENS if t in name) if is_tiled(name) else ""
    if not token:
        return {}
    files = _files_in_package(package, folder) if package else _files_in(folder)
    head, tail = (re.escape(part) for part in name.split(token, 1))
    number = r"(\d{4})" if token == "<UDIM>" else r"u(\d+)_v(\d+)"
    found: dict[int, str] = {}
    for file in files:
        match = re.fullmatch(head + number + tail, file)
        if match is None:
            continue
        if token == "<UDIM>":
            tile = int(match[1])
        else:
            column, row = int(match[1]) - 1, int(match[2]) - 1
            tile = 1001 + column + 10 * row if 0 <= column < 10 and row >= 0 else 0
        if 1001 <= tile <= 9999:
            path = os.path.join(folder, file)
            found[tile] = f"{package}[{path}]" if package else path
    return dict(sorted(found.items()))


def _files_in(folder: str) -> list[str]:
    return os.listdir(folder or ".") if os.path.isdir(folder or ".") else []


def _files_in_package(package: str, folder: str) -> list[str]:
    data = package if os.path.exists(package) else _package_bytes(package)
    if data is None:
        return []
    try:
        with zipfile.ZipFile(data if isinstance(data, str) else io.BytesIO(bytes(data))) as archive:
            names = archive.namelist()
    except (OSError, zipfile.BadZipFile):
        return []
    return [os.path.basename(name) for name in names if os.path.dirname(name) == folder]


def missing_tiles(tiles: Sequence[int]) -> str:
    """Those between the outermost ones that are not among them, as text for a diagnostic; empty: none."""
    columns = {(tile - 1001) % 10 for tile in tiles}
    rows = {(tile - 1001) // 10 for tile in tiles}
    box = {1001 + u + 10 * v for u in range(min(columns), max(columns) + 1) for v in range(min(rows), max(rows) + 1)}
    missing = sorted(box - set(tiles))
    return ", ".join(map(str, missing[:8])) + (", and more" if len(missing) > 8 else "")


def _package_bytes(path: str) -> Any:
    """The bytes of a file inside a package (scene.usdz[image.png]), by USD's resolver."""
    if "[" not in path:
        return None
    from ..stage_adapters.assets import open_asset

    return open_asset(path)


def _load_file(
    path: str, conversions: Sequence[Conversion], colors: ColorManager, diagnostics: Diagnostics
) -> list[np.ndarray]:
    import OpenImageIO as oiio

    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)  # USD's textures are used as they are, never premultiplied
    source = oiio.ImageInput.open(path, config)
    if source is None:
        raise TextureError(f"the file cannot be read as an image: {_first_line(oiio.geterror())}")
    try:
        spec = source.spec()
        if not (0 < spec.width <= _MAX_SIDE and 0 < spec.height <= _MAX_SIDE):
            raise TextureError(f"its size {spec.width} x {spec.height} is not within 1..{_MAX_SIDE} a side")
        channels = _choose_channels(list(spec.channelnames))
        spaces = [_resolve_space(spec, *conversion, len(channels), oiio) for conversion in conversions]
        targets: dict[str, _Table | _Values] = {}
        for space in spaces:
            if space.lower() not in targets:
                targets[space.lower()] = _target(path, space, spec, colors, diagnostics, oiio)
        as_stored = spec.format.basetype in (oiio.UINT8, oiio.UINT16, oiio.HALF)
        for begin, strip in _strips(source, spec, channels, spec.format.basetype if as_stored else oiio.FLOAT):
            for target in targets.values():
                target.take(begin, strip)
        if any(target.clipped for target in targets.values()):
            text = f"values beyond {_HALF_MAX:.0f} (of floats: infinite ones), or that are no numbers, were clipped"
            diagnostics.info("texture-clipped", path, text)
        return [targets[space.lower()].pixels for space in spaces]
    finally:
        source.close()


def _target(
    path: str, space: str, spec: Any, colors: ColorManager, diagnostics: Diagnostics, oiio: Any
) -> _Table | _Values:
    try:
        processor = colors.to_rendering(space)
    except LookupError:
        diagnostics.warning(
            "texture-color-space", path, f"the colour space '{space}' is unknown; the values are taken as they are"
        )
        processor = None
    if spec.format.basetype == oiio.UINT8 and processor is not None:
        table = _byte_table(processor)
        if table is not None:
            return _Table(spec, table)
    return _Values(spec, processor, oiio)


class _Values:
    """The texels of one conversion: as they are in the file, or through the processor."""

    def __init__(self, spec: Any, processor: Any, oiio: Any) -> None:
        stored = spec.format.basetype
        as_is: dict[Any, Any] = {oiio.UINT8: np.uint8, oiio.UINT16: np.uint16, oiio.HALF: np.float16}
        self._processor = processor
        self._dtype = as_is.get(stored) if processor is None else None
        self._is_float = stored in (oiio.FLOAT, oiio.DOUBLE, oiio.UINT32, oiio.INT32)
        self.pixels = np.empty((spec.height, spec.width, 4), dtype=self._dtype or np.float16)
        self.clipped = False

    def take(self, begin: int, strip: np.ndarray) -> None:
        target = self.pixels[begin : begin + len(strip)]
        if self._dtype is not None:
            _expand(strip, target, np.iinfo(self._dtype).max if target.dtype.kind == "u" else 1)
            self.clipped |= self._dtype == np.float16 and _clip_halves(target)
            return
        rgba = np.empty(target.shape, dtype=np.float32)
        _expand(_as_floats(strip), rgba, 1)
        if self._processor is not None:
            self._processor.applyRGBA(rgba)
        self.clipped |= _clip_floats(rgba, _FLOAT_MAX if self._is_float else _HALF_MAX)
        with np.errstate(over="ignore"):
            halfs = rgba.astype(np.float16)
        if self._is_float and self.pixels.dtype == np.float16 and (halfs != rgba).any():
            self.pixels = self.pixels.astype(np.float32)  # what is there already is exact
            target = self.pixels[begin : begin + len(strip)]
        target[...] = halfs if self.pixels.dtype == np.float16 else rgba


def _as_floats(strip: np.ndarray) -> np.ndarray:
    """0..1, to the bit as OpenImageIO reads such files as floats."""
    if strip.dtype.kind == "u":
        return strip.astype(np.float32) * np.float32(1 / np.iinfo(strip.dtype).max)
    return strip.astype(np.float32, copy=False)


class _Table:
    """The texels of a conversion of bytes that goes by a table."""

    def __init__(self, spec: Any, table: np.ndarray) -> None:
        self._table = table
        self._alpha = (np.arange(256, dtype=np.float32) / 255).astype(np.float16)
        self.pixels = np.empty((spec.height, spec.width, 4), dtype=np.float16)
        self.clipped = False

    def take(self, begin: int, strip: np.ndarray) -> None:
        target = self.pixels[begin : begin + len(strip)]
        colors = 1 if strip.shape[2] <= 2 else 3
        target[..., :3] = self._table[strip[..., :colors]]
        target[..., 3] = self._alpha[strip[..., -1]] if strip.shape[2] in (2, 4) else 1


def _byte_table(processor: Any) -> np.ndarray | None:
    """What each byte becomes, where the conversion treats the channels alike and apart (sRGB to lin_rec709 does): ten
    times as fast as the processor. None where it mixes channels."""
    grey = np.repeat(np.arange(256, dtype=np.float32)[:, None] / 255, 4, axis=1).reshape(1, 256, 4).copy()
    processor.applyRGBA(grey)
    mixed = np.array([[[50, 130, 200, 255], [250, 0, 20, 255], [0, 255, 0, 255]]], dtype=np.float32) / 255
    expected = grey[0, np.rint(mixed * 255).astype(int), 0][..., :3]
    processor.applyRGBA(mixed)
    if not np.allclose(mixed[..., :3], expected, rtol=1e-4, atol=1e-6):
        return None
    return grey[0, :, 0].astype(np.float16)


def _first_line(text: str) -> str:
    return text.strip().splitlines()[0] if text.strip() else "unknown reason"


def _choose_channels(names: list[str]) -> list[int]:
    """Channels of the main layer: R, G, B, A by name, else the first ones."""
    lower = [n.lower() for n in names]
    for wanted in (("r", "g", "b", "a"), ("r", "g", "b"), ("y", "a")):
        if all(w in lower for w in wanted):
            return [lower.index(w) for w in wanted]
    return list(range(min(len(names), 4)))


def _resolve_space(spec: Any, color_space: str, is_color: bool, channels: int, oiio: Any) -> str:
    """UsdUVTexture's sourceColorSpace: "auto" means sRGB for 8-bit images of three or more channels, else raw."""
    if not is_color:
        return "raw"
    if color_space and color_space.lower() != "auto":
        return color_space
    stated = spec.get_string_attribute("oiio:ColorSpace").lower()
    is_linear = stated.startswith("lin") or stated == "scene_linear"
    if spec.format.basetype == oiio.UINT8 and channels >= 3 and not is_linear:
        return "sRGB"
    return "raw"


def _strips(source: Any, spec: Any, channels: list[int], kind: Any) -> Iterator[tuple[int, np.ndarray]]:
    """(first row, (rows, width, channels)) from top to bottom, in OpenImageIO's type `kind`."""
    low, high = min(channels), max(channels) + 1
    picked = [c - low for c in channels]
    straight = picked == list(range(high - low))
    step = max(1, _STRIP_BYTES // max(1, spec.width * (high - low) * 4))
    read: Callable[[int, int], Any]
    if spec.tile_width:
        step = max(1, step // spec.tile_height) * spec.tile_height

        def read(begin: int, end: int) -> Any:
            return source.read_tiles(
                0, 0, spec.x, spec.x + spec.width, spec.y + begin, spec.y + end, 0, 1, low, high, kind
            )
    else:

        def read(begin: int, end: int) -> Any:
            return source.read_scanlines(0, 0, spec.y + begin, spec.y + end, 0, low, high, kind)

    for begin in range(0, spec.height, step):
        end = min(begin + step, spec.height)
        strip = read(begin, end)
        if strip is None:
            raise TextureError(f"the image is damaged at row {begin}: {_first_line(source.geterror())}")
        strip = np.asarray(strip).reshape(end - begin, spec.width, high - low)
        yield begin, strip if straight else strip[:, :, picked]


def _expand(strip: np.ndarray, rgba: np.ndarray, one: float) -> None:
    count = strip.shape[2]
    if count == 4:
        rgba[...] = strip
        return
    rgba[..., :3] = strip if count == 3 else strip[..., :1]
    rgba[..., 3] = strip[..., 1] if count == 2 else one


def _clip_floats(rgba: np.ndarray, limit: float) -> bool:
    """Clips to +-limit; True if anything changed."""
    low, high = float(rgba.min()), float(rgba.max())
    if -limit <= low and high <= limit:  # false for NaN as well
        return False
    np.nan_to_num(rgba, copy=False, nan=0.0, posinf=limit, neginf=-limit)
    np.clip(rgba, -limit, limit, out=rgba)
    return True


def _clip_halves(rgba: np.ndarray) -> bool:
    """The same for half floats, where only infinities and NaN can be out of range: all bits of the exponent set."""
    if not ((rgba.view(np.uint16) & 0x7C00) == 0x7C00).any():
        return False
    np.nan_to_num(rgba, copy=False, nan=0.0, posinf=_HALF_MAX, neginf=-_HALF_MAX)
    return True
