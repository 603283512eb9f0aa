# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Distant and dome lights, emissive triangles and the choice among light items, against quadrature in numpy."""

from __future__ import annotations

import numpy as np
import pytest
from core_harness import NO_LIGHT, bits, call, chi2_p
from light_cases import MIRROR, ROTATED, SHEAR, Case, affine, bilinear_clamped, rotation

INCLUDES = ["lib/lights/light_table.glsl"]
TABLES = (
    "lightRecords",
    "lightItems",
    "lightDistribution",
    "textureRecords",
    "pageTable",
    "texturePages",
)
MAIN = """void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i * OUT >= outputs.length()) return;
  Light l = lightLoad(0u);
  bool dome = l.type == kLightDome;
  vec3 d = inputs[i * IN].xyz;
  LightSample s;
  s.direction = d; s.pdf = 0.0;
  if (inputs[i * IN].w > 0.0) {
    if (dome) s = sampleDome(l, d.xy); else s = sampleDistant(l, d.xy);
  }
  outputs[i * OUT] = vec4(s.direction, s.pdf);
  float hit = dome ? domePdf(l, s.direction) : distantPdf(l, s.direction);
  outputs[i * OUT + 1u] = vec4(lightRadiance(l, -s.direction, vec3(0.0), 0.0), hit);
}"""


class Infinite:
    """One distant or dome light."""

    def __init__(self, runner, data: dict, texture: np.ndarray | None = None):
        from _kernel_runner import scene_tables

        textures = []
        if texture is not None:
            kind = "rgba8" if texture.dtype == np.uint8 else "rgba16f"
            textures = [(texture.shape[1], texture.shape[0], kind, texture.tobytes())]
            data = data | {"texture": 0}
        self.runner = runner
        self.tables = scene_tables([data | {"path": "/light"}], textures, [], 10.0)
        assert self.tables["diagnostics"] == [] and self.tables["infiniteCount"] == 1

    def _call(self, vectors: np.ndarray, sample: bool) -> np.ndarray:
        inputs = np.zeros((len(vectors), 4), np.float32)
        inputs[:, : vectors.shape[1]] = vectors
        inputs[:, 3] = sample
        tables = {k: self.tables[k] for k in TABLES}
        return call(self.runner, INCLUDES, MAIN, inputs, 2, tables).astype(float)

    def sample(self, u: np.ndarray) -> np.ndarray:
        return self._call(u, True)

    def evaluate(self, directions: np.ndarray) -> np.ndarray:
        return self._call(directions, False)


