# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""lib/geometry.glsl: what a material reads at a hit, against numpy in double precision."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
from core_harness import NO_STREAM, bits, call

CONSTANT, UNIFORM, VERTEX, FACE_VARYING, INSTANCE = range(5)
INCLUDES = ["lib/geometry.glsl"]
NO_BUCKET = 0xFFFFFFFF


@dataclass
class Primvar:
    interpolation: int
    values: np.ndarray  # (elements, components)
    indices: np.ndarray | None = None  # face-varying: an element per corner


@dataclass
class Scene:
    """One mesh, one instance of it (index 1 of the group), records written as shared/scene_layout.h says."""

    positions: np.ndarray
    triangles: np.ndarray
    transform: np.ndarray  # 4 x 4, column vectors: p' = M p
    primvars: dict[str, Primvar] = field(default_factory=dict)
    face_ids: np.ndarray | None = None
    normals: Primvar | None = None
    leaf_order: np.ndarray | None = None

    def tables(self) -> dict[str, np.ndarray]:
        index_stream: list[int] = [123456, 654321]  # whatever stands before: bases are not zero
        floats: list[float] = [1e9] * 5
        count = len(self.triangles)
        index_base = len(index_stream)
        index_stream += list(self.triangles.ravel())
        face_base = NO_STREAM
        if self.face_ids is not None:
            face_base = len(index_stream)
            index_stream += list(self.face_ids)

        def describe(primvar: Primvar) -> list[int]:
            base, indices = len(floats), NO_STREAM
            floats.extend(primvar.values.ravel())
            if primvar.indices is not None:
                indices = len(index_stream)
                index_stream.extend(primvar.indices)
            return [base, indices, primvar.interpolation | primvar.values.shape[1] << 8, 0]

        normals = describe(self.normals) if self.normals is not None else [NO_STREAM] * 4
        mesh = np.zeros((4, 4), np.uint32)
        mesh[2] = [index_base, face_base, count, 0]  # mesh record 1
        mesh[3] = normals
        binding_base = len(index_stream)
        index_stream += [7]  # slot 0: the binding at texel 7
        binding = np.full((9 + len(self.primvars), 4), 99, np.uint32)
        binding[7] = [1, NO_BUCKET, NO_BUCKET, 3]  # parameters from texel 3
        binding[8] = [0, 0, len(self.primvars), 0]
        for slot, primvar in enumerate(self.primvars.values()):
            binding[9 + slot] = describe(primvar) if primvar.values.size else [NO_STREAM] * 4
        order = np.arange(count) if self.leaf_order is None else self.leaf_order
        triangle = np.zeros((count, 3, 4), np.float32)
        triangle[:, :, :3] = self.positions[self.triangles[order]]
        triangle[:, 0, 3] = bits(order)
        instance = np.zeros((2, 9, 4), np.float32)
        instance[1, 0:3] = np.linalg.inv(self.transform)[:3]
        instance[1, 4:7] = self.transform[:3]
        instance[1, 7] = bits([1, binding_base, 1, 0xFFFFFFFF])
        return {
            "triangleRecords": triangle,
            "instanceRecords": instance,
            "meshRecords": mesh,
            "indexStream": np.array(index_stream, np.uint32),
            "primvarStream": np.array(floats, np.float32),
            "bindingRecords": binding,
            "materialParameters": np.arange(40, dtype=np.float32),
        }

    def hits(self, count: int, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
        """Triangle records and barycentrics (w, u, v)."""
        rng = np.random.default_rng(seed)
        record = rng.integers(0, len(self.triangles), count)
        return record, rng.dirichlet([1, 1, 1], count).astype(np.float32)


def run(runner, scene: Scene, record, weights, body: str, outputs: int, wo=None, cone_width=0.0) -> np.ndarray:
    inputs = np.zeros((len(record), 8), np.float32)
    inputs[:, 0] = bits(record)
    inputs[:, 1:3] = weights[:, 1:]
    inputs[:, 3] = cone_width
    inputs[:, 4:7] = [0, 0, 1] if wo is None else wo
    main = f"""void main() {{
      uint i = gl_GlobalInvocationID.x;
      if (i * OUT >= outputs.length()) return;
      vec4 hit = inputs[i * IN], view = inputs[i * IN + 1u];
      ShadingPoint sp = shadingPointMake(1u, floatBitsToUint(hit.x), hit.yz, view.xyz, hit.w, 0.0);
      {body}
    }}"""
    return call(runner, INCLUDES, main, inputs, outputs, scene.tables())


def random_transform(seed: int, mirrored: bool) -> np.ndarray:
    """Rotation, non-uniform scale, shear and translation."""
    rng = np.random.default_rng(seed)
    q = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    m = np.eye(4)
    m[:3, :3] = q @ np.diag(rng.uniform(0.3, 3, 3)) @ (np.eye(3) + 0.4 * np.triu(rng.normal(size=(3, 3)), 1))
    if (np.linalg.det(m[:3, :3]) < 0) != mirrored:
        m[:3, :3] = m[:3, :3] @ np.diag([1, 1, -1])
    m[:3, 3] = rng.normal(size=3) * 5
    return m


def mesh(seed: int = 1, count: int = 24, **kwargs) -> Scene:
    rng = np.random.default_rng(seed)
    positions = rng.normal(size=(count, 3))
    triangles = np.stack([rng.permutation(count)[:3] for _ in range(20)])
    kwargs.setdefault("transform", random_transform(seed, False))
    kwargs.setdefault("leaf_order", rng.permutation(20))
    return Scene(positions, triangles, **kwargs)


@pytest.mark.parametrize("components", [1, 2, 3, 4])
def test_primvars_of_every_interpolation(kernel_runner, components):
    rng = np.random.default_rng(components)
    scene = mesh(components, face_ids=np.arange(20) // 3)
    values = lambda n: rng.normal(size=(n, components))  # noqa: E731
    indexed = rng.integers(0, 11, 60)
    scene.primvars = {
        "constant": Primvar(CONSTANT, values(1)),
        "uniform": Primvar(UNIFORM, values(7)),
        "vertex": Primvar(VERTEX, values(24)),
        "corner": Primvar(FACE_VARYING, values(60)),
        "indexed": Primvar(FACE_VARYING, values(11), indexed),
        "instance": Primvar(INSTANCE, values(4)),
        "absent": Primvar(CONSTANT, np.zeros((0, components))),
    }
    record, weights = scene.hits(300, components)
    triangle = scene.leaf_order[record]
    p = {name: primvar.values for name, primvar in scene.primvars.items()}
    corners = 3 * triangle[:, None] + np.arange(3)
    element = {
        "constant": np.zeros_like(corners),
        "uniform": np.repeat(scene.face_ids[triangle][:, None], 3, 1),
        "vertex": scene.triangles[triangle],
        "corner": corners,
        "indexed": indexed[corners],
        "instance": np.ones_like(corners),
    }
    for slot, name in enumerate(p):
        out = run(
            kernel_runner,
            scene,
            record,
            weights,
            f"""outputs[i * OUT] = vec4(primvarFloat(sp, {slot}u, 7.0), primvarVec2(sp, {slot}u, vec2(8.0, 9.0)), 0.0);
            outputs[i * OUT + 1u] = vec4(primvarVec3(sp, {slot}u, vec3(10.0, 11.0, 12.0)),
                primvarExists(sp, {slot}u) ? 1.0 : 0.0);
            outputs[i * OUT + 2u] = primvarVec4(sp, {slot}u, vec4(13.0));""",
            3,
        )
        if name == "absent":
            assert (
                (out[:, :3] == [7, 8, 9]).all() and (out[:, 4:8] == [10, 11, 12, 0]).all() and (out[:, 8:] == 13).all()
            )
            continue
        want = np.einsum("nc,nck->nk", weights.astype(float), p[name][element[name]])
        assert (out[:, 7] == 1).all()
        assert np.abs(out[:, 0] - want[:, 0]).max() < 1e-5, name
        # Fewer components than asked for: a float repeats, a pair has z = 0, alpha is 1.
        pair = want[:, [0, 1 if components > 1 else 0]]
        assert np.abs(out[:, 1:3] - pair).max() < 1e-5, name
        triple = {1: want[:, [0, 0, 0]], 2: np.column_stack([want, 0 * want[:, 0]])}.get(components, want[:, :3])
        assert np.abs(out[:, 4:7] - triple).max() < 1e-5, name
        assert np.abs(out[:, 8:11] - triple).max() < 1e-5, name
        assert np.abs(out[:, 11] - (want[:, 3] if components == 4 else 1)).max() < 1e-5, name


def test_uniform_primvars_without_face_ids_go_by_triangle(kernel_runner):
    scene = mesh(5)
    scene.primvars = {"u": Primvar(UNIFORM, np.arange(20.0)[:, None])}
    record, weights = scene.hits(100)
    out = run(kernel_runner, scene, record, weights, "outputs[i] = vec4(primvarFloat(sp, 0u, -1.0));", 1)
    assert np.abs(out[:, 0] - scene.leaf_order[record]).max() < 1e-4


@pytest.mark.parametrize("mirrored", [False, True])
def test_points_and_normals(kernel_runner, mirrored):
    rng = np.random.default_rng(8)
    scene = mesh(8, transform=random_transform(8, mirrored))
    normals = rng.normal(size=(24, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    scene.normals = Primvar(VERTEX, normals)
    record, weights = scene.hits(400)
    wo = rng.normal(size=(400, 3))
    wo /= np.linalg.norm(wo, axis=1, keepdims=True)
    out = run(
        kernel_runner,
        scene,
        record,
        weights,
        """outputs[i * OUT] = vec4(sp.positionWorld, sp.frontFacing ? 1.0 : 0.0);
        outputs[i * OUT + 1u] = vec4(sp.normalGeometric, float(sp.triangle));
        outputs[i * OUT + 2u] = vec4(sp.normalWorld, float(sp.parameterBase));
        outputs[i * OUT + 3u] = vec4(sp.positionObject, materialParameter(sp, 1u).y);""",
        4,
        wo,
    )
    triangle = scene.leaf_order[record]
    corner = scene.positions[scene.triangles[triangle]]
    p = np.einsum("nc,nck->nk", weights.astype(float), corner)
    world = p @ scene.transform[:3, :3].T + scene.transform[:3, 3]
    assert np.abs(out[:, 12:15] - p).max() < 1e-5
    assert np.abs(out[:, :3] - world).max() < 1e-4
    inverse_transpose = np.linalg.inv(scene.transform[:3, :3]).T
    ng = np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) @ inverse_transpose.T
    ng /= np.linalg.norm(ng, axis=1, keepdims=True)
    assert np.abs(out[:, 4:7] - ng).max() < 1e-4
    # The authored outside stays outside under mirrors: the object-space side of the plane maps to it.
    outside = (corner[:, 0] + np.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0])) @ scene.transform[
        :3, :3
    ].T
    assert (((outside - corner[:, 0] @ scene.transform[:3, :3].T) * out[:, 4:7]).sum(1) > 0).all()
    side = (ng * wo).sum(1)
    clear = np.abs(side) > 1e-3
    assert ((out[:, 3] == 1) == (side >= 0))[clear].all()
    n = np.einsum("nc,nck->nk", weights.astype(float), normals[scene.triangles[triangle]]) @ inverse_transpose.T
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    # Normals against the winding are turned to its side; both kinds must occur here. Near the plane rounding decides.
    along = (n * ng).sum(1)
    assert (along > 0.1).any() and (along < -0.1).any()
    turned = np.where(along[:, None] < 0, -n, n)
    assert np.abs(out[:, 8:11] - turned)[np.abs(along) > 1e-4].max() < 1e-4
    assert (out[:, 7] == triangle).all()
    assert (out[:, 11] == 3).all()
    assert (out[:, 15] == (3 + 1) * 4 + 1).all()


def test_without_normals_the_geometric_one_shades(kernel_runner):
    scene = mesh(3)
    record, weights = scene.hits(50)
    out = run(kernel_runner, scene, record, weights, "outputs[i] = vec4(sp.normalWorld - sp.normalGeometric, 0.0);", 1)
    assert (out == 0).all()


def test_degenerate_triangles_give_finite_normals(kernel_runner):
    scene = mesh(4)
    scene.positions[scene.triangles[0]] = 1.0
    scene.leaf_order = np.arange(20)
    scene.normals = Primvar(VERTEX, np.zeros((24, 3)))
    out = run(
        kernel_runner,
        scene,
        np.zeros(4, int),
        np.full((4, 3), 1 / 3, np.float32),
        "outputs[i] = vec4(sp.normalWorld, length(sp.normalGeometric));",
        1,
    )
    assert np.isfinite(out).all() and np.abs(out[:, 3] - 1).max() < 1e-5
    assert np.abs(np.linalg.norm(out[:, :3], axis=1) - 1).max() < 1e-5


@pytest.mark.parametrize("mirrored", [False, True])
@pytest.mark.parametrize("flipped_uv", [False, True])
def test_tangents_follow_texture_coordinates(kernel_runner, mirrored, flipped_uv):
    """T = dP/du made orthogonal to the normal; B completes the frame on the side of dP/dv."""
    scene = mesh(6, transform=random_transform(6, mirrored))
    rng = np.random.default_rng(6)
    # uv = an affine map of the triangle's own barycentrics, of either orientation.
    uv = np.zeros((60, 2))
    for t in range(20):
        a = rng.normal(size=(2, 2))
        a[:, 0] *= 1 if (np.linalg.det(a) > 0) != flipped_uv else -1
        uv[3 * t : 3 * t + 3] = rng.normal(size=2) + np.array([[0, 0], a[:, 0], a[:, 1]])
    scene.primvars = {"st": Primvar(FACE_VARYING, uv)}
    record, weights = scene.hits(200)
    out = run(
        kernel_runner,
        scene,
        record,
        weights,
        """vec3 t, b; primvarTangents(sp, 0u, t, b);
        outputs[i * OUT] = vec4(t, 0.0); outputs[i * OUT + 1u] = vec4(b, 0.0);
        outputs[i * OUT + 2u] = vec4(sp.normalWorld, 0.0);""",
        3,
    ).astype(float)
    t, b, n = out[:, 0:3], out[:, 4:7], out[:, 8:11]
    triangle = scene.leaf_order[record]
    corner = scene.positions[scene.triangles[triangle]] @ scene.transform[:3, :3].T
    edges = np.stack([corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]], 1)  # (n, 2, 3)
    st = uv.reshape(20, 3, 2)[triangle]
    duv = np.stack([st[:, 1] - st[:, 0], st[:, 2] - st[:, 0]], 1)  # (n, 2, 2)
    derivative = np.linalg.solve(duv, edges)  # rows dP/du, dP/dv
    want = derivative[:, 0] - n * (derivative[:, 0] * n).sum(1, keepdims=True)
    want /= np.linalg.norm(want, axis=1, keepdims=True)
    conditioned = np.abs(np.linalg.det(duv)) > 0.05
    assert conditioned.sum() > 50
    assert np.abs(t - want)[conditioned].max() < 2e-3
    assert (
        np.abs((t * n).sum(1)).max() < 1e-4
        and np.abs((b * n).sum(1)).max() < 1e-4
        and np.abs((t * b).sum(1)).max() < 1e-4
    )
    assert ((b * derivative[:, 1]).sum(1) > -1e-3).all()
    assert np.abs(np.linalg.norm(b, axis=1) - 1).max() < 1e-4


