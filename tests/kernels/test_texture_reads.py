# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""lib/textures.glsl against a reader of plain arrays, over the pages that scene/texture_store.cpp really lays out."""

from __future__ import annotations

import numpy as np
import pytest
from core_harness import bits, call

REPEAT, CLAMP, MIRROR, BLACK = range(4)
MAIN = """void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= outputs.length()) return;
  vec4 a = inputs[i * IN], outside = inputs[i * IN + 2u];
  uvec4 b = floatBitsToUint(inputs[i * IN + 1u]);
  outputs[i] = READ(b.x, a.xy, a.z, b.y, b.z, outside);
}"""
LINEAR, CLOSEST, CUBIC = "textureRead", "textureReadClosest", "textureReadCubic"
FORMATS = ("rgba8", "rgba16f", "rgba16", "rgba32f")
# The half of a step near the largest value; values of halfs and floats are from -1 to 7.
PRECISION = {"rgba8": 0.5 / 255, "rgba16f": 8 * 2.0**-12, "rgba16": 0.5 / 65535, "rgba32f": 8 * 2.0**-24}
TABLES = ("textureRecords", "pageTable", "texturePages")
OUTSIDE = np.array([0.25, -2.0, 3.0, 0.5], np.float32)
# Sizes at the borders of pages and of the mip tail, odd ones, flat ones.
SIZES = [
    (1, 1),
    (2, 1),
    (31, 31),
    (32, 32),
    (33, 33),
    (63, 63),
    (64, 64),
    (65, 65),
    (100, 37),
    (257, 257),
    (3, 130),
    (300, 1),
]


def image(width: int, height: int, texel_format: str, seed: int = 0) -> np.ndarray:
    """(height, width, 4), row 0 at the bottom, values that the format holds exactly."""
    rng = np.random.default_rng(seed + width * 1000 + height)
    if texel_format == "rgba8":
        return rng.integers(0, 256, (height, width, 4)).astype(np.uint8)
    if texel_format == "rgba16":
        return rng.integers(0, 65536, (height, width, 4)).astype(np.uint16)
    values = rng.random((height, width, 4)) * 8 - 1
    return values.astype(np.float16 if texel_format == "rgba16f" else np.float32)


def format_of(texels: np.ndarray) -> str:
    return {"uint8": "rgba8", "uint16": "rgba16", "float16": "rgba16f", "float32": "rgba32f"}[texels.dtype.name]


def as_float(texels: np.ndarray) -> np.ndarray:
    whole = texels.dtype.kind == "u"
    return texels.astype(np.float64) / (np.iinfo(texels.dtype).max if whole else 1)


