# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The same textures laid out for each way to read them (textures/README.md), and what a read must give."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

PAGE, PITCH, LAYER = 64, 65, 1024
ACROSS = LAYER // PITCH  # pages beside each other in a layer of the array image
READS = 4  # of an item, at READ_STEP from each other
READ_STEP = np.array([0.25, 0.125], np.float32)


@dataclass
class Textures:
    """`count` textures of side x side texels, all with the same texels but each with its own memory."""

    count: int
    side: int
    texel_format: str  # rgba8, rgba16f
    levels: list[np.ndarray]
    tables: dict[str, bytes]  # what scene/texture_store.cpp makes of them

    @property
    def value_range(self) -> float:
        return 1.0 if self.texel_format == "rgba8" else 8.0


def make(count: int, side: int, texel_format: str) -> Textures:
    from _kernel_runner import halve_level, scene_tables

    rng = np.random.default_rng(side)
    if texel_format == "rgba8":
        level = rng.integers(0, 256, (side, side, 4)).astype(np.uint8)
    else:
        level = (rng.random((side, side, 4)) * 8 - 1).astype(np.float16)
    levels = [level]
    while levels[-1].shape[0] > 1:
        size = levels[-1].shape[0]
        half = halve_level(levels[-1].tobytes(), size, size, texel_format)
        levels.append(np.frombuffer(half, level.dtype).reshape(size // 2, size // 2, 4))
    texels = level.tobytes()
    tables = scene_tables([], [(side, side, texel_format, texels)] * count, [], 1.0)
    if tables["diagnostics"]:
        raise SystemExit(f"{count} textures of {side} x {side} pass what the renderer holds on this device")
    return Textures(count, side, texel_format, levels, tables)


def array_pages(textures: Textures) -> tuple[bytes, bytes]:
    """(layers of the array image, page table): the pool's pages, moved."""
    table = np.frombuffer(textures.tables["pageTable"], np.uint32).copy()
    records = np.frombuffer(textures.tables["textureRecords"], np.uint32).reshape(-1, 4)
    dtype = textures.levels[0].dtype
    block = 16912 // (4 * dtype.itemsize)  # kPageBlockBytes, in texels; a page of halfs takes two blocks
    stride = block * dtype.itemsize
    pool = np.frombuffer(textures.tables["texturePages"], dtype).reshape(-1, 4)
    pages = len(pool) // stride
    own = pool[: pages * stride].reshape(pages, stride, 4)[:, : PITCH * PITCH].reshape(pages, PITCH, PITCH, 4)
    layers = np.zeros((-(-pages // ACROSS**2), LAYER, LAYER, 4), dtype)
    for page in range(pages):
        layer, place = divmod(page, ACROSS**2)
        y, x = (place // ACROSS) * PITCH, (place % ACROSS) * PITCH
        layers[layer, y : y + PITCH, x : x + PITCH] = own[page]
    entries = np.ones(len(table), bool)
    for _, _, levels_and_format, first in records:
        entries[first : first + (levels_and_format & 0xFFFF)] = False
    page, inside = np.divmod(table[entries], stride)
    layer, place = np.divmod(page, ACROSS**2)
    y = place // ACROSS * PITCH + inside // PITCH
    x = place % ACROSS * PITCH + inside % PITCH
    table[entries] = layer << 20 | y << 10 | x
    return layers.tobytes(), table.tobytes()


def pages_per_texel(textures: Textures) -> tuple[bytes, bytes, bytes]:
    """(records, page table, pages): pages of 64 x 64 texels, the levels of at most 32 side by side in one."""
    own: list[np.ndarray] = []
    heads: list[int] = []
    entries: list[int] = []
    tail: np.ndarray | None = None
    for level in textures.levels:
        size = level.shape[0]
        heads.append(len(textures.levels) + len(entries))
        if size <= PAGE // 2:
            if tail is None:
                tail = np.zeros((PAGE, PAGE, 4), level.dtype)
                tail_entry = heads[-1]
                entries.append(len(own))
                own.append(tail)
            heads[-1] = tail_entry
            left = PAGE - 2 * size
            tail[:size, left : left + size] = level
            continue
        for y in range(0, size, PAGE):
            for x in range(0, size, PAGE):
                entries.append(len(own))
                own.append(level[y : y + PAGE, x : x + PAGE])
    # The k-th level of the tail starts at 64 - (64 >> k): as above, where the texture has at least 32 texels a side.
    pages = np.ascontiguousarray(own)
    words: list[int] = []
    records: list[int] = []
    for texture in range(textures.count):
        records += [textures.side, textures.side, len(textures.levels), int(textures.texel_format != "rgba8")]
        records += [len(words), 0, 0, 0]
        words += heads + [entry + texture * len(own) for entry in entries]
    texels = pages.tobytes() * textures.count
    return np.array(records, np.uint32).tobytes(), np.array(words, np.uint32).tobytes(), texels


def items(textures: Textures, count: int, pattern: str, trilinear: bool) -> np.ndarray:
    """(count, 4): u, v, footprint, bits of the texture id. Items of a texture stand together, but for `mixed`.

    coherent: an item's neighbours read the next texels, halfway between level 0 and 1 where trilinear.
    incoherent: anywhere, levels 0 to 4. mixed: so, in any texture.
    """
    rng = np.random.default_rng(count)
    values = np.zeros((count, 4), np.float32)
    own = count // textures.count
    index = np.arange(count)
    if pattern == "coherent":
        width = 1 << (int(np.log2(own)) // 2)
        values[:, 0] = (index % own % width + 0.37) / textures.side
        values[:, 1] = (index % own // width + 0.61) / textures.side
        lod = np.full(count, 0.5)
    else:
        values[:, :2] = rng.random((count, 2))
        lod = rng.uniform(0, min(4, len(textures.levels) - 1), count)
    values[:, 2] = 2**lod / textures.side if trilinear else 0
    ids = rng.integers(0, textures.count, count) if pattern == "mixed" else index // own
    values[:, 3] = ids.astype(np.uint32).view(np.float32)
    return values


def expected(textures: Textures, chosen: np.ndarray) -> np.ndarray:
    """Sum of an item's reads, in double precision, from the plain levels."""
    total = np.zeros((len(chosen), 4))
    scale = 1 / 255 if textures.texel_format == "rgba8" else 1.0
    lod = np.log2(np.maximum(chosen[:, 2].astype(np.float64) * textures.side, 1e-8))
    lod = np.clip(lod, 0, len(textures.levels) - 1)
    low = np.floor(lod).astype(int)
    for read in range(READS):
        uv = (chosen[:, :2] + READ_STEP * np.float32(read)).astype(np.float64)
        for number, level in enumerate(textures.levels):
            for at, weight in ((low == number, 1 - (lod - low)), (low + 1 == number, lod - low)):
                if at.any():
                    total[at] += weight[at, None] * bilinear(level, uv[at]) * scale
    return total


def bilinear(level: np.ndarray, uv: np.ndarray) -> np.ndarray:
    size = level.shape[0]
    p = uv * size - 0.5
    base = np.floor(p).astype(int)
    f = p - base
    total = np.zeros((len(uv), 4))
    for dx in (0, 1):
        for dy in (0, 1):
            weight = (f[:, 0] if dx else 1 - f[:, 0]) * (f[:, 1] if dy else 1 - f[:, 1])
            total += weight[:, None] * level[(base[:, 1] + dy) % size, (base[:, 0] + dx) % size].astype(np.float64)
    return total
