# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Fixtures of the Python host's tests: stages from text, a recording delegate, third-party assets."""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[2]
if not any((Path(p) / "hdwavefront").is_dir() for p in sys.path if p):
    sys.path.insert(0, str(ROOT / "plugin/python"))
sys.path.insert(0, str(Path(__file__).resolve().parent))


@pytest.fixture
def recorded(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """hdwavefront over a delegate that records; the list fills with the delegates that are made."""
    import hdwavefront
    from recording import fake_core

    delegates: list[Any] = []
    core = fake_core(delegates)
    monkeypatch.setitem(sys.modules, "hdwavefront._core", core)
    monkeypatch.setattr(hdwavefront, "_core", core, raising=False)
    return delegates


@pytest.fixture
def stage_file(tmp_path: Path) -> Callable[[str], str]:
    """Writes USD text to a file and gives its path. Names differ: USD keeps layers by path as long as one is in use."""
    count = itertools.count()

    def write(text: str, name: str = "") -> str:
        path = tmp_path / (name or f"stage{next(count)}.usda")
        path.write_text("#usda 1.0\n" + text, encoding="utf-8")
        return str(path)

    return write


@pytest.fixture
def run(recorded: list[Any], capfd: pytest.CaptureFixture[str], tmp_path: Path) -> Callable[..., tuple[int, str, str]]:
    """Runs the command in this process; gives (exit code, stdout, stderr)."""
    from hdwavefront.cli.main import main

    def call(*arguments: object) -> tuple[int, str, str]:
        code = main([str(a) for a in arguments])
        out, err = capfd.readouterr()
        assert "Traceback" not in err
        return code, out, err

    return call


@pytest.fixture
def scene(stage_file: Callable[..., str]) -> str:
    """A small stage with cameras /main_cam and /other and a cube."""
    from usda import SCENE

    return stage_file(SCENE)


@pytest.fixture
def translated() -> Callable[..., Any]:
    """Translates USD text; gives the recording delegate (which keeps the `translation`) and the diagnostics."""
    from hdwavefront.errors import Diagnostics
    from hdwavefront.stage_adapters.context import Options
    from hdwavefront.stage_adapters.traversal import translate
    from pxr import Sdf, Usd
    from recording import RecordingDelegate

    def run(text: str, time: float | None = None, **options: Any) -> tuple[RecordingDelegate, Diagnostics]:
        layer = Sdf.Layer.CreateAnonymous(".usda")
        # Tests write short prims on one line; USD wants a line for each statement.
        text = text.replace("{ ", "{\n").replace(" }", "\n}").replace("} def", "}\ndef").replace("; ", "\n")
        assert layer.ImportFromString("#usda 1.0\n" + text)
        delegate, diagnostics = RecordingDelegate(), Diagnostics()
        code = Usd.TimeCode.Default() if time is None else Usd.TimeCode(time)
        delegate.translation = translate(Usd.Stage.Open(layer), Options(time=code, **options), delegate, diagnostics)
        return delegate, diagnostics

    return run


@pytest.fixture(scope="session")
def assets() -> Path:
    """The third-party assets, which are not in the tree: HDWAVEFRONT_ASSETS, or shared/assets beside the checkout."""
    places = [os.environ.get("HDWAVEFRONT_ASSETS", ""), str(ROOT.parent / "shared/assets"), str(ROOT / "shared/assets")]
    for place in places:
        if place and Path(place).is_dir():
            return Path(place)
    pytest.skip("the third-party assets are not here (HDWAVEFRONT_ASSETS names their folder)")


@pytest.fixture
def looks(stage_file: Callable[[str], str], tmp_path: Path) -> Callable[..., Any]:
    """Translates a stage beside a document m.mtlx; gives the recording delegate and the diagnostics."""
    from hdwavefront.errors import Diagnostics
    from hdwavefront.stage import open_stage
    from hdwavefront.stage_adapters.context import Options
    from hdwavefront.stage_adapters.traversal import translate
    from pxr import Usd
    from recording import RecordingDelegate

    def run(document: str | bytes | None, stage: str, **options: Any) -> tuple[RecordingDelegate, Diagnostics]:
        if document is not None:
            text = document.encode() if isinstance(document, str) else document
            (tmp_path / "m.mtlx").write_bytes(text)
        diagnostics, delegate = Diagnostics(), RecordingDelegate()
        delegate.stage = open_stage(stage_file(stage), diagnostics)
        translate(delegate.stage, Options(time=Usd.TimeCode(0), **options), delegate, diagnostics)
        return delegate, diagnostics

    return run
