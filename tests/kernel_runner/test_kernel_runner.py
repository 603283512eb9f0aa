# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The runner itself: what goes in comes out, errors have text, validation listens."""

from __future__ import annotations

import numpy as np
import pytest

DOUBLE = """
#version 460
layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint kFactor = 2;
layout(push_constant) uniform Push { uint addend; };
layout(binding = 0) buffer Values { uint values[]; } state;
layout(binding = 3) uniform usamplerBuffer offsets;
void main() {
  uint i = gl_GlobalInvocationID.x;
  state.values[i] = state.values[i] * kFactor + addend + texelFetch(offsets, int(i)).x;
}
"""


def test_buffers_texels_push_and_spec(kernel_runner):
    values = np.arange(128, dtype=np.uint32)
    offsets = 1000 * np.arange(128, dtype=np.uint32)
    out = kernel_runner.run(
        DOUBLE,
        buffers={"state": values},
        groups=(2,),
        push=np.uint32(7).tobytes(),
        spec={0: 64, 1: 3},
        texel={3: (offsets, "r32ui")},
    )
    np.testing.assert_array_equal(out["state"], values * 3 + 7 + offsets)
    np.testing.assert_array_equal(values, np.arange(128))
    assert kernel_runner.last_nanoseconds > 0


@pytest.mark.parametrize(
    ("texel_format", "array"),
    [
        ("r32f", np.linspace(-1, 1, 16, dtype=np.float32)),
        ("rgba32f", np.linspace(-1, 1, 64, dtype=np.float32).reshape(16, 4)),
        ("rgba16f", np.linspace(-1, 1, 64).astype(np.float16).reshape(16, 4)),
        ("rgba8", np.arange(64, dtype=np.uint8).reshape(16, 4)),
    ],
)
def test_float_texel_formats(kernel_runner, texel_format, array):
    source = """
    #version 460
    layout(local_size_x = 16) in;
    layout(binding = 0, std430) buffer Out { vec4 result[]; };
    layout(binding = 1) uniform samplerBuffer texels;
    void main() { result[gl_GlobalInvocationID.x] = texelFetch(texels, int(gl_GlobalInvocationID.x)); }
    """
    out = kernel_runner.run(source, {"Out": np.zeros((16, 4), np.float32)}, texel={"texels": (array, texel_format)})
    expected = array.astype(np.float32).reshape(16, -1) / (255.0 if texel_format == "rgba8" else 1.0)
    np.testing.assert_allclose(out["Out"][:, : expected.shape[1]], expected, rtol=0, atol=1e-7)


def test_repeat_runs_on_the_same_buffers(kernel_runner):
    source = """
    #version 460
    layout(local_size_x = 1) in;
    layout(binding = 0) buffer Counter { uint count; };
    void main() { count += 1; }
    """
    out = kernel_runner.run(source, {0: np.zeros(1, np.uint32)}, repeat=5)
    assert out[0][0] == 5


def test_includes_of_the_tree(kernel_runner, tmp_path):
    (tmp_path / "answer.glsl").write_text('#include "inner.glsl"\n')
    (tmp_path / "inner.glsl").write_text("const uint kAnswer = 42;\n")
    source = """
    #version 460
    #include "shared/scene_layout.h"
    #include "answer.glsl"
    layout(local_size_x = 1) in;
    layout(binding = 0) buffer Out { uint result[]; };
    void main() { result[0] = kAnswer; result[1] = kBvhNodeTexels; }
    """
    out = kernel_runner.run(source, {0: np.zeros(2, np.uint32)}, include=[tmp_path])
    assert out[0].tolist() == [42, 4]


def test_glsl_errors_carry_the_log(kernel_runner):
    with pytest.raises(RuntimeError, match="undeclared identifier"):
        kernel_runner.run("#version 460\nlayout(local_size_x = 1) in;\nvoid main() { nonsense = 1; }", {})
    with pytest.raises(RuntimeError, match=r"missing\.glsl"):
        kernel_runner.spirv('#version 460\n#include "missing.glsl"\nvoid main() {}')


def test_wrong_arguments_are_errors(kernel_runner):
    source = "#version 460\nlayout(local_size_x = 1) in;\nvoid main() {}"
    with pytest.raises(KeyError, match="no binding named 'values'"):
        kernel_runner.run(source, {"values": np.zeros(1)})
    with pytest.raises(RuntimeError, match="unknown texel format"):
        kernel_runner.run(source, {}, texel={0: (np.zeros(4, np.uint32), "rgb9")})
    with pytest.raises(RuntimeError, match="128 bytes"):
        kernel_runner.run(source, {}, push=bytes(132))
