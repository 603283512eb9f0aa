# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Runs functions of the core's GLSL library with the real bindings: frame constants, lights, textures, geometry.

The uniform block becomes a storage buffer (kernel_runner has no uniform buffers); everything else is included as it is.
Bindings that a test does not give get 64 zero bytes.
"""

from __future__ import annotations

import re
import tempfile
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
SHARED = ROOT / "wavefront" / "shared"

NO_STREAM = 0xFFFFFFFF
NO_LIGHT = 0xFFFFFFFF


@lru_cache
def bindings() -> dict[str, tuple[int, str]]:
    """Variable of lib/bindings.glsl -> (number, texel format or "storage")."""
    text = (ROOT / "wavefront/kernels/lib/bindings.glsl").read_text()
    found: dict[str, tuple[int, str]] = {}
    for number, name in re.findall(
        r"binding = (\d+), scalar\) (?:uniform|buffer) \w+ \{ [\w ]*?(\w+)(?:\[\])?; \}", text
    ):
        found[name] = (int(number), "storage")
    for number, kind, name in re.findall(r"binding = (\d+)\) uniform (u?)textureBuffer (\w+);", text):
        single = name in ("indexStream", "primvarStream", "lightDistribution", "pageTable")
        texel = ("r32" if single else "rgba32") + ("ui" if kind else "f")
        if name == "lobeTable":
            texel = "rg32ui"
        found[name] = (int(number), texel)
    assert len(found) == len(re.findall(r"^layout\(set = 0", text, re.M)), "a binding that this pattern does not read"
    return found


@lru_cache
def frame_type() -> np.dtype:
    """FrameConstants of shared/frame_constants.h (scalar block layout: every member right after the one before)."""
    text = (SHARED / "frame_constants.h").read_text()
    body = text.split("struct FrameConstants {")[1].split("};")[0]
    body = re.sub(r"//.*", "", body)
    fields: list[tuple] = []
    for kind, names in re.findall(r"\b(vec4|float|uint)\s+([\w,\s]+);", body):
        for name in (n.strip() for n in names.split(",")):
            fields.append(
                (name, np.float32, (4,)) if kind == "vec4" else (name, np.float32 if kind == "float" else np.uint32)
            )
    return np.dtype(fields)


def frame(**values) -> np.ndarray:
    constants = np.zeros(1, frame_type())
    for name, value in values.items():
        constants[name] = value
    return constants


@lru_cache
def _include_folder() -> Path:
    folder = Path(tempfile.mkdtemp(prefix="hdwavefront-core-harness-"))
    text = (ROOT / "wavefront/kernels/lib/bindings.glsl").read_text()
    changed = text.replace("uniform FrameConstantsBlock", "readonly buffer FrameConstantsBlock")
    assert changed != text
    (folder / "lib").mkdir()
    (folder / "lib" / "bindings.glsl").write_text(changed)
    return folder


HEAD = """
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/bindings.glsl"
layout(local_size_x = 64) in;
layout(binding = 40, scalar) readonly buffer In { vec4 inputs[]; };
layout(binding = 41, scalar) buffer Out { vec4 outputs[]; };
"""


def call(
    runner,
    includes: list[str],
    main: str,
    inputs: np.ndarray,
    outputs: int,
    tables: Mapping[str, np.ndarray | bytes] | None = None,
    frame_values: Mapping[str, object] | None = None,
    spec: Mapping[int, int] | None = None,
) -> np.ndarray:
    """Runs `main` (statements; `i` is the invocation, inputs[k * i ...] its vec4s) for each row of `inputs`.

    inputs: (n, k) vec4s as (n, 4 k) 32-bit values. Returns (n, 4 * outputs) floats; write to outputs[i * OUT + j].
    """
    inputs = np.ascontiguousarray(inputs)
    assert inputs.itemsize == 4 and inputs.ndim == 2 and inputs.shape[1] % 4 == 0
    count, k = len(inputs), inputs.shape[1] // 4
    source = HEAD + "".join(f'#include "{name}"\n' for name in includes)
    source += f"const uint OUT = {outputs}u;\nconst uint IN = {k}u;\n" + main
    given = {name: np.frombuffer(v, np.uint8) if isinstance(v, bytes) else v for name, v in (tables or {}).items()}
    given["frame"] = frame(**(frame_values or {}))
    storage: dict[int | str, np.ndarray] = {
        40: inputs.view(np.float32),
        41: np.zeros((count, 4 * outputs), np.float32),
    }
    texel: dict[int | str, tuple[np.ndarray, str]] = {}
    for name, (number, kind) in bindings().items():
        data = given.pop(name, None)
        data = np.zeros(16, np.uint32) if data is None or data.size == 0 else np.ascontiguousarray(data)
        if kind == "storage":
            storage[number] = data.view(np.uint8).reshape(-1)
        else:
            texel[number] = (data.view(np.uint8).reshape(-1), kind)
    assert not given, f"no such binding: {sorted(given)}"
    out = runner.run(
        source, storage, ((count + 63) // 64,), push=bytes(16), spec=spec, texel=texel, include=[_include_folder()]
    )
    result = out[41]
    call.storage = {name: out[number] for name, (number, kind) in bindings().items() if kind == "storage"}
    return result


def bits(values) -> np.ndarray:
    """Unsigned integers as the floats of the same bits."""
    return np.asarray(values, np.uint32).view(np.float32)


def chi2_p(statistic: float, degrees: int) -> float:
    """Upper tail of the chi-square distribution (Wilson and Hilferty 1931: good to 1 % of itself down to 1e-6)."""
    from math import erfc, sqrt

    if degrees <= 0:
        return 1.0
    z = ((statistic / degrees) ** (1 / 3) - (1 - 2 / (9 * degrees))) / sqrt(2 / (9 * degrees))
    return 0.5 * erfc(z / sqrt(2))
