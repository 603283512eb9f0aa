# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Lets the end-to-end tests import their harness; they fail, and are not skipped, where the renderer is not built."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).resolve().parent))
os.environ.setdefault("HDWAVEFRONT_VALIDATION", "1")


@pytest.fixture(scope="session", autouse=True)
def renderer():
    try:
        from hdwavefront import _core
    except ImportError as error:
        pytest.fail(f"hdwavefront._core is not built: {error}", pytrace=False)
    return _core
