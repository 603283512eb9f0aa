# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Closures that materialgen makes of layer, mix, add and multiply, against quadrature of MaterialX's own formula; and
whole white surfaces, which give no more than they get.

The kernel is the renderer's own, head and tail apart: closureMake, then closureEval towards a grid of directions. The
reference (closure_reference.py) knows none of our fits and tables.
"""

from __future__ import annotations

from typing import Any

import closure_reference as ref
import numpy as np
import pytest
from kernels.bsdf_harness import lobe_table
from kernels.core_harness import call
from node_harness import Network, material
from scipy.stats import qmc, t

VIEWS = (5.0, 40.0, 65.0, 80.0)  # degrees
ROWS = 64
RUST, STRAW, ROSE = (0.8, 0.35, 0.1), (0.9, 0.85, 0.4), (0.9, 0.3, 0.5)
GREY, WHITE = (0.5, 0.5, 0.5), (1.0, 1.0, 1.0)

GLOSS = ref.Dielectric(0.2)
GOLD = ref.Conductor(0.3)
STACK = ref.Layer(ref.Dielectric(0.15, ior=1.6), ref.Layer(ref.Sheen(0.5, STRAW, 0.3), ref.OrenNayar(1.0, RUST, 0.2)))
CASES: dict[str, ref.Bsdf] = {
    "dielectric over Oren-Nayar": ref.Layer(GLOSS, ref.OrenNayar(0.9, RUST, 0.6)),
    "weighted, tinted dielectric over Burley": ref.Layer(
        ref.Dielectric(0.4, 0.7, STRAW, ior=1.8), ref.Burley(1.0, ROSE, 0.7)
    ),
    "sheen over dielectric over diffuse": ref.Layer(
        ref.Sheen(0.8, STRAW, 0.4), ref.Layer(ref.Dielectric(0.3), ref.OrenNayar(1.0, RUST))
    ),
    "Zeltner's sheen over dielectric over compensated Oren-Nayar": ref.Layer(
        ref.Zeltner(0.9, ROSE, 0.35), ref.Layer(ref.Dielectric(0.5, ior=1.4), ref.CompensatedOrenNayar(1.0, STRAW, 0.8))
    ),
    "generalised Schlick over diffuse": ref.Layer(
        ref.Schlick(0.35, 0.9, color0=(0.3, 0.15, 0.05)), ref.OrenNayar(1.0, WHITE, 0.3)
    ),
    "two coats over metal": ref.Layer(ref.Dielectric(0.2, 0.5), ref.Layer(ref.Dielectric(0.6, ior=1.9), GOLD)),
    "mix of metal and plastic": ref.Mix(GOLD, ref.Layer(GLOSS, ref.OrenNayar(1.0, ROSE)), 0.3),
    "mix on top": ref.Layer(ref.Mix(GLOSS, ref.Sheen(1.0, WHITE, 0.5), 0.6), ref.Burley(1.0, STRAW, 0.5)),
    "stack on top": ref.Layer(
        ref.Layer(ref.Dielectric(0.2), ref.Multiply(ref.Sheen(0.6, ROSE, 0.3), 0.5)), ref.OrenNayar(1.0, STRAW)
    ),
    "sum on top": ref.Layer(
        ref.Add(ref.Dielectric(0.25, 0.8), ref.Sheen(0.4, RUST, 0.6)),
        ref.Multiply(ref.OrenNayar(1.0, WHITE, 0.4), RUST),
    ),
    "sum of products": ref.Add(ref.Multiply(STACK, (0.2, 0.4, 0.6)), ref.Multiply(GOLD, 0.4)),
}


class Graph(Network):
    """A network of what the reference describes, node for node."""

    def closure(self, bsdf: ref.Bsdf) -> str:
        values: dict[str, Any] = {}
        children: dict[str, ref.Bsdf] = {}
        if isinstance(bsdf, ref.Microfacet):
            values = {"weight": bsdf.weight, "roughness": (bsdf.alpha, bsdf.alpha)}
        elif isinstance(bsdf, (ref.Sheen, ref.OrenNayar)):
            values = {"weight": bsdf.weight, "color": bsdf.tint, "roughness": bsdf.roughness}
        match bsdf:
            case ref.Dielectric():
                name, values = "dielectric_bsdf", values | {"tint": bsdf.tint, "ior": bsdf.ior}
            case ref.Conductor():
                name, values = "conductor_bsdf", values | {"ior": bsdf.ior, "extinction": bsdf.extinction}
            case ref.Schlick():
                curve = {"color0": bsdf.color0, "color90": bsdf.color90, "exponent": bsdf.exponent}
                name, values = "generalized_schlick_bsdf", values | curve
            case ref.Sheen():
                name = "sheen_bsdf"
                values["mode"] = "zeltner" if isinstance(bsdf, ref.Zeltner) else "conty_kulla"
            case ref.Burley():
                name = "burley_diffuse_bsdf"
            case ref.OrenNayar():
                name = "oren_nayar_diffuse_bsdf"
                values["energy_compensation"] = isinstance(bsdf, ref.CompensatedOrenNayar)
            case ref.Layer(top, base):
                name, children = "layer_bsdf", {"top": top, "base": base}
            case ref.Mix(fg, bg, mix):
                name, values, children = "mix_bsdf", {"mix": mix}, {"fg": fg, "bg": bg}
            case ref.Add(in1, in2):
                name, children = "add_bsdf", {"in1": in1, "in2": in2}
            case ref.Multiply(in1, in2):
                name = "multiply_bsdfF" if isinstance(in2, float) else "multiply_bsdfC"
                values, children = {"in2": in2}, {"in1": in1}
            case _:
                raise NotImplementedError(type(bsdf))
        path = self.add(f"/node{len(self.nodes)}", f"ND_{name}", values)
        for port, child in children.items():
            self.connect(self.closure(child), "out", path, port)
        return path


MAIN = """void main() {
  uint i = gl_GlobalInvocationID.x;
  if (i >= outputs.length()) return;
  ShadingPoint sp;
  sp.positionWorld = sp.positionObject = vec3(0.0);
  sp.normalWorld = sp.normalGeometric = vec3(0.0, 0.0, 1.0);
  sp.wo = inputs[2u * i].xyz;
  sp.frontFacing = true;
  sp.footprint = sp.time = 0.0;
  sp.exteriorIor = 1.0;
  sp.instance = sp.triangle = sp.mesh = sp.binding = sp.parameterBase = 0u;
  sp.barycentric = vec2(0.3);
  gEdge1World = vec3(1.0, 0.0, 0.0);
  gEdge2World = vec3(0.0, 1.0, 0.0);
  Closure c;
  closureMake(sp, c);
  vec3 below = vec3(0.0), given = inputs[2u * i + 1u].xyz;
  vec3 wi = SAMPLES ? closureSample(c, sp.wo, given.z, given.xy) : given;
  vec4 value = closureEval(c, sp.wo, wi, below);
  outputs[i] = SAMPLES ? vec4(value.a > 0.0 ? value.rgb / value.a : vec3(0.0), 0.0) : value;
}"""


def run(runner: Any, made: dict[str, Any], wo: np.ndarray, given: np.ndarray, samples: bool = False) -> np.ndarray:
    """For each wo (views, 3) and what is given to it (views, n, 3): closureEval's colour towards that direction, or
    the weight of the direction that closureSample makes of these numbers."""
    assert not made["messages"], made["messages"]
    lines = made["surface"].splitlines()[2:]  # the test has a head and a main of its own
    body = "\n".join(line for line in lines if not line.startswith('#include "material/'))
    rows = np.zeros((*given.shape[:2], 8), np.float32)
    rows[:, :, :3], rows[:, :, 4:7] = wo[:, None], given
    names = ["frame", "frame_values", "shading_point", "geometry", "textures", "media", "bsdf/subsurface"]
    includes = [f"lib/{name}.glsl" for name in names]
    tables = {
        "materialParameters": np.array(made["parameters"], np.float32),
        "lobeTable": lobe_table(runner)[22][0],
        "bindingRecords": np.zeros((2, 4), np.uint32),
        "instanceRecords": np.zeros((9, 4), np.float32),
        "meshRecords": np.full(8, 0xFFFFFFFF, np.uint32),
    }
    main = f"const bool SAMPLES = {'true' if samples else 'false'};\n" + MAIN
    out = call(runner, includes, body + main, rows.reshape(-1, 8), 1, tables)
    return out.reshape(*given.shape[:2], 4)[..., :3].astype(float)


def views() -> np.ndarray:
    theta, phi = np.radians(VIEWS), 0.7
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def compare(runner: Any, made: dict[str, Any], expected: ref.Bsdf) -> None:
    wi, _ = ref.hemisphere(ROWS)
    ours = run(runner, made, views(), np.broadcast_to(wi, (len(VIEWS), *wi.shape)))
    theirs = np.stack([expected.value(wo, wi) for wo in views()])
    albedo, right = ours.sum(1), theirs.sum(1)
    print(np.array2string(albedo / right, precision=4))
    worst = np.abs(albedo / right - 1).max()
    assert worst < 0.01, f"directional albedo over the right one, by view and channel: {albedo / right}"
    assert (np.abs(ours - theirs).sum(1) / right).max() < 0.01, "the same albedo, but light goes elsewhere"


@pytest.mark.parametrize("name", CASES)
def test_combiners_are_what_materialx_says(kernel_runner, name):
    graph = Graph()
    graph.add("/surface", "ND_surface")
    graph.connect(graph.closure(CASES[name]), "out", "/surface", "bsdf")
    compare(kernel_runner, material(graph), CASES[name])


def test_standard_surface_is_its_layers(kernel_runner):
    """Coat, metal, specular, sheen and base by the graph of MaterialX, written out; roughness is the root of alpha."""
    graph = Graph()
    values = {
        "base": 0.8, "base_color": RUST, "diffuse_roughness": 0.5, "specular": 0.9, "specular_color": STRAW,
        "specular_roughness": 0.5, "specular_IOR": 1.45, "sheen": 0.6, "sheen_color": ROSE, "sheen_roughness": 0.4,
        "coat": 0.7, "coat_color": (0.9, 0.7, 0.5), "coat_roughness": 0.45, "coat_IOR": 1.6,
    }  # fmt: skip
    graph.add("/surface", "ND_standard_surface_surfaceshader", values)
    below = ref.Layer(ref.Sheen(0.6, ROSE, 0.4), ref.OrenNayar(0.8, RUST, 0.5))
    body = ref.Layer(ref.Dielectric(0.25, 0.9, STRAW, ior=1.45), below)
    attenuation = tuple(float(1 + 0.7 * (c - 1)) for c in values["coat_color"])
    whole = ref.Layer(ref.Dielectric(0.45**2, 0.7, ior=1.6), ref.Multiply(body, attenuation))
    compare(kernel_runner, material(graph), whole)


STANDARD, OPEN = "ND_standard_surface_surfaceshader", "ND_open_pbr_surface_surfaceshader"
WHITE_STANDARD = {"base": 1.0, "base_color": WHITE, "specular": 1.0, "sheen_color": WHITE}
WHITE_OPEN = {"base_color": WHITE, "fuzz_color": WHITE, "coat_color": WHITE}
WHITES: dict[str, tuple[str, dict[str, Any]]] = {
    "standard_surface": (STANDARD, {}),
    "mirror-like": (STANDARD, {"specular_roughness": 0.0, "specular_IOR": 2.0}),
    "rough": (STANDARD, {"specular_roughness": 1.0}),
    "coated": (STANDARD, {"coat": 1.0, "coat_roughness": 0.6, "specular_roughness": 0.8}),
    "velvet": (STANDARD, {"sheen": 1.0, "sheen_roughness": 0.3}),
    "metal": (STANDARD, {"metalness": 1.0, "specular_roughness": 0.9}),
    "OpenPBR": (OPEN, {}),
    "rough OpenPBR": (OPEN, {"specular_roughness": 1.0, "base_diffuse_roughness": 1.0}),
    "coated OpenPBR": (OPEN, {"coat_weight": 1.0, "coat_roughness": 0.6, "specular_ior": 2.0}),
    "fuzzy OpenPBR": (OPEN, {"fuzz_weight": 1.0, "fuzz_roughness": 0.4}),
    "metallic OpenPBR": (OPEN, {"base_metalness": 1.0, "specular_roughness": 0.9}),
}


@pytest.mark.parametrize("name", WHITES)
def test_white_gives_no_more_than_it_gets(kernel_runner, name):
    """Directional albedo of at most 1.005 at 95 % confidence: Student's t, one-sided, of 16 scrambled sequences."""
    node, values = WHITES[name]
    graph = Graph()
    graph.add("/surface", node, (WHITE_STANDARD if node == STANDARD else WHITE_OPEN) | values)
    sequences = 16
    numbers = np.concatenate([qmc.Sobol(3, seed=k).random_base2(11) for k in range(sequences)]) * (1 - 1e-7)
    given = np.broadcast_to(numbers, (len(VIEWS), *numbers.shape))
    weights = run(kernel_runner, material(graph), views(), given, samples=True)
    means = weights.reshape(len(VIEWS), sequences, -1, 3).mean(2)
    mean, error = means.mean(1), means.std(1, ddof=1) / sequences**0.5
    print(np.array2string(mean.max(1), precision=4), np.array2string(error.max(1), precision=4))
    assert (mean + t.ppf(0.95, sequences - 1) * error <= 1.005).all(), f"{mean} +- {error}"
    assert mean.min() > 0.9, "that is not white"