def sphere_grid(rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Midpoints in cos(theta) and phi about +Y, all of equal solid angle."""
    z = 1 - 2 * (np.arange(rows) + 0.5) / rows
    phi = 2 * np.pi * (np.arange(2 * rows) + 0.5) / (2 * rows)
    zz, pp = (a.ravel() for a in np.meshgrid(z, phi, indexing="ij"))
    r = np.sqrt(1 - zz * zz)
    return np.stack([r * np.cos(pp), zz, r * np.sin(pp)], -1), np.full(len(zz), 4 * np.pi / len(zz))


def latlong_grid(texture: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """Directions in dome space whose cells divide the texels of the texture evenly, and their solid angles."""
    h, w = (64, 128) if texture is None else texture.shape[:2]
    sub = max(1, 1024 // w)
    v, u = (np.arange(h * sub) + 0.5) / (h * sub), (np.arange(w * sub) + 0.5) / (w * sub)
    theta, phi = (a.ravel() for a in np.meshgrid(np.pi * (1 - v), 2 * np.pi * u - np.pi / 2, indexing="ij"))
    edges = np.cos(np.pi * np.arange(h * sub + 1) / (h * sub))
    solid = np.repeat(edges[:-1] - edges[1:], w * sub) * 2 * np.pi / (w * sub)
    return np.stack([np.sin(theta) * np.cos(phi), np.cos(theta), np.sin(theta) * np.sin(phi)], -1), solid


def stratified(side: int, seed: int) -> np.ndarray:
    cell = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), -1).reshape(-1, 2)
    return (cell + np.random.default_rng(seed).random((side * side, 2))) / side * (1 - 1e-7)


def latlong(texture: np.ndarray, local: np.ndarray) -> np.ndarray:
    """u = .25 at +X, .5 at +Z, v = 1 at +Y: OpenEXR's latlong as UsdLuxDomeLight reads it."""
    u = np.mod((np.arctan2(local[:, 2], local[:, 0]) + np.pi / 2) / (2 * np.pi), 1)
    v = 1 - np.arccos(np.clip(local[:, 1], -1, 1)) / np.pi
    if texture.dtype != np.uint8:
        texture = texture.astype(np.float64) * 255
    return bilinear_clamped(texture, u, v, repeat_u=True)


def sky(width: int, height: int, seed: int) -> np.ndarray:
    """A dim sky with a texel a thousand times brighter, and a black lower half."""
    rng = np.random.default_rng(seed)
    texels = np.zeros((height, width, 4), np.float16)
    texels[height // 2 :] = rng.random((height - height // 2, width, 4)) * 0.5 + 0.1
    texels[int(height * 0.7), width // 3] = [900, 700, 500, 1]
    return texels


DOMES = {
    "uniform": (np.eye(3), None),
    "uniformScaled": (ROTATED @ np.diag([1, 3.0, 0.5]), None),
    "sky": (np.eye(3), sky(64, 32, 1)),
    "skyRotated": (ROTATED, sky(64, 32, 2)),
    "skyMirrored": (ROTATED @ MIRROR, sky(48, 33, 3)),
    "skyScaled": (ROTATED @ np.diag([0.2, 5.0, 2.0]), sky(64, 32, 4)),
    "skyLarge": (ROTATED, sky(1030, 520, 5)),
    "tiny": (ROTATED, sky(2, 2, 6)),
    "black": (np.eye(3), np.zeros((8, 16, 4), np.float16)),
}


def dome(runner, name: str) -> tuple[Infinite, np.ndarray, np.ndarray | None]:
    linear, texture = DOMES[name]
    light = Infinite(
        runner,
        {"type": "dome", "transform": list(affine(linear, (5, 6, 7)).T.ravel()), "radiance": [2.0, 1.0, 0.5]},
        texture,
    )
    rotated = linear / np.linalg.norm(linear, axis=0)  # these cases scale along the axes only
    return light, rotated, texture


@pytest.mark.parametrize("name", DOMES)
def test_domes_by_quadrature(kernel_runner, name):
    light, rotated, texture = dome(kernel_runner, name)
    local, solid = latlong_grid(texture)
    directions = local @ rotated.T
    seen = light.evaluate(directions)
    want = np.array([2, 1, 0.5]) * (np.ones((len(local), 1)) if texture is None else latlong(texture, local))
    # The radiance itself; a direction of floats is off by 1e-7, its polar angle by 3e-4 at the poles.
    assert np.abs(seen[:, 4:7] - want).max() < 4e-3 * want.max() + 1e-6
    # The pdf over the whole sphere.
    assert abs((seen[:, 7] * solid).sum() - 1) < 5e-3
    # Samples: pdf as for hits; integrals of the radiance against four functions.
    out = light.sample(stratified(256, 3))
    assert np.abs(np.linalg.norm(out[:, :3], axis=1) - 1).max() < 1e-5
    # At a pole, within 3e-4 of it, a direction of floats is the pole itself and the sample is lost.
    lost = out[:, 3] <= 0
    assert lost.mean() < 1e-3 and (np.linalg.norm(np.cross(out[lost, :3], rotated[:, 1]), axis=1) < 1e-3).all()
    assert (np.abs(out[:, 3] - out[:, 7]) <= 1e-5 * out[:, 3]).all()
    for f in (lambda d: np.ones(len(d)), *(lambda d, a=a: np.maximum(0, d @ a) for a in np.eye(3))):
        integral = (f(directions)[:, None] * solid[:, None] * want).sum(0)
        each = np.where(lost, 0, f(out[:, :3]) / np.where(lost, 1, out[:, 3]))[:, None] * out[:, 4:7]
        error = each.std(0) / np.sqrt(len(each))
        assert (np.abs(each.mean(0) - integral) < 6e-3 * integral + 1.5 * error + 1e-6).all(), (
            each.mean(0),
            integral,
            error,
        )


@pytest.mark.parametrize("name", ["sky", "skyMirrored", "skyLarge", "uniformScaled"])
def test_dome_samples_follow_the_pdf(kernel_runner, name):
    light, rotated, _ = dome(kernel_runner, name)
    local, solid = latlong_grid(DOMES[name][1])
    directions = local @ rotated.T

    def cells(d):
        z = np.clip((1 - d[:, 1]) / 2 * 16, 0, 15).astype(int)
        a = np.mod(np.arctan2(d[:, 2], d[:, 0]) / (2 * np.pi), 1) * 32
        return z * 32 + np.clip(a, 0, 31).astype(int)

    n = 1 << 15
    expected = np.bincount(cells(directions), light.evaluate(directions)[:, 7] * solid, minlength=512) * n
    out = light.sample(np.random.default_rng(4).random((n, 2)) * (1 - 1e-7))
    counts = np.bincount(cells(out[:, :3]), minlength=512)
    expected *= n / expected.sum()
    # The bright texel is smaller than the grid sees: its cells are known to the grid within 3 %.
    variance = expected + (0.03 * expected) ** 2 * (expected > 0.1 * n)
    big = expected > 20
    statistic = float(((counts - expected) ** 2 / variance)[big].sum())
    assert chi2_p(statistic, int(big.sum()) - 1) > 1e-5


def test_importance_finds_the_bright_texel(kernel_runner):
    """The sun holds most of the light: most samples go there, and the estimate hardly varies."""
    light, _, _ = dome(kernel_runner, "sky")
    out = light.sample(stratified(64, 1))
    luminance = out[:, 4:7] @ [0.2126, 0.7152, 0.0722]
    assert np.mean(luminance > 20) > 0.4
    weight = luminance / out[:, 3]
    assert weight.std() < 1.5 * weight.mean()


def test_dome_orientation(kernel_runner):
    """u = .25 at +X, .5 at +Z, .75 at -X, 0 at -Z; v up."""
    texture = np.zeros((64, 128, 4), np.float16)
    texture[16:48, 24:40] = [1, 0, 0, 1]  # about u = .25
    texture[16:48, 56:72] = [0, 1, 0, 1]  # about u = .5
    texture[16:48, 88:104] = [0, 0, 1, 1]  # about u = .75
    texture[16:48, :8] = texture[16:48, 120:] = [1, 1, 0, 1]  # about u = 0
    texture[60:] = [0, 1, 1, 1]  # up
    texture[:4] = [1, 0, 1, 1]  # down
    light = Infinite(kernel_runner, {"type": "dome", "radiance": [1.0, 1.0, 1.0]}, texture)
    axes = np.array([[1, 0, 0], [0, 0, 1], [-1, 0, 0], [0, 0, -1], [0, 1, 0], [0, -1, 0.0]])
    seen = light.evaluate(axes)[:, 4:7]
    assert np.allclose(seen, [[1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 0], [0, 1, 1], [1, 0, 1]], atol=1e-3)


@pytest.mark.parametrize("angle", [0.0, 0.53, 10.0, 90.0, 180.0, 300.0])
@pytest.mark.parametrize("shape", ["rotated", "sheared"])
def test_distant_lights(kernel_runner, angle, shape):
    linear = ROTATED if shape == "rotated" else ROTATED @ SHEAR @ np.diag([2.0, 1, 0.3])
    light = Infinite(
        kernel_runner,
        {
            "type": "distant",
            "angle": float(np.radians(angle)),
            "transform": list(affine(linear).T.ravel()),
            "radiance": [3.0, 2.0, 1.0],
        },
    )
    axis = linear @ [0, 0, 1.0]
    axis /= np.linalg.norm(axis)
    out = light.sample(stratified(128, 2))
    half = np.radians(angle) / 2
    offset = np.linalg.norm(out[:, :3] - axis, axis=1)
    assert offset.max() <= 2 * np.sin(max(half, 1.1e-4) / 2) + 1e-6
    assert (out[:, 3] > 0).all() and np.allclose(out[:, 3], out[:, 7], rtol=1e-5)
    irradiance = (np.maximum(out[:, :3] @ axis, 0) / out[:, 3])[:, None] * out[:, 4:7]
    # A cone of half angle a gives L pi sin^2 a (a hemisphere and more: L pi); angle 0 gives L itself.
    form = 1.0 if angle == 0 else np.pi * np.sin(min(half, np.pi / 2)) ** 2
    assert np.allclose(irradiance.mean(0), np.array([3, 2, 1]) * form, rtol=2e-3)
    if angle >= 10:
        directions, solid = sphere_grid(512)
        assert abs((light.evaluate(directions)[:, 7] * solid).sum() - 1) < 2e-2


# ---- Light items: emissive triangles and the choice -------------------------------------------------------------

ITEMS = """void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i * OUT >= outputs.length()) return;
  vec3 p = inputs[i * IN].xyz;
  vec4 u = inputs[i * IN + 1u];
  float probability;
  uint item = pickLightItem(p, u.z, probability);
  vec3 radiance;
  LightSample s = sampleLightItem(item, probability, p, u.xy, 0.0, radiance);
  outputs[i * OUT] = vec4(s.direction, s.distance);
  outputs[i * OUT + 1u] = vec4(radiance, s.pdf);
  uvec4 it = lightItem(item);
  vec3 p0 = vec3(0.0), e1 = vec3(0.0), e2 = vec3(0.0);
  if (it.y != kNoLight) lightTriangle(it, p0, e1, e2);
  float pdf = it.y != kNoLight ? trianglePdf(e1, e2, s.direction, s.distance) * lightItemProbability(item, p) : 0.0;
  outputs[i * OUT + 2u] = vec4(float(item), pdf, probability, float(it.w));
}"""


def emissive_scene(runner, lights=(), count=5, seed=1):
    """Triangles of two instances (records 0 .. count - 1) and the tables."""
    from _kernel_runner import scene_tables

    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(count, 3, 3)) * 0.5
    transforms = [affine(ROTATED @ SHEAR, (0, 0, 4)), affine(ROTATED @ MIRROR @ np.diag([1, 2, 0.5]), (2, 0, 3))]
    world = [np.einsum("tck,jk->tcj", corners, m[:3, :3]) + m[:3, 3] for m in transforms]
    area = [np.linalg.norm(np.cross(w[:, 1] - w[:, 0], w[:, 2] - w[:, 0]), axis=1) / 2 for w in world]
    records = np.arange(count, dtype=np.int64)
    records[2] = NO_LIGHT  # this triangle's material does not emit
    emissive = [
        (i, [int(r) for r in records], [float(a) for a in area[i]], [float(x) for x in world[i].ravel()])
        for i in range(2)
    ]
    tables = scene_tables(list(lights), [], emissive, 10.0, light_sampling="power")
    triangle = np.zeros((count, 3, 4), np.float32)
    triangle[:, :, :3] = corners
    instance = np.zeros((2, 9, 4), np.float32)
    for i, m in enumerate(transforms):
        instance[i, 0:3], instance[i, 4:7] = np.linalg.inv(m)[:3], m[:3]
    device = {k: tables[k] for k in TABLES} | {"triangleRecords": triangle, "instanceRecords": instance}
    return tables, device, world, area, records


def pick(runner, tables, device, p, u) -> np.ndarray:
    inputs = np.zeros((len(u), 8), np.float32)
    inputs[:, :3] = p
    inputs[:, 4:7] = u
    values = {"lightItemCount": tables["itemCount"]}
    return call(runner, INCLUDES, ITEMS, inputs, 3, device, values).astype(float)


def test_emissive_triangles_by_quadrature(kernel_runner):
    tables, device, world, _, records = emissive_scene(kernel_runner)
    assert tables["itemCount"] == 10 and list(tables["itemBases"]) == [0, 5]
    p, n = np.array([0.5, -0.3, 0.0]), np.array([0.0, 0, 1])
    rng = np.random.default_rng(7)
    u = np.column_stack([stratified(360, 5), rng.permutation((np.arange(360**2) + 0.5) / 360**2)])
    out = pick(kernel_runner, tables, device, p, u)
    item = out[:, 8].astype(int)
    assert not np.isin(item, [2, 7]).any()  # what does not emit is never picked
    assert np.allclose(out[:, 9], out[:, 7], rtol=1e-5)  # the pdf that an emissive hit uses is the sampler's
    assert (out[:, 11] == item % 5).all()
    # Both sides shine: integral of cos over each triangle's solid angle (Lambert's formula, by absolute value).
    want = 0.0
    for w in world:
        for t, corner in enumerate(w):
            if records[t] == NO_LIGHT:
                continue
            v = corner - p
            v /= np.linalg.norm(v, axis=1, keepdims=True)
            total = 0.0
            for a, b in zip(v, np.roll(v, -1, 0), strict=True):
                cross = np.cross(a, b)
                total += np.arctan2(np.linalg.norm(cross), a @ b) * (cross @ n) / np.linalg.norm(cross)
            assert (v @ n > 0).all()
            want += abs(total) / 2
    each = np.maximum(out[:, :3] @ n, 0) / out[:, 7]
    error = each.std() / np.sqrt(len(each))
    assert abs(each.mean() - want) < 2 * error + 1e-3 * want
    assert error < 0.01 * want


def test_triangle_samples_are_uniform_in_area(kernel_runner):
    tables, device, world, _, _ = emissive_scene(kernel_runner)
    u = np.column_stack([np.random.default_rng(1).random((40000, 2)) * (1 - 1e-7), np.full(40000, 1e-4)])
    out = pick(kernel_runner, tables, device, np.zeros(3), u)
    assert (out[:, 8] == 0).all()
    a, b, c = world[0][0]
    q = out[:, :3] * out[:, 3:4] - a
    coordinates = np.linalg.lstsq(np.column_stack([b - a, c - a]), q.T, rcond=None)[0].T
    assert coordinates.min() > -1e-4 and coordinates.sum(1).max() < 1 + 1e-4
    # Into 16 equal triangles by two halvings of every edge.
    cell = np.clip((coordinates * 4).astype(int), 0, 3)
    upper = (coordinates * 4 - cell).sum(1) > 1
    counts = np.bincount(cell[:, 0] * 8 + cell[:, 1] * 2 + upper, minlength=32)
    counts = counts[counts > 20]
    assert len(counts) == 16
    assert chi2_p(float(((counts - 2500) ** 2 / 2500).sum()), 15) > 1e-5


def test_every_light_is_picked_as_often_as_it_says(kernel_runner):
    lights = [
        Case("a", "rect", affine(np.eye(3), (0, 0, 3))).record(None),
        Case("b", "sphere", affine(np.eye(3), (1, 0, 3)), radiance=(0.01, 0.01, 0.01)).record(None),
        {"type": "distant", "path": "/c", "angle": 0.01},
        {"type": "dome", "path": "/d"},
        Case("dark", "disk", radiance=(0, 0, 0)).record(None),
    ]
    tables, device, _, area, records = emissive_scene(kernel_runner, lights)
    assert tables["infiniteCount"] == 2 and tables["itemCount"] == 15
    items = np.frombuffer(tables["lightItems"], np.uint32).reshape(-1, 4)
    probability = items[:, 2].copy().view(np.float32).astype(float)
    assert abs(probability.sum() - 1) < 1e-6
    assert list(items[:5, 0]) == [0, 1, 2, 3, 4] and (items[:5, 1] == NO_LIGHT).all()
    assert probability[4] == 0  # the dark one (last by path)
    assert probability[1] == 0  # the sky is of one colour: bounce rays find it
    assert (probability[[0, 2, 3]] > 0.04).all()  # no light starves
    assert (probability[[7, 12]] == 0).all()
    live = records != NO_LIGHT
    assert np.allclose(probability[5:10][live] / probability[5], area[0][live] / area[0][0], rtol=1e-3)
    n = 200000
    u = np.zeros((n, 3))
    u[:, 2] = (np.arange(n) + 0.5) / n
    out = pick(kernel_runner, tables, device, np.zeros(3), u)
    frequency = np.bincount(out[:, 8].astype(int), minlength=15) / n
    assert np.abs(frequency - probability).max() < 2 / n + 1e-6
    assert np.allclose(out[:, 10], probability[out[:, 8].astype(int)])


def test_order_of_arrival_does_not_show(kernel_runner):
    from _kernel_runner import scene_tables

    lights = [Case(name, "rect", affine(rotation((0, 1, 0), 10 * i))).record(None) for i, name in enumerate("abcd")]
    one = scene_tables(lights, [], [], 1.0)
    two = scene_tables(lights[::-1], [], [], 1.0)
    assert one["lightRecords"] == two["lightRecords"] and one["lightDistribution"] == two["lightDistribution"]


def test_without_light_there_are_no_items(kernel_runner):
    from _kernel_runner import scene_tables

    tables = scene_tables([Case("dark", "rect", radiance=(0, 0, 0)).record(None)], [], [], 1.0)
    assert tables["itemCount"] == 0 and tables["lightCount"] == 1
    assert bits([0]).size == 1


def test_light_samples_know_their_lights_group(kernel_runner):
    from _kernel_runner import scene_tables

    lights = [
        {"path": "/a", "type": "rect", "lightGroup": 7},
        {"path": "/b", "type": "distant", "lightGroup": 255},
        {"path": "/c", "type": "sphere"},
    ]
    tables = scene_tables(lights, [], [], 10.0)
    main = """void main() {
      uint i = gl_GlobalInvocationID.x;
      if (i * OUT >= outputs.length()) return;
      uvec4 item = lightItem(i);
      outputs[i * OUT] = vec4(float(lightItemGroup(i)), float(lightGroup(lightLoad(item.x).flags)), 0.0, 0.0);
    }"""
    inputs = np.zeros((len(lights), 4), np.float32)
    includes = ["lib/contribute.glsl", *INCLUDES]
    groups = call(kernel_runner, includes, main, inputs, 1, {k: tables[k] for k in TABLES}).reshape(3, 4)
    assert sorted(groups[:, 0]) == [0, 7, 255]
    assert (groups[:, 0] == groups[:, 1]).all()
