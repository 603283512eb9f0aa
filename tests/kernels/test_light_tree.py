# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The light tree: it picks as often as it says, never misses light that arrives, and finds what is near."""

from __future__ import annotations

import numpy as np
import pytest
from core_harness import NO_LIGHT, call
from light_cases import MIRROR, ROTATED, SHEAR, Case, affine, rotation

TABLES = ("lightRecords", "lightItems", "lightDistribution", "textureRecords", "pageTable", "texturePages")
# In: p, u of the pick; u of the point, item to ask for. Out: the picked item and its probability; the probability of the
# item asked for, and what one sample of it brings.
MAIN = """void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i * OUT >= outputs.length()) return;
  vec4 a = inputs[i * IN], b = inputs[i * IN + 1u];
  float probability;
  uint item = pickLightItem(a.xyz, a.w, probability);
  uint asked = uint(b.z);
  vec3 radiance;
  LightSample s = sampleLightItem(asked, 1.0, a.xyz, b.xy, 0.0, radiance);
  outputs[i * OUT] = vec4(float(item), probability, lightItemProbability(asked, a.xyz), s.pdf > 0.0 ? radiance.g / s.pdf : 0.0);
}"""


def mixed_lights(rng, count: int) -> list[dict]:
    """Lights of all shapes, scattered, turned, sheared and mirrored; some shaped into cones."""
    # Without shadows the dome, which is of one colour, is picked like any other.
    dome = {"type": "dome", "path": "/b", "castsShadows": False}
    lights = [{"type": "distant", "path": "/a", "angle": 0.01}, dome]
    for i in range(count):
        linear = rotation(rng.normal(size=3), rng.uniform(0, 360)) @ [np.eye(3), SHEAR, MIRROR][i % 3] * rng.uniform(0.1, 1)
        kind = ("rect", "disk", "sphere", "cylinder")[i % 4]
        cone = (rng.uniform(5, 120), 0.3) if i % 5 == 0 else None
        place = affine(linear, rng.normal(size=3) * 4)
        lights.append(Case(f"l{i:04}", kind, place, radiance=(1.0, rng.uniform(0.1, 9), 1.0), cone=cone).record(None))
    return lights


def scene(lights, sampling: str, triangles: int = 0, seed: int = 3):
    from _kernel_runner import scene_tables

    rng = np.random.default_rng(seed)
    world = rng.normal(size=(triangles, 1, 3)) * 4 + rng.normal(size=(triangles, 3, 3)) * 0.3
    area = np.linalg.norm(np.cross(world[:, 1] - world[:, 0], world[:, 2] - world[:, 0]), axis=1) / 2
    records = np.arange(triangles, dtype=np.int64)
    records[3::7] = NO_LIGHT  # these do not emit
    emissive = [(0, records.tolist(), area.tolist(), world.ravel().tolist())] if triangles else []
    tables = scene_tables(lights, [], emissive, 10.0, light_sampling=sampling)
    corners = np.zeros((max(triangles, 1), 3, 4), np.float32)
    corners[:triangles, :, :3] = world
    instance = np.zeros((1, 9, 4), np.float32)
    instance[0, 0:3] = instance[0, 4:7] = np.eye(4)[:3]
    device = {k: tables[k] for k in TABLES} | {"triangleRecords": corners, "instanceRecords": instance}
    return tables, device


def run(runner, tables, device, p, u, point=None, asked=None) -> np.ndarray:
    inputs = np.zeros((len(u), 8), np.float32)
    inputs[:, :3], inputs[:, 3] = p, u
    inputs[:, 4:6] = 0.5 if point is None else point
    inputs[:, 6] = 0 if asked is None else asked
    values = {
        "lightItemCount": tables["itemCount"],
        "infiniteLightCount": tables["infiniteCount"],
        "lightTree": tables["lightTree"],
    }
    return call(runner, ["lib/lights/light_table.glsl"], MAIN, inputs, 1, device, values).astype(float)


POINTS = [(0, 0, 0), (0.3, -1, 2), (30, 0, 5), (-4, 4, 4)]


