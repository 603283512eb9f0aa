# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Lights that have a shape: the pdf, its samples, and radiance against quadrature over the shape in numpy.

The light records come from scene/light_table.cpp; sampling and pdfs are lib/lights/*.glsl; what a ray finds by itself
goes the way of the ray kernels: the unit shape's intersection, then shapeHitPdf.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest
from core_harness import bits, call, chi2_p
from light_cases import AREA_CASES, VIEWS, Case, affine

INCLUDES = ["lib/lights/light_table.glsl", "lib/intersect_light_shape.glsl"]
TABLES = (
    "lightRecords",
    "lightItems",
    "lightDistribution",
    "textureRecords",
    "pageTable",
    "texturePages",
)
# inputs: point and light; sample or direction; three rows of world to unit shape.
COMMON = """
bool hitLight(Light l, vec3 o, vec3 d, out float t, out vec3 unitPoint) {
  uint base = gl_GlobalInvocationID.x * IN + 2u;
  vec4 r0 = inputs[base], r1 = inputs[base + 1u], r2 = inputs[base + 2u];
  vec3 lo = transformPoint(r0, r1, r2, o), ld = transformVector(r0, r1, r2, d);
  float u, v;
  bool found = intersectLightShape(l.type + kKindRect, lo, ld, 0.0, false, t, u, v);
  unitPoint = lightShapePoint(l.type + kKindRect, transformPoint(r0, r1, r2, o + t * d));
  return found;
}
"""
SAMPLE = (
    COMMON
    + """void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i * OUT >= outputs.length()) return;
  Light l = lightLoad(floatBitsToUint(inputs[i * IN].w));
  vec3 p = inputs[i * IN].xyz;
  LightSample s = sampleShape(l, p, inputs[i * IN + 1u].xy);
  float t; vec3 unitPoint;
  bool found = hitLight(l, p, s.direction, t, unitPoint);
  outputs[i * OUT] = vec4(s.direction, s.distance);
  outputs[i * OUT + 1u] = vec4(s.unitPoint, s.pdf);
  outputs[i * OUT + 2u] = vec4(lightRadiance(l, -s.direction, s.unitPoint, 0.0), found ? 1.0 : 0.0);
  outputs[i * OUT + 3u] = vec4(unitPoint, shapeHitPdf(l, p, s.direction, t, unitPoint));
  outputs[i * OUT + 4u] = vec4(lightRadiance(l, -s.direction, unitPoint, 0.0), t);
}"""
)
EVALUATE = (
    COMMON
    + """void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i * OUT >= outputs.length()) return;
  Light l = lightLoad(floatBitsToUint(inputs[i * IN].w));
  vec3 p = inputs[i * IN].xyz, d = inputs[i * IN + 1u].xyz;
  float t; vec3 unitPoint;
  bool found = hitLight(l, p, d, t, unitPoint);
  bool shines = found && dot(lightAreaVector(l, unitNormal(l.type, unitPoint)), d) < 0.0;
  vec4 seen = vec4(lightRadiance(l, -d, unitPoint, 0.0), shapeHitPdf(l, p, d, t, unitPoint));
  outputs[i * OUT] = shines ? seen : vec4(0.0);
  outputs[i * OUT + 1u] = vec4(unitPoint, found ? t : -1.0);
}"""
)
# inputs: point and light; direction and distance; the point on the unit shape.
PDF = (
    COMMON
    + """void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= outputs.length()) return;
  Light l = lightLoad(floatBitsToUint(inputs[i * IN].w));
  vec4 d = inputs[i * IN + 1u];
  outputs[i] = vec4(shapeHitPdf(l, inputs[i * IN].xyz, d.xyz, d.w, inputs[i * IN + 2u].xyz));
}"""
)
CELLS = 192


@dataclass
class Lights:
    runner: object
    tables: dict
    index: dict[str, int]

    def _inputs(self, case: Case, p: np.ndarray, second: np.ndarray) -> np.ndarray:
        n = max(len(np.atleast_2d(p)), len(second))
        inputs = np.zeros((n, 20), np.float32)
        inputs[:, :3] = p
        inputs[:, 3] = bits(np.full(n, self.index[case.name]))
        inputs[:, 4 : 4 + second.shape[1]] = second
        unit = case.matrix @ affine(np.diag(case.unit_size()))
        inputs[:, 8:] = np.linalg.inv(unit)[:3].ravel()
        return inputs

    def sample(self, case: Case, p, u: np.ndarray) -> np.ndarray:
        return self._call(SAMPLE, self._inputs(case, p, u), 5)

    def evaluate(self, case: Case, p, directions: np.ndarray) -> np.ndarray:
        return self._call(EVALUATE, self._inputs(case, p, directions), 2)

    def pdf(self, case: Case, p, cells: int) -> np.ndarray:
        """shapeHitPdf at the points of a grid over the shape, in the order of Case.elements."""
        points, _, local = case.elements(cells)
        d = points - p
        distance = np.linalg.norm(d, axis=1)
        inputs = np.zeros((len(d), 12), np.float32)
        inputs[:, :3] = p
        inputs[:, 3] = bits(np.full(len(d), self.index[case.name]))
        inputs[:, 4:7] = d / distance[:, None]
        inputs[:, 7] = distance
        inputs[:, 8:11] = local / case.unit_size()
        return self._call(PDF, inputs, 1)[:, 0]

    def _call(self, main: str, inputs: np.ndarray, outputs: int) -> np.ndarray:
        return call(self.runner, INCLUDES, main, inputs, outputs, {k: self.tables[k] for k in TABLES}).astype(float)


def make(runner, cases: list[Case]) -> Lights:
    from _kernel_runner import scene_tables

    textures, records = [], []
    for case in cases:
        records.append(case.record(len(textures) if case.texture is not None else None))
        if case.texture is not None:
            textures.append((case.texture.shape[1], case.texture.shape[0], "rgba8", case.texture.tobytes()))
    tables = scene_tables(records, textures, [], 10.0)
    assert tables["diagnostics"] == [] and tables["lightCount"] == len(cases)
    order = sorted(case.name for case in cases)
    return Lights(runner, tables, {name: i for i, name in enumerate(order)})


@pytest.fixture(scope="module")
def lights(kernel_runner) -> Lights:
    return make(kernel_runner, AREA_CASES)


@pytest.fixture(params=AREA_CASES, ids=lambda c: c.name)
def case(request) -> Case:
    return request.param


def stratified(side: int, seed: int) -> np.ndarray:
    cell = np.stack(np.meshgrid(np.arange(side), np.arange(side), indexing="ij"), -1).reshape(-1, 2)
    return (cell + np.random.default_rng(seed).random((side * side, 2))) / side * (1 - 1e-7)


def test_pdf_integrates_to_one_over_what_is_seen(lights, case):
    for p, _ in VIEWS:
        _, solid, _ = case.seen_from(p, CELLS)
        pdf = lights.pdf(case, p, CELLS)
        # Solid angles vanish towards a limb, and only there may float and double differ on what is seen.
        assert (pdf[solid > 1e-3 * solid.max()] > 0).all()
        # A limb cuts cells: those of equal area and pdf are counted or not, one of about CELLS / 2 a row.
        assert abs((pdf * solid).sum() - 1) < (4e-3 if case.kind in ("rect", "disk") else 2 / CELLS)


def test_samples_estimate_irradiance_and_moments(lights, case):
    """E[f L / pdf] = integral of f L over the light, for f = cosine, and for three lobes that look aside."""
    for view, (p, n) in enumerate(VIEWS):
        out = lights.sample(case, p, stratified(160, view))
        direction, pdf, radiance = out[:, :3], out[:, 7], out[:, 8:11]
        assert np.isfinite(out[:, :12]).all()
        w, solid, emitted = case.seen_from(p, 2 * CELLS)
        axis = (w * solid[:, None]).sum(0)
        axis /= np.linalg.norm(axis)
        aside = np.cross(axis, [0.3, 0.8, 0.5])
        spread = max(np.sqrt(((w - axis) ** 2 * solid[:, None]).sum() / solid.sum()), 1e-6)

        def lobes(d, n=n, axis=axis, aside=aside, spread=spread):
            off = (d - axis) / spread
            return np.maximum(d @ n, 0), np.exp(off @ aside), np.exp(-off @ np.cross(axis, aside))

        for of_grid, of_samples in zip(lobes(w), lobes(direction), strict=True):
            want = (of_grid[:, None] * solid[:, None] * emitted).sum(0)
            each = np.where(pdf > 0, of_samples / np.where(pdf > 0, pdf, 1), 0)[:, None] * radiance
            error = each.std(0) / np.sqrt(len(each))
            assert (np.abs(each.mean(0) - want) < 4e-3 * np.abs(want) + 2 * error + 1e-12).all(), (
                each.mean(0),
                want,
                error,
            )


def test_samples_follow_the_pdf(lights, case):
    """Chi-square over cells of the shape's parameters; expected counts from quadrature of the pdf that hits report."""
    bins, sub = 12, 16
    for view, (p, _) in enumerate(VIEWS):
        _, solid, _ = case.seen_from(p, bins * sub)
        expected = (lights.pdf(case, p, bins * sub) * solid).reshape(bins, sub, bins, sub).sum((1, 3)).ravel()
        u = np.random.default_rng(view + 10).random((16384, 2)) * (1 - 1e-7)
        out = lights.sample(case, p, u)
        points = (p + out[:, :3] * out[:, 3:4]) - case.matrix[:3, 3]
        s, t = case.parameters(points @ np.linalg.inv(case.matrix[:3, :3]).T)
        valid = out[:, 7] > 0
        cell = np.clip((s * bins).astype(int), 0, bins - 1) * bins + np.clip((t * bins).astype(int), 0, bins - 1)
        counts = np.bincount(cell[valid], minlength=bins * bins).astype(float)
        expected *= valid.sum() / expected.sum()
        big = expected > 20
        # Cells that the horizon of the shape cuts are off by the grid: pooled with the small ones.
        rest = np.array([expected[~big].sum()]), np.array([counts[~big].sum()])
        e, c = np.concatenate([expected[big], rest[0]]), np.concatenate([counts[big], rest[1]])
        keep = e > 20
        statistic = float(((c[keep] - e[keep]) ** 2 / e[keep]).sum())
        assert chi2_p(statistic, int(keep.sum()) - 1) > 1e-5, (view, statistic, keep.sum())


def test_sampled_and_hit_pdfs_agree(lights, case):
    for view, (p, _) in enumerate(VIEWS):
        out = lights.sample(case, p, stratified(64, view + 50))
        sampled, found, hit = out[:, 7], out[:, 11] > 0, out[:, 15]
        shines = sampled > 0
        # Samples at the very rim can miss by rounding.
        assert np.mean(found[shines]) > 0.998
        both = found & shines
        t = out[:, 19]
        # A grazing hit of a round light may be found on its other side of the limb, where its pdf is 0.
        close = np.abs(t - out[:, 3]) < 1e-3 * out[:, 3]
        # Area pdfs have 1 / cosine in them, which rounding moves near a limb: the reciprocals are compared.
        reciprocal = 1 / np.maximum(sampled, 1e-30)
        agree = np.abs(1 / np.maximum(hit, 1e-30) - reciprocal) < 2e-3 * np.median(reciprocal[shines])
        assert np.mean(agree[both & close]) > 0.99
        assert np.mean(close[both]) > 0.99
        same = np.abs(out[:, 16:19] - out[:, 8:11]).max(1) < 2e-2 * max(case.radiance)
        assert np.mean(same[both & close]) > 0.99


def test_back_sides_shine_nothing(lights):
    for case in AREA_CASES:
        if case.kind not in ("rect", "disk"):
            continue
        front = case.matrix[:3, :3] @ [0, 0, -1.0]
        normal = np.cross(case.matrix[:3, 0], case.matrix[:3, 1])
        normal *= np.sign(normal @ front)
        p = case.matrix[:3, 3] - 0.7 * normal / np.linalg.norm(normal)
        out = lights.sample(case, p, stratified(16, 3))
        assert (out[:, 7] == 0).all() and (out[:, 15] == 0).all(), case.name
        w = case.seen_from(p, 8)[0]
        assert (lights.evaluate(case, p, w)[:, :4] == 0).all(), case.name


def test_inside_of_a_sphere_is_dark(lights):
    case = next(c for c in AREA_CASES if c.name == "sphere")
    out = lights.sample(case, case.matrix[:3, 3] + [0.1, 0.2, -0.1], stratified(16, 4))
    assert (out[:, 7] == 0).all()


def test_points_on_or_in_the_plane_of_a_light_give_finite_samples(lights):
    for case in AREA_CASES:
        for local in ([0, 0, 0], [0.2, 0.1, 0], [5, 0.1, 0], [0, case.radius, 0], [case.width / 2, case.height / 2, 0]):
            p = (case.matrix @ [*local, 1])[:3]
            out = lights.sample(case, p, np.array([[0.5, 0.5], [0.0, 0.0], [0.999999, 0.3], [0.3, 0.999999]]))
            assert np.isfinite(out[:, 7]).all() and (out[:, 7] >= 0).all(), (case.name, local)
            used = out[:, 7] > 0
            assert np.isfinite(out[used][:, :11]).all(), (case.name, local)
            assert np.abs(np.linalg.norm(out[used, :3], axis=1) - 1).max(initial=0) < 1e-4


@pytest.mark.parametrize("distance", [1e-3, 1e-2, 0.1, 1.0, 10.0, 1e3])
def test_rectangles_near_and_far(kernel_runner, distance):
    """Solid angles from 2 pi down to 1e-7, head-on and aside, against Lambert's polygon formula."""
    cases = [Case("plain", "rect", width=1.0, height=1.0), Case("thin", "rect", width=1.0, height=0.01)]
    lights = make(kernel_runner, cases)
    for case in cases:
        for aside in (0.0, 0.4, 2.0):
            p = np.array([aside, 0.1 * aside, -distance])
            n = np.array([0.0, 0, 1])
            out = lights.sample(case, p, stratified(128, 1))
            each = np.where(out[:, 7] > 0, np.maximum(out[:, :3] @ n, 0) / np.maximum(out[:, 7], 1e-30), 0)
            c = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) / 2 * [case.width, case.height]
            v = np.column_stack([c, np.zeros(4)]) - p
            v /= np.linalg.norm(v, axis=1, keepdims=True)
            total = 0.0
            for a, b in zip(v, np.roll(v, -1, 0), strict=True):
                cross = np.cross(a, b)
                sine = np.linalg.norm(cross)
                total += np.arctan2(sine, a @ b) * (cross @ n) / max(sine, 1e-300)
            want = abs(total) / 2
            error = each.std() / np.sqrt(len(each))
            assert abs(each.mean() - want) < 3e-3 * want + 1.0 * error, (case.name, aside, each.mean(), want, error)


def test_a_rect_texture_is_upright_and_unmirrored_from_the_front(kernel_runner):
    """Looking along +Z from the front, +Y up: the viewer's right is -X. Corners are black, red, green, blue."""
    texture = np.zeros((64, 64, 4), np.uint8)
    texture[:32, 32:, 0] = 255  # bottom right: red
    texture[32:, :32, 1] = 255  # top left: green
    texture[32:, 32:, 2] = 255  # top right: blue
    case = Case("picture", "rect", affine(np.eye(3), (0, 0, 5)), (1, 1, 1), 2, 2, texture=texture)
    lights = make(kernel_runner, [case])
    right = np.array([-1.0, 0, 0])
    up = np.array([0.0, 1, 0])
    for x, y, colour in [(-1, -1, (0, 0, 0)), (1, -1, (1, 0, 0)), (-1, 1, (0, 1, 0)), (1, 1, (0, 0, 1))]:
        target = np.array([0, 0, 5.0]) + 0.5 * x * right + 0.5 * y * up
        seen = lights.evaluate(case, np.zeros(3), (target / np.linalg.norm(target))[None])
        assert np.allclose(seen[0, :3], colour, atol=1e-3), (x, y)


def test_cone_and_focus_closed_forms(kernel_runner):
    """On the axis, at the middle of the soft part, at the cutoff, behind it."""
    cone = Case("cone", "sphere", radius=1e-3, radiance=(1, 1, 1), cone=(60, 0.5))
    focus = Case("focus", "sphere", radius=1e-3, radiance=(1, 1, 1), focus=4, tint=(0.25, 0.5, 0))
    lights = make(kernel_runner, [cone, focus])
    angles = np.radians([0, 29, 45, 59.9, 61, 120, 180])
    emission = np.stack([np.sin(angles), 0 * angles, -np.cos(angles)], -1)
    for case, want in [
        (cone, np.array([1, 1, 0.5, 0, 0, 0, 0])[:, None] * np.ones(3)),
        (focus, np.array([0.25, 0.5, 0]) + np.array([0.75, 0.5, 1]) * (np.maximum(np.cos(angles), 0) ** 4)[:, None]),
    ]:
        for e, value in zip(emission, want, strict=True):
            seen = lights.evaluate(case, 2.0 * e, -e[None])
            assert np.allclose(seen[0, :3], value, atol=5e-3), (case.name, e)


@pytest.mark.parametrize(
    "change",
    [
        dict(transform=[0.0] * 16),
        dict(transform=[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1.0]),
        dict(transform=[float("nan")] * 16),
        dict(width=0.0),
        dict(height=0.0),
        dict(radiance=[float("inf"), 1, 1]),
        dict(radiance=[float("nan"), 1, 1]),
    ],
    ids=lambda c: next(iter(c)),
)
def test_degenerate_lights_are_left_out_with_a_diagnostic(kernel_runner, change):
    from _kernel_runner import scene_tables

    good = Case("good", "disk").record(None)
    bad = Case("bad", "rect").record(None) | change
    tables = scene_tables([bad, good], [], [], 1.0)
    assert [d[:2] for d in tables["diagnostics"]] == [("light-degenerate", "/bad")]
    assert tables["lightCount"] == 1 and tables["itemCount"] == 1
    probability = np.frombuffer(tables["lightItems"], np.float32)[2]
    assert probability == 1.0
