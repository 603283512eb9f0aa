# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Fixtures of all Python tests."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))


@pytest.fixture(scope="session")
def kernel_runner():
    """The module that runs GLSL on the device; a test that needs it fails when it is not built."""
    try:
        import kernel_runner as module
    except ImportError as error:
        pytest.fail(str(error), pytrace=False)
    yield module


@pytest.fixture(autouse=True)
def no_validation_messages(request: pytest.FixtureRequest):
    """A test that runs kernels fails when the validation layer has something to say."""
    if "kernel_runner" not in request.fixturenames:
        yield
        return
    module = request.getfixturevalue("kernel_runner")
    before = len(module.validation_messages())
    yield
    messages = module.validation_messages()[before:]
    assert not messages, "\n".join(messages)