def test_every_light_is_picked_as_often_as_it_says(kernel_runner):
    tables, device = scene(mixed_lights(np.random.default_rng(1), 90), "auto", triangles=40)
    count, n = tables["itemCount"], 100000
    assert count == 2 + 90 + 40 and tables["lightTree"] == count
    for p in POINTS:
        out = run(kernel_runner, tables, device, p, (np.arange(n) + 0.5) / n)
        says = run(kernel_runner, tables, device, p, np.zeros(count), asked=np.arange(count))[:, 2]
        picked = out[:, 1] > 0
        assert picked.mean() > 0.99  # from inside all of it something is always there
        frequency = np.bincount(out[picked, 0].astype(int), minlength=count) / n
        # Every item's share is an interval of u, at most stirred once on the way down.
        assert np.abs(frequency - says)[says * n > 20].max() < 0.01
        deviation = (frequency - says) / np.sqrt(np.maximum(says, 1e-12) / n)
        assert np.abs(deviation[says * n > 20]).max() < 5
        assert abs(says.sum() - picked.mean()) < 1e-3
        assert np.allclose(out[picked, 1], says[out[picked, 0].astype(int)], rtol=1e-4)
        assert (frequency[says == 0] == 0).all()


def test_what_is_never_picked_sends_no_light(kernel_runner):
    """Bounds are bounds: where an item's probability is 0, no sample of it brings anything."""
    rng = np.random.default_rng(2)
    tables, device = scene(mixed_lights(rng, 120), "tree", triangles=30)
    count = tables["itemCount"]
    never = seen = 0
    for p in [*POINTS, *(rng.normal(size=(12, 3)) * 5)]:
        asked = np.repeat(np.arange(2, count), 40)
        out = run(kernel_runner, tables, device, p, np.zeros(len(asked)), rng.random((len(asked), 2)) * 0.999, asked)
        brings, probability = out[:, 3].reshape(-1, 40).max(1), out[::40, 2]
        assert (brings[probability == 0] == 0).all()
        never += (probability == 0).sum()
        seen += (brings > 0).sum()
    assert never > 100 and seen > 300  # both were there to be told apart


@pytest.mark.parametrize("case", ["line", "same place", "doubling"])
def test_trees_stay_shallow(kernel_runner, case):
    """Places that no plane parts well: trails have 32 bits."""
    n = 3000
    x = {"line": np.arange(n), "same place": np.zeros(n), "doubling": 2.0 ** (np.arange(n) / 40.0 - 60)}[case]
    lights = [Case(f"l{i:04}", "sphere", affine(np.eye(3) * 1e-3, (at, 0, 0))).record(None) for i, at in enumerate(x)]
    tables, device = scene(lights, "auto")
    says = run(kernel_runner, tables, device, (3.0, 1.0, 0.0), np.zeros(n), asked=np.arange(n))[:, 2]
    assert abs(says.sum() - 1) < 1e-3 and (says > 0).all()
    m = 200000
    out = run(kernel_runner, tables, device, (3.0, 1.0, 0.0), (np.arange(m) + 0.5) / m)
    assert np.allclose(out[:, 1], says[out[:, 0].astype(int)], rtol=1e-3)
    often = says * m > 100
    frequency = np.bincount(out[:, 0].astype(int), minlength=n) / m
    assert np.abs(frequency[often] / says[often] - 1).max() < 0.5 if often.any() else True
    halves = np.cumsum(says)[n // 4 :: n // 4], np.cumsum(frequency)[n // 4 :: n // 4]
    assert np.abs(halves[0] - halves[1]).max() < 0.01


def test_it_finds_what_is_near(kernel_runner):
    """2,000 equal small lights in a street: the variance of one light sample, by the tree and by power."""
    n, m = 2000, 40000
    lights = [
        Case(f"l{i:04}", "sphere", affine(np.eye(3) * 0.05, (0.5 * i, 2 + (i % 3), i % 7))).record(None)
        for i in range(n)
    ]
    rng = np.random.default_rng(5)
    spread, mean = {}, {}
    for sampling in ("power", "tree"):
        tables, device = scene(lights, sampling)
        u, point = (np.arange(m) + 0.5) / m, rng.random((m, 2)) * 0.999
        picked = run(kernel_runner, tables, device, (300.0, 0.0, 3.0), u)
        out = run(kernel_runner, tables, device, (300.0, 0.0, 3.0), u, point, picked[:, 0])
        estimate = out[:, 3] / picked[:, 1]
        spread[sampling], mean[sampling] = estimate.var(), estimate.mean()
    assert abs(mean["tree"] / mean["power"] - 1) < 4 * np.sqrt(spread["power"] / m) / mean["power"]
    assert spread["tree"] < 0.06 * spread["power"]  # 0.047


def test_a_handful_is_picked_by_power(kernel_runner):
    few, _ = scene(mixed_lights(np.random.default_rng(1), 8), "auto")
    many, _ = scene(mixed_lights(np.random.default_rng(1), 9), "auto")
    assert few["lightTree"] == 0 and many["lightTree"] == many["itemCount"] == 11
