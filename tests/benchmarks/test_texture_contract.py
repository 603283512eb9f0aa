# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The benchmark of texture reads stays able to run, and compares like with like: all its ways give the same values."""

from __future__ import annotations

import pytest


def quiet(_: str) -> None:
    pass


@pytest.mark.parametrize("texel_format", ["rgba8", "rgba16f"])
@pytest.mark.parametrize("count", [1, 8])
def test_all_ways_give_the_same_values(kernel_runner, count, texel_format):
    from benchmarks import texture_contract

    case = texture_contract.read_case(count, 128, texel_format, 1024, 1, quiet)
    assert case["wrong"] == []
    exact = {way.name: error for way, error in case["errors"].items() if way.exact}
    assert len(exact) == 4 and len(case["errors"]) == (7 if count == 8 else 6)
    assert 0 < max(exact.values()) < 2e-6


def test_kernels_of_several_reads_compile(kernel_runner):
    from benchmarks import texture_contract

    times = texture_contract.compile_case(1, (1, 2), quiet)
    assert len(times) == 14 and min(times.values()) > 0
