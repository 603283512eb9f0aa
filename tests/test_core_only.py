# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""wavefront-bench builds where neither Python, USD, MaterialX nor OpenSubdiv are: its configuration asks for none.

Configured and planned only: compiling it all again would take CI minutes. The ordinary build compiles every source
in the plan, in the same library."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
BUILD = Path(os.environ.get("HDWAVEFRONT_BUILD_DIR", ROOT / "build/run"))
# What a machine with a GPU and nothing else lacks.
LACKING = ("Python", "nanobind", "pxr", "OpenUSD", "MaterialX", "OpenSubdiv", "GTest", "OpenColorIO")


def test_core_only_configures_and_asks_for_nothing_else(tmp_path: Path) -> None:
    cache = BUILD / "CMakeCache.txt"
    if not cache.exists():
        pytest.fail(f"{BUILD} is not configured", pytrace=False)
    said = dict(re.findall(r"^(\w+):INTERNAL=(.*)$", cache.read_text(), re.M))
    cmake, generator = said["CMAKE_COMMAND"], said["CMAKE_GENERATOR"]
    command = [cmake, "-S", str(ROOT), "-B", str(tmp_path), "-G", generator, "-DHDWAVEFRONT_CORE_ONLY=ON"]
    command += [f"-DCMAKE_DISABLE_FIND_PACKAGE_{name}=ON" for name in LACKING]
    command += ["-DHDWAVEFRONT_MATERIALX=/nowhere", "-DHDWAVEFRONT_OPENSUBDIV_LIBRARY=_-NOTFOUND"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    command = [cmake, "--build", str(tmp_path), "--target", "wavefront-bench", "--", "-n"]
    plan = subprocess.run(command, capture_output=True, text=True, check=False)
    assert plan.returncode == 0, plan.stdout + plan.stderr
    planned = (tmp_path / "compile_commands.json").read_text()
    assert "plugin/bench/program/main.cpp" in planned
    for room in ("plugin/python", "plugin/hydra", "delegate/mesh", "MaterialXCore", "opensubdiv"):
        assert room not in planned, f"{room} is built"