def test_degenerate_texture_coordinates_give_a_frame(kernel_runner):
    scene = mesh(7)
    scene.primvars = {"st": Primvar(CONSTANT, np.array([[0.5, 0.5]])), "absent": Primvar(CONSTANT, np.zeros((0, 2)))}
    record, weights = scene.hits(50)
    for slot in (0, 1):
        out = run(
            kernel_runner,
            scene,
            record,
            weights,
            f"""vec3 t, b; primvarTangents(sp, {slot}u, t, b);
            outputs[i] = vec4(dot(t, b), dot(t, sp.normalWorld), length(t), length(b));""",
            1,
        )
        assert np.abs(out - [0, 0, 1, 1]).max() < 1e-4


def test_uv_footprint_is_the_cone_in_texture_space(kernel_runner):
    """A square of 2 x 2 units under uv 0..3: a cone of width w seen head-on covers 1.5 w in u."""
    scene = Scene(np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]]), np.array([[0, 1, 2], [0, 2, 3]]), np.eye(4))
    scene.primvars = {"st": Primvar(VERTEX, np.array([[0.0, 0], [3, 0], [3, 3], [0, 3]]))}
    record, weights = scene.hits(20)
    out = run(
        kernel_runner, scene, record, weights, "outputs[i] = vec4(primvarUvFootprint(sp, 0u));", 1, cone_width=0.1
    )
    assert np.abs(out - 0.15).max() < 1e-5


