# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The settings that the Blender add-on builds its panel from are the rows of settings.def."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from hdwavefront import _core

SCRIPT = Path(__file__).resolve().parents[2] / "plugin/hydra/blender/settings_json.cmake"


def test_settings_json_holds_the_rows_of_the_core(tmp_path: Path) -> None:
    cmake = shutil.which("cmake")
    assert cmake, "the build needs CMake, so it is there"
    output = tmp_path / "settings.json"
    subprocess.run([cmake, f"-DOUTPUT={output}", "-P", str(SCRIPT)], check=True)
    written = json.loads(output.read_text())
    rows = _core.render_settings()
    assert [row["token"] for row in written] == [row["token"] for row in rows]
    for json_row, row in zip(written, rows, strict=True):
        assert json_row["type"].lower() == row["type"]
        assert json_row["doc"] == row["doc"]
        if row["type"] == "token":
            assert json_row["default"] == row["default"]
            assert json_row["minimum"].split("|") == row["choices"]
            continue
        for key in ("default", "minimum", "maximum"):
            assert float(json_row[key]) == pytest.approx(float(row[key])), row["token"]