def halve_axis(values: np.ndarray, axis: int) -> np.ndarray:
    """Box filter: target texel k covers [k s, (k + 1) s) of the source, s = size / max(1, size // 2)."""
    size = values.shape[axis]
    target = max(1, size // 2)
    edges = np.linspace(0, size, target + 1)
    weights = np.zeros((target, size))
    for k in range(target):
        overlap = np.minimum(edges[k + 1], np.arange(size) + 1) - np.maximum(edges[k], np.arange(size))
        weights[k] = np.maximum(overlap, 0) * target / size
    return np.moveaxis(np.tensordot(weights, values, (1, axis)), 0, axis)


def pyramid(texels: np.ndarray) -> list[np.ndarray]:
    """All levels as floats: halved by C++, whose every step is compared with halve_axis in a test of its own."""
    from _kernel_runner import halve_level

    kind = format_of(texels)
    levels = [texels]
    while levels[-1].shape[:2] != (1, 1):
        h, w = levels[-1].shape[:2]
        half = halve_level(levels[-1].tobytes(), w, h, kind)
        levels.append(np.frombuffer(half, texels.dtype).reshape(max(1, h // 2), max(1, w // 2), 4))
    return [as_float(level) for level in levels]


def wrapped(i: np.ndarray, size: int, mode: int) -> tuple[np.ndarray, np.ndarray]:
    """Index inside, and whether it is inside."""
    if mode == REPEAT:
        return np.mod(i, size), np.ones(i.shape, bool)
    if mode == MIRROR:
        m = np.mod(i, 2 * size)
        return np.where(m < size, m, 2 * size - 1 - m), np.ones(i.shape, bool)
    if mode == CLAMP:
        return np.clip(i, 0, size - 1), np.ones(i.shape, bool)
    return np.clip(i, 0, size - 1), (i >= 0) & (i < size)


def bilinear(level: np.ndarray, uv: np.ndarray, wrap_u: int, wrap_v: int) -> np.ndarray:
    height, width = level.shape[:2]
    p = uv * np.array([width, height]) - 0.5
    base = np.floor(p).astype(int)
    f = p - base
    total = np.zeros((len(uv), 4))
    for dx in (0, 1):
        for dy in (0, 1):
            x, inside_x = wrapped(base[:, 0] + dx, width, wrap_u)
            y, inside_y = wrapped(base[:, 1] + dy, height, wrap_v)
            texel = np.where((inside_x & inside_y)[:, None], level[y, x], OUTSIDE.astype(float))
            weight = (f[:, 0] if dx else 1 - f[:, 0]) * (f[:, 1] if dy else 1 - f[:, 1])
            total += weight[:, None] * texel
    return total


def reference(levels: list[np.ndarray], uv, footprint, wrap_u: int, wrap_v: int) -> np.ndarray:
    largest = max(levels[0].shape[:2])
    lod = np.clip(np.log2(np.maximum(footprint * largest, 1e-8)), 0, len(levels) - 1)
    low = np.floor(lod).astype(int)
    blend = lod - low
    out = np.zeros((len(uv), 4))
    for k in range(len(levels)):
        for at, weight in ((low == k, 1 - blend), (low + 1 == k, blend)):
            if at.any():
                out[at] += weight[at, None] * bilinear(levels[k], uv[at], wrap_u, wrap_v)
    return out


def read(runner, tables, texture: int, uv, footprint, wrap_u: int, wrap_v: int, by: str = LINEAR) -> np.ndarray:
    inputs = np.zeros((len(uv), 12), np.float32)
    inputs[:, :2] = uv
    inputs[:, 2] = footprint
    inputs[:, 4:7] = bits(np.array([texture, wrap_u, wrap_v], np.uint32))
    inputs[:, 8:] = OUTSIDE
    return call(runner, ["lib/textures.glsl"], MAIN.replace("READ", by), inputs, 1, {k: tables[k] for k in TABLES})


@pytest.fixture(scope="module")
def store(kernel_runner):
    """One store with every size in all formats: pages of one texture follow those of others."""
    from _kernel_runner import scene_tables

    images = [(w, h, f, image(w, h, f)) for w, h in SIZES for f in FORMATS]
    tables = scene_tables([], [(w, h, f, t.tobytes()) for w, h, f, t in images], [], 1.0)
    assert tables["diagnostics"] == []
    return tables, images, [pyramid(t) for *_, t in images]


def uvs(width: int, height: int, count: int, seed: int) -> np.ndarray:
    """Random places in and around the unit square, and the centres and borders of texels at its corners.

    Multiples of 1/4096 of a texel, so that float and double agree on the texel.
    """
    rng = np.random.default_rng(seed)
    texels = rng.random((count, 2)) * np.array([width, height]) * 3 - np.array([width, height])
    corner = [0.0, 0.5, 1.0, 31.5, 32.5, 63.5, 64.0, 64.5]
    special = [
        (a, b) for a in [*corner, *[width - c for c in corner]] for b in [*corner, *[height - c for c in corner]]
    ]
    at = np.round(np.concatenate([texels, np.array(special, float)]) * 4096) / 4096
    return (at / np.array([width, height])).astype(np.float32)


def names(store_images) -> list[str]:
    return [f"{w}x{h}-{f}" for w, h, f, _ in store_images]


@pytest.mark.parametrize(
    "wrap", [(REPEAT, REPEAT), (CLAMP, CLAMP), (MIRROR, MIRROR), (BLACK, BLACK), (REPEAT, CLAMP), (BLACK, MIRROR)]
)
def test_bilinear_reads_and_wraps(kernel_runner, store, wrap):
    tables, images, pyramids = store
    for index, (w, h, f, _) in enumerate(images):
        uv = uvs(w, h, 512, index)
        got = read(kernel_runner, tables, index, uv, 0.0, *wrap)
        # float32: a texel coordinate of up to 3 * size is off by 2^-24 of itself, times the largest slope (8 a texel).
        want = reference(pyramids[index], uv.astype(np.float64), np.zeros(len(uv)), *wrap)
        assert np.abs(got - want).max() < 1e-5 + 10 * 3 * max(w, h) * 2.0**-23, (w, h, f)


def test_every_level_of_every_size_is_where_the_table_says(kernel_runner, store):
    """Footprints of exactly one level: mip tail addressing, page borders of levels, three-tap halving of odd sizes."""
    tables, images, pyramids = store
    for index, (w, h, f, _) in enumerate(images):
        for level, texels in enumerate(pyramids[index]):
            lh, lw = texels.shape[:2]
            y, x = np.mgrid[0:lh, 0:lw]
            uv = np.stack([(x.ravel() + 0.5) / lw, (y.ravel() + 0.5) / lh], -1).astype(np.float32)
            got = read(kernel_runner, tables, index, uv, 2.0**level / max(w, h), CLAMP, CLAMP)
            assert np.abs(got - texels.reshape(-1, 4)).max() < 2e-4, (w, h, f, level)
            got = read(kernel_runner, tables, index, uv, 2.0**level / max(w, h), CLAMP, CLAMP, CLOSEST)
            assert np.abs(got - texels.reshape(-1, 4)).max() < (1e-6 if f != "rgba16" else 1e-7), (w, h, f, level)


def test_halving_is_a_box_filter(kernel_runner):
    from _kernel_runner import halve_level

    for w, h in SIZES:
        for f, half_step in PRECISION.items():
            texels = image(w, h, f, 77)
            half = np.frombuffer(halve_level(texels.tobytes(), w, h, f), texels.dtype)
            half = as_float(half.reshape(max(1, h // 2), max(1, w // 2), 4))
            want = halve_axis(halve_axis(as_float(texels), 0), 1)
            assert np.abs(half - want).max() < half_step + 1e-5, (w, h, f)


def test_levels_blend(kernel_runner, store):
    tables, images, pyramids = store
    rng = np.random.default_rng(9)
    for index, (w, h, f, _) in enumerate(images):
        uv = (rng.random((256, 2)) * 2 - 0.5).astype(np.float32)
        footprint = (2.0 ** (rng.random(256) * 12 - 10)).astype(np.float32)
        got = read(kernel_runner, tables, index, uv, footprint, REPEAT, REPEAT)
        want = reference(pyramids[index], uv.astype(float), footprint.astype(float), REPEAT, REPEAT)
        # A footprint rounded by 2^-22 moves the blend by as much, times the largest step between levels.
        assert np.abs(got - want).max() < 1e-4 + 10 * 2 * max(w, h) * 2.0**-23, (w, h, f)


def test_the_smallest_level_is_the_mean(kernel_runner, store):
    tables, images, _ = store
    for index, (w, h, f, texels) in enumerate(images):
        got = read(kernel_runner, tables, index, np.full((1, 2), 0.3), 4.0, REPEAT, REPEAT)[0]
        mean = as_float(texels).mean((0, 1))
        levels = int(np.log2(max(w, h))) + 1
        assert np.abs(got - mean).max() < levels * PRECISION[f] + 1e-5, (w, h, f)


def test_halving_keeps_gradients_in_place(kernel_runner):
    """A linear ramp of an odd width: each level's texel is the ramp's value at the texel's centre."""
    from _kernel_runner import halve_level

    width = 37
    ramp = np.zeros((1, width, 4), np.float16)
    ramp[0, :, :] = ((np.arange(width) + 0.5) / width)[:, None]
    half = np.frombuffer(halve_level(ramp.tobytes(), width, 1, "rgba16f"), np.float16).reshape(1, width // 2, 4)
    centres = (np.arange(width // 2) + 0.5) / (width // 2)
    assert np.abs(half[0, :, 0] - centres).max() < 1e-3


def closest(level: np.ndarray, uv: np.ndarray, wrap_u: int, wrap_v: int) -> np.ndarray:
    height, width = level.shape[:2]
    at = np.floor(uv * np.array([width, height])).astype(int)
    x, inside_x = wrapped(at[:, 0], width, wrap_u)
    y, inside_y = wrapped(at[:, 1], height, wrap_v)
    return np.where((inside_x & inside_y)[:, None], level[y, x], OUTSIDE.astype(float))


def spline(f: np.ndarray) -> np.ndarray:
    """Weights of texels -1 to 2 of a uniform cubic B-spline, by its basis functions."""
    return np.stack([(1 - f) ** 3, 3 * f**3 - 6 * f**2 + 4, -3 * f**3 + 3 * f**2 + 3 * f + 1, f**3], -1) / 6


def bicubic(level: np.ndarray, uv: np.ndarray, wrap_u: int, wrap_v: int) -> np.ndarray:
    height, width = level.shape[:2]
    p = uv * np.array([width, height]) - 0.5
    base = np.floor(p).astype(int)
    weights = spline(p - base)
    total = np.zeros((len(uv), 4))
    for i in range(4):
        for j in range(4):
            x, inside_x = wrapped(base[:, 0] + i - 1, width, wrap_u)
            y, inside_y = wrapped(base[:, 1] + j - 1, height, wrap_v)
            texel = np.where((inside_x & inside_y)[:, None], level[y, x], OUTSIDE.astype(float))
            total += (weights[:, 0, i] * weights[:, 1, j])[:, None] * texel
    return total


@pytest.mark.parametrize("wrap", [(REPEAT, REPEAT), (CLAMP, MIRROR), (BLACK, CLAMP)])
def test_closest_and_cubic_reads(kernel_runner, store, wrap):
    tables, images, pyramids = store
    for index, (w, h, f, _) in enumerate(images):
        uv = uvs(w, h, 256, index)
        # The middle of what float32 makes of a texel's border is not defined: those places are left out.
        inner = uv[np.all(np.abs(np.mod(uv * np.array([w, h]) + 0.5, 1) - 0.5) > 1e-3, -1)]
        got = read(kernel_runner, tables, index, inner, 0.0, *wrap, CLOSEST)
        want = closest(pyramids[index][0], inner.astype(float), *wrap)
        assert np.abs(got - want).max() < 1e-6, (w, h, f)
        got = read(kernel_runner, tables, index, uv, 0.0, *wrap, CUBIC)
        want = bicubic(pyramids[index][0], uv.astype(float), *wrap)
        # As linear reads, four times: the places of the linear reads are rounded too.
        assert np.abs(got - want).max() < 2e-5 + 20 * 3 * max(w, h) * 2.0**-23, (w, h, f)


def test_closest_and_cubic_reads_of_coarser_levels(kernel_runner, store):
    """Closest takes the level that is nearest in log2 of the footprint, cubic blends the two around it."""
    tables, images, pyramids = store
    rng = np.random.default_rng(4)
    for index, (w, h, f, _) in enumerate(images):
        if (w, h) not in ((65, 65), (257, 257), (100, 37)):
            continue
        for lod in (1.3, 1.7, 2.0):
            uv = (np.floor(rng.random((128, 2)) * 4096) / 4096 + 1 / 8192).astype(np.float32)
            footprint = 2.0**lod / max(w, h)
            low = int(lod)
            got = read(kernel_runner, tables, index, uv, footprint, REPEAT, REPEAT, CLOSEST)
            level = pyramids[index][round(lod)]
            edge = np.abs(np.mod(uv * level.shape[1::-1] + 0.5, 1) - 0.5).min(-1) < 1e-3
            assert np.abs(got - closest(level, uv.astype(float), REPEAT, REPEAT))[~edge].max() < 1e-6, (w, h, f)
            got = read(kernel_runner, tables, index, uv, footprint, REPEAT, REPEAT, CUBIC)
            fine, coarse = (bicubic(pyramids[index][k], uv.astype(float), REPEAT, REPEAT) for k in (low, low + 1))
            want = fine + (lod - low) * (coarse - fine)
            assert np.abs(got - want).max() < 2e-4, (w, h, f, lod)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf, 1e30, -1e30])
def test_wild_coordinates_give_finite_texels(kernel_runner, store, bad):
    tables, _, _ = store
    for wrap in (REPEAT, CLAMP, MIRROR, BLACK):
        uv = np.array([[bad, 0.5], [0.5, bad], [bad, bad]], np.float32)
        got = read(kernel_runner, tables, 41, uv, 0.0, wrap, wrap)
        assert np.isfinite(got).all()
        assert (got >= -2.001).all() and (got <= 8.001).all()
    got = read(kernel_runner, tables, 41, np.full((3, 2), 0.5), np.array([np.inf, -1.0, 0.0]), REPEAT, REPEAT)
    assert np.isfinite(got).all()


def test_a_missing_texture_reads_as_outside(kernel_runner, store):
    got = read(kernel_runner, store[0], 0xFFFFFFFF, np.full((2, 2), 0.5), 0.0, CLAMP, CLAMP)
    assert (got == OUTSIDE).all()


def test_textures_that_do_not_fit_are_halved_with_a_diagnostic(kernel_runner):
    """Half the budget takes 1984 blocks: 342 pages of halfs take two each, and 1366 of bytes do not fit beside."""
    from _kernel_runner import scene_tables

    large, other = image(2048, 2048, "rgba8"), image(1024, 1024, "rgba16f")
    images = [(2048, 2048, "rgba8", large.tobytes()), (1024, 1024, "rgba16f", other.tobytes())]
    tables = scene_tables([], images, [], 1.0, 64 << 20)
    assert [d[0] for d in tables["diagnostics"]] == ["texture-reduced"]
    assert "1024 x 1024" in tables["diagnostics"][0][2]
    sizes = np.frombuffer(tables["textureRecords"], np.uint32).reshape(-1, 4)[:2, :2]
    assert sizes.tolist() == [[1024, 1024], [1024, 1024]]
    uv = (np.random.default_rng(3).integers(0, 1024, (256, 2)) + 0.5).astype(np.float32) / 1024
    for index, level in ((0, pyramid(large)[1]), (1, as_float(other))):
        got = read(kernel_runner, tables, index, uv, 0.0, CLAMP, CLAMP)
        x, y = (uv * 1024).astype(int).T
        assert np.abs(got - level[y, x]).max() < 1e-5


BIG = {"a": image(512, 512, "rgba8", 1), "b": image(512, 512, "rgba8", 2), "c": image(256, 256, "rgba16f", 3)}
BLOCK = 16912


def limited(order: str, commits: list[tuple[int, int]], gone: int = 0):
    """(size by name, what the diagnostics say, tables)"""
    from _kernel_runner import scene_tables

    kinds = [(BIG[n].shape[1], BIG[n].shape[0], "rgba16f" if n in "cd" else "rgba8", BIG[n].tobytes()) for n in order]
    tables = scene_tables([], kinds, [], 1.0, names=list(order), commits=commits, gone=gone)
    said = [(where, int(text.split()[-1])) for _, where, text in tables["diagnostics"]]
    sizes = np.frombuffer(tables["textureRecords"], np.uint32).reshape(-1, 4)[: len(order), :2].tolist()
    return dict(zip(order, sizes, strict=True)), said, tables


def same_texels(runner, a, b, textures) -> bool:
    uv = np.random.default_rng(8).random((256, 2)).astype(np.float32)
    reads = [[read(runner, t, k, uv, f, CLAMP, CLAMP) for k in textures for f in (0.0, 0.01, 0.1)] for t in (a, b)]
    return bool((np.array(reads[0]) == np.array(reads[1])).all())


def test_the_memory_for_textures_is_kept_whatever_the_order(kernel_runner):
    """512 x 512 takes 86 pages of bytes (64 + 16 + 4 + 1 + 1), 256 x 256 22 of halfs, which are two blocks each."""
    for order in ("abc", "cba", "bac"):
        got, said, tables = limited(order, [(3, 216 * BLOCK)])
        assert said == [] and tables["poolBytes"] == 216 * BLOCK
        # One block short: the first of the two largest by name is halved, to 22 pages.
        got, said, _ = limited(order, [(3, 215 * BLOCK)])
        assert got == {"a": [256, 256], "b": [512, 512], "c": [256, 256]}
        assert said == [("a", 256)]
        # Then the other one, then halfs (44 blocks), then bytes again; each is said once.
        got, said, tables = limited(order, [(3, 45 * BLOCK)])
        assert got == {"a": [128, 128], "b": [256, 256], "c": [128, 128]}
        assert said == [("a", 128), ("b", 256), ("c", 128)]
        assert tables["poolBytes"] <= 45 * BLOCK


def test_textures_on_the_device_make_room_for_those_that_come_later(kernel_runner):
    """The same picture as if all had come at once, to the texel; the pool never grows past what it may take."""
    limit = 100 * BLOCK
    at_once, _, whole = limited("abc", [(3, limit)])
    later, said, parts = limited("abc", [(2, 0), (3, limit)])
    assert at_once == later == {"a": [256, 256], "b": [256, 256], "c": [256, 256]}
    assert said == [("a", 256), ("b", 256)]
    assert same_texels(kernel_runner, whole, parts, range(3))
    assert parts["poolBytes"] <= limit
    # A limit that an edit sets: what is held shrinks, and comes back, where there is more again, as it is read again.
    edited, said, cut = limited("abc", [(3, 0), (3, limit), (3, 0)])
    assert edited == at_once and said == [("a", 256), ("b", 256)]
    assert same_texels(kernel_runner, whole, cut, range(3)) and cut["poolBytes"] <= limit


@pytest.mark.parametrize("order", ["abc", "cba"])
@pytest.mark.parametrize(
    ("held", "limit", "expected"),
    [
        (100, 0, {"a": 512, "b": 512}),  # no limit
        (100, 216, {"a": 512, "b": 512}),
        (100, 215, {"b": 512}),  # as if all came at once: a is the one that is halved
        (45, 100, {"a": 256, "b": 256, "c": 256}),  # b is read at 256 already
        (100, 100, {}),
        (100, 45, {}),
    ],
)
def test_more_memory_brings_back_what_it_has_room_for(kernel_runner, order, held, limit, expected):
    """What says that it is coarse, created anew, is as large as if all had come at once, and does not say so again."""
    from _kernel_runner import scene_tables

    def sizes(tables):
        return np.frombuffer(tables["textureRecords"], np.uint32).reshape(-1, 4)[:, 0].tolist()

    kinds = [(BIG[n].shape[1], BIG[n].shape[0], "rgba16f" if n == "c" else "rgba8", BIG[n].tobytes()) for n in order]
    start = sizes(scene_tables([], kinds, [], 1.0, names=list(order), commits=[(3, held * BLOCK)]))
    tables = scene_tables([], kinds, [], 1.0, names=list(order), commits=[(3, held * BLOCK)], again=limit * BLOCK)
    got = dict(zip(order, sizes(tables)[:3], strict=True))
    for place, texture in enumerate(tables["coarse"]):
        assert start[texture] < sizes(tables)[3 + place]
        got[order[texture]] = sizes(tables)[3 + place]
    at_once = sizes(scene_tables([], kinds, [], 1.0, names=list(order), commits=[(3, limit * BLOCK)]))
    assert got == dict(zip(order, at_once, strict=True))
    assert {n: got[n] for n in (order[t] for t in tables["coarse"])} == {
        n: s for n, s in expected.items() if s > start[order.index(n)]
    }
    assert tables["stillCoarse"] == []


def test_holes_in_the_pool_are_closed_before_it_passes_the_limit(kernel_runner):
    """Texture a leaves 86 blocks free below b. Of c and two d, 44 each, one fits there; all three only if b moves."""
    BIG["d"] = image(256, 256, "rgba16f", 4)
    got, said, tables = limited("abcdd", [(2, 0), (5, 220 * BLOCK)], gone=1)
    assert said == [] and got["b"] == [512, 512]
    assert tables["poolBytes"] <= 220 * BLOCK
    _, _, fresh = limited("abcdd", [(5, 0)])
    assert same_texels(kernel_runner, tables, fresh, range(1, 5))


def test_more_small_textures_than_memory_say_so(kernel_runner):
    from _kernel_runner import scene_tables

    one = np.zeros((64, 64, 4), np.uint8).tobytes()
    tables = scene_tables([], [(64, 64, "rgba8", one)] * 5, [], 1.0, commits=[(5, BLOCK)])
    assert [d[0] for d in tables["diagnostics"]] == ["texture-memory"]


TILES = """void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= outputs.length()) return;
  vec2 uv = inputs[i * IN].xy;
  uint tile = textureTile(floatBitsToUint(inputs[i * IN].w), uv);
  outputs[i] = textureExists(tile) ? textureRead(tile, uv, 0.0, kWrapClamp, kWrapClamp, vec4(9.0)) : vec4(-1.0);
}"""


def test_tiles_of_a_set_are_found_by_their_udim_number(kernel_runner):
    from _kernel_runner import scene_tables

    colors = [np.full((4, 4, 4), 10 * (k + 1), np.uint8) for k in range(3)]
    numbers = [1001, 1003, 1012]  # the second row's second; 1002 and 1011 are not there
    tables = scene_tables(
        [], [(4, 4, "rgba8", c.tobytes()) for c in colors], [], 1.0, tiles=[[(n, k) for k, n in enumerate(numbers)]]
    )
    places = {(0.5, 0.5): 10, (2.25, 0.99): 20, (1.5, 1.5): 30, (1.5, 0.5): None, (0.5, 1.5): None}
    places |= {(-0.5, 0.5): None, (3.5, 0.5): None, (0.5, 2.5): None, (np.nan, 0.5): None, (np.inf, 0.5): None}
    inputs = np.zeros((len(places), 4), np.float32)
    inputs[:, :2] = list(places)
    inputs[:, 3] = bits(np.full(len(places), 3, np.uint32))
    got = call(kernel_runner, ["lib/textures.glsl"], TILES, inputs, 1, {k: tables[k] for k in TABLES})
    want = [-1.0 if v is None else v / 255 for v in places.values()]
    assert np.abs(got[:, 0] - want).max() < 1e-6


@pytest.mark.parametrize("broken", [(0, 0, b""), (0, 5, b""), (4, 4, b"short")])
def test_a_broken_image_is_magenta_with_a_diagnostic(kernel_runner, broken):
    from _kernel_runner import scene_tables

    tables = scene_tables([], [(broken[0], broken[1], "rgba8", broken[2])], [], 1.0)
    assert [d[0] for d in tables["diagnostics"]] == ["texture-empty"]
    got = read(kernel_runner, tables, 0, np.full((1, 2), 0.5), 0.0, CLAMP, CLAMP)
    assert np.allclose(got, [[1, 0, 1, 1]])