def test_transform_readers_invert_each_other(kernel_runner):
    scene = mesh(9, transform=random_transform(9, True))
    record, weights = scene.hits(20)
    out = run(
        kernel_runner,
        scene,
        record,
        weights,
        """vec3 v = vec3(0.3, -2.0, 1.5);
        outputs[i * OUT] = vec4(worldToObjectPoint(sp, objectToWorldPoint(sp, v)) - v, 0.0);
        outputs[i * OUT + 1u] = vec4(worldToObjectVector(sp, objectToWorldVector(sp, v)) - v, 0.0);
        outputs[i * OUT + 2u] = vec4(worldToObjectNormal(sp, objectToWorldNormal(sp, v)) - normalize(v), 0.0);
        outputs[i * OUT + 3u] = vec4(objectToWorldVector(sp, v),
            dot(objectToWorldNormal(sp, v), objectToWorldVector(sp, vec3(2.0, 0.3, 0.0))));""",
        4,
    )
    assert np.abs(out[:, :12]).max() < 1e-4
    want = scene.transform[:3, :3] @ [0.3, -2.0, 1.5]
    assert np.abs(out[:, 12:15] - want).max() < 1e-4
    assert np.abs(out[:, 15]).max() < 1e-4  # a normal stays orthogonal to what it was orthogonal to
