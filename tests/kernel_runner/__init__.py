# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Run a piece of GLSL on the Vulkan device and look at what it wrote: unit tests of shader code.

    out = kernel_runner.run(
        '''
        #version 460
        layout(local_size_x = 64) in;
        layout(binding = 0) buffer Values { float values[]; };
        void main() { values[gl_GlobalInvocationID.x] *= 2.0; }
        ''',
        buffers={0: np.arange(64, dtype=np.float32)},
        groups=(1, 1, 1),
    )
    out[0]  # the doubled values

`#include "lib/sampler.glsl"` finds files under wavefront/kernels, wavefront and the root of the tree.
$HDWAVEFRONT_VALIDATION=1 turns the validation layer on, $HDWAVEFRONT_DEVICE chooses the device.
"""

from __future__ import annotations

import atexit
import functools
import importlib
import importlib.machinery
import os
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import ModuleType

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
INCLUDE_FOLDERS = (ROOT / "wavefront" / "kernels", ROOT / "wavefront", ROOT)

# Nanoseconds of device time of the last dispatch of the last run().
last_nanoseconds = 0.0


def _load():
    """The compiled module: $HDWAVEFRONT_BUILD_DIR, else the newest under build/."""
    chosen = os.environ.get("HDWAVEFRONT_BUILD_DIR")
    folders = [Path(chosen)] if chosen else [ROOT / "build", *sorted((ROOT / "build").glob("*/"))]
    found = []
    for folder in folders:
        for suffix in importlib.machinery.EXTENSION_SUFFIXES:  # those that this Python can load
            found += [*folder.glob(f"_kernel_runner{suffix}"), *folder.glob(f"python/_kernel_runner{suffix}")]
    if not found:
        raise ImportError(
            "the test module _kernel_runner is not built for this Python: build the target _kernel_runner, or set "
            f"HDWAVEFRONT_BUILD_DIR (looked in {', '.join(str(f) for f in folders)})"
        )
    newest = max(found, key=lambda path: path.stat().st_mtime)
    sys.path.insert(0, str(newest.parent))
    try:
        return importlib.import_module("_kernel_runner")
    finally:
        sys.path.pop(0)


_native = _load()
atexit.register(_native.release)


@functools.lru_cache(maxsize=256)
def _compile(source: str, stage: str, include: tuple[str, ...]) -> bytes:
    return _native.compile(source, stage, [*include, *(str(folder) for folder in INCLUDE_FOLDERS)])


def spirv(glsl: str, stage: str = "comp", include: Sequence[str | Path] = ()) -> bytes:
    """SPIR-V of a shader for Vulkan 1.3. RuntimeError with the compiler's log when it does not compile."""
    return _compile(glsl.lstrip(), stage, tuple(str(folder) for folder in include))


def run(
    glsl: str | bytes,
    buffers: Mapping[int | str, np.ndarray],
    groups: Sequence[int] = (1, 1, 1),
    push: bytes = b"",
    spec: Mapping[int, int] | None = None,
    texel: Mapping[int | str, tuple[np.ndarray, str]] | None = None,
    include: Sequence[str | Path] = (),
    repeat: int = 1,
) -> dict[int | str, np.ndarray]:
    """Dispatch a compute shader (GLSL text, or SPIR-V bytes) and return its storage buffers as new arrays.

    buffers: storage buffers by binding number, or by variable (or block) name in the shader.
    texel: uniform texel buffers: (array, format), format of r32ui r32f rg32ui rgba32ui rgba32f rgba8 rgba16f.
    spec: specialisation constants by constant_id, as the bits of a uint. push: at most 128 bytes.
    repeat: run the dispatch so often on the same buffers; last_nanoseconds is the time of the last one.
    """
    global last_nanoseconds
    code = glsl if isinstance(glsl, bytes) else spirv(glsl, "comp", include)
    names: dict[str, int] = {}

    def number(key: int | str) -> int:
        if isinstance(key, (int, np.integer)):
            return int(key)
        names.update(names or _native.binding_names(code))
        if key not in names:
            raise KeyError(f"the shader has no binding named {key!r} (it has {sorted(names)})")
        return names[key]

    inputs = [(number(key), "storage", np.ascontiguousarray(array).tobytes()) for key, array in buffers.items()]
    for key, (array, texel_format) in (texel or {}).items():
        inputs.append((number(key), texel_format, np.ascontiguousarray(array).tobytes()))
    size = tuple(int(count) for count in groups) + (1,) * (3 - len(groups))
    outputs, last_nanoseconds = _native.run(code, inputs, size, bytes(push), dict(spec or {}), repeat)
    return {
        key: np.frombuffer(data, dtype=array.dtype).reshape(array.shape).copy()
        for (key, array), data in zip(buffers.items(), outputs, strict=True)
    }


def native() -> ModuleType:
    """The compiled module itself, for what has no friendly half."""
    return _native


def validation_messages() -> list[str]:
    """Warnings and errors of the validation layer since the process started (the first hundred)."""
    return _native.validation_messages()


def device_name() -> str:
    return _native.device_name()


def subgroup_size() -> int:
    return _native.subgroup_size()
