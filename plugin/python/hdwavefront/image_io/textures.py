# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Decodes textures for the delegate: RGBA in the rendering colour space, in the precision of the file. uint8 and uint16
where the file's numbers are the values, half floats where they are converted. Floats stay floats, unless all are halfs
(those of RGBE files are). Files are read in strips, so that the host never holds more than the result.
"""

from __future__ import annotations

import io
import os
import re
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from ..color.manager import ColorManager
from ..errors import Diagnostics

_STRIP_BYTES = 16 << 20
_MAX_SIDE = 32768
_HALF_MAX = 65504.0
_FLOAT_MAX = float(np.finfo(np.float32).max)


class TextureError(Exception):
    """Why an image cannot be used; the text goes into a diagnostic that names prim and file."""


def load_texture(
    path: str, color_space: str, is_color: bool, colors: ColorManager, diagnostics: Diagnostics
) -> np.ndarray:
    """(height, width, 4) uint8, uint16, float16 or float32, row 0 at the top. TextureError where the file is
    no use.

    `color_space`: raw, sRGB, auto, a space's name, or empty, which is auto. Grey images fill red, green and blue; a
    second channel is alpha, as UsdUVTexture has it.
    """
    if os.path.exists(path):
        return _load_file(path, color_space, is_color, colors, diagnostics)
    data = _package_bytes(path)
    if data is None:
        raise TextureError("the file does not exist or cannot be read")
    suffix = os.path.splitext(path.rstrip("]"))[1]
    with tempfile.NamedTemporaryFile(suffix=suffix) as file:
        file.write(data)
        file.flush()
        return _load_file(file.name, color_space, is_color, colors, diagnostics)


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


def load_tiles(
    pattern: str, color_space: str, is_color: bool, colors: ColorManager, diagnostics: Diagnostics, location: str
) -> dict[int, np.ndarray]:
    """Tiles by UDIM number. Those that cannot be used, or lie between others and are not there, are said once, at
    `location`: the node that asked.
    """
    files = tile_files(pattern)
    if not files:
        raise TextureError("no tile of the pattern exists")
    tiles: dict[int, np.ndarray] = {}
    reasons: list[str] = []
    for tile, file in files.items():
        try:
            tiles[tile] = load_texture(file, color_space, is_color, colors, diagnostics)
        except TextureError as error:
            reasons.append(f"{tile}: {error}")
    if not tiles:
        raise TextureError(f"no tile can be used ({'; '.join(reasons)})")
    columns = {(tile - 1001) % 10 for tile in files}
    rows = {(tile - 1001) // 10 for tile in files}
    box = {1001 + u + 10 * v for u in range(min(columns), max(columns) + 1) for v in range(min(rows), max(rows) + 1)}
    missing = sorted(box - set(files))
    if missing:
        more = ", and more" if len(missing) > 8 else ""
        reasons.append(f"there is no file for {', '.join(map(str, missing[:8]))}{more}")
    if reasons:
        text = f'Tiles of the texture "{pattern}" show the fallback value: {"; ".join(reasons)}.'
        diagnostics.warning("texture-tiles-missing", location, text)
    return tiles


def _package_bytes(path: str) -> Any:
    """The bytes of a file inside a package (scene.usdz[image.png]), by USD's resolver."""
    if "[" not in path:
        return None
    from ..stage_adapters.assets import open_asset

    return open_asset(path)


def _load_file(
    path: str, color_space: str, is_color: bool, colors: ColorManager, diagnostics: Diagnostics
) -> np.ndarray:
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
        space = _resolve_space(spec, color_space, is_color, len(channels), oiio)
        try:
            processor = colors.to_rendering(space)
        except LookupError:
            diagnostics.warning(
                "texture-color-space", path, f"the colour space '{space}' is unknown; the values are taken as they are"
            )
            processor = None
        is_bytes = spec.format.basetype == oiio.UINT8
        table = _byte_table(processor) if is_bytes and processor is not None else None
        if table is not None:
            return _through_table(source, spec, channels, table, oiio)
        pixels, clipped = _through_processor(source, spec, channels, processor, oiio)
        if clipped:
            text = f"values beyond {_HALF_MAX:.0f} (of floats: infinite ones), or that are no numbers, were clipped"
            diagnostics.info("texture-clipped", path, text)
        return pixels
    finally:
        source.close()


def _through_processor(
    source: Any, spec: Any, channels: list[int], processor: Any, oiio: Any
) -> tuple[np.ndarray, bool]:
    """(pixels, whether any were clipped)"""
    stored = spec.format.basetype
    as_is = {oiio.UINT8: np.uint8, oiio.UINT16: np.uint16, oiio.HALF: np.float16}
    dtype: Any = as_is.get(stored) if processor is None else None
    kind = stored if dtype is not None else oiio.FLOAT
    is_float = stored in (oiio.FLOAT, oiio.DOUBLE, oiio.UINT32, oiio.INT32)
    pixels = np.empty((spec.height, spec.width, 4), dtype=dtype or np.float16)
    clipped = False
    for begin, strip in _strips(source, spec, channels, kind):
        target = pixels[begin : begin + len(strip)]
        if dtype is not None:
            _expand(strip, target, np.iinfo(dtype).max if target.dtype.kind == "u" else 1)
            clipped |= dtype == np.float16 and _clip_halves(target)
            continue
        rgba = np.empty(target.shape, dtype=np.float32)
        _expand(strip, rgba, 1)
        if processor is not None:
            processor.applyRGBA(rgba)
        clipped |= _clip_floats(rgba, _FLOAT_MAX if is_float else _HALF_MAX)
        with np.errstate(over="ignore"):
            halfs = rgba.astype(np.float16)
        if is_float and pixels.dtype == np.float16 and (halfs != rgba).any():
            pixels = pixels.astype(np.float32)  # what is there already is exact
            target = pixels[begin : begin + len(strip)]
        target[...] = halfs if pixels.dtype == np.float16 else rgba
    return pixels, clipped


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


def _through_table(source: Any, spec: Any, channels: list[int], table: np.ndarray, oiio: Any) -> np.ndarray:
    pixels = np.empty((spec.height, spec.width, 4), dtype=np.float16)
    alpha = (np.arange(256, dtype=np.float32) / 255).astype(np.float16)
    for begin, strip in _strips(source, spec, channels, oiio.UINT8):
        target = pixels[begin : begin + len(strip)]
        colors = 1 if strip.shape[2] <= 2 else 3
        target[..., :3] = table[strip[..., :colors]]
        target[..., 3] = alpha[strip[..., -1]] if strip.shape[2] in (2, 4) else 1
    return pixels


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
