# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`hdwavefront bench` as a command: wrong usage, what cannot be written, and what is kept when it is interrupted."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from hdwavefront.bench import runner, sweeps
from hdwavefront.bench.measure import GROUPS
from hdwavefront.bench.peers import compare
from hdwavefront.bench.runner import Outcome
from hdwavefront.bench.scenes import stage_scene
from hdwavefront.bench.worker import Task
from hdwavefront.cli.main import main

EMPTY = """#usda 1.0
def Sphere "sphere" {
}
def DistantLight "sun" {
}
"""


def measured(*_: object) -> Outcome:
    """As a worker's, of a scene without a megakernel."""
    turn = {"wall": 1.0, "cpu": 2.0, "paths": 10, "segments": 20, "rays": 30, "materialItems": 10}
    share = dict.fromkeys(GROUPS, 0.25)
    result = {
        **{"mpathsPerSecond": 1.0, "mpathsPerSecondSpread": 0.1, "mpathsPerCpuSecond": 0.5, "segmentsPerPath": 2.0},
        **{"segments": 20, "kernelMilliseconds": 1000.0, "stateBytesPerSegment": 500.0, "share": share},
        **{"millisecondsPerMillionSegments": share, "kernels": [], "turns": [{**turn, "share": share}]},
        **{"openSeconds": 0.1, "compileSeconds": 0.2, "firstPathSeconds": 0.3, "firstPictureSeconds": 0.4},
        **{"firstPictureCpuSeconds": 0.5, "memoryBytes": {}},
    }
    scene = {"triangles": 1, "uniqueTriangles": 1, "instances": 1, "materials": 1, "topologies": 1, "bvhSeconds": 0.0}
    return Outcome(scene=scene, modes={"wavefront": result}, seconds=1.0)


def test_wrong_usage_is_said(capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "nonsense"]) == 2
    assert "'nonsense' is no file, and none of scenes, carpaint" in capfd.readouterr().err
    assert main(["bench", "city", "--turns", "0"]) == 2


@pytest.mark.parametrize("options", [[], ["--quick"], ["--minutes", "1"]])
def test_a_broken_stage_is_said(options: list[str], tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "broken.usda"
    path.write_text("no usd")
    assert main(["bench", str(path), *options]) == 1
    assert "FAILED" in capfd.readouterr().out


@pytest.mark.parametrize("option", ["--json", "--pictures"])
def test_what_cannot_be_written_is_said_before(option: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "pool", option, "/proc/nowhere/bench"]) == 1
    said = capfd.readouterr()
    assert "/proc/nowhere/bench cannot be" in said.err and not said.out


def test_a_sweep_keeps_its_rows_when_it_is_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def interrupted(task: Task, _: float) -> Outcome:
        if task.settings["poolSize"] > 4096:
            raise KeyboardInterrupt
        return measured()

    monkeypatch.setattr(sweeps, "run_task", interrupted)
    file = tmp_path / "bench.json"
    assert main(["bench", "pool", "--json", str(file)]) == 130
    report = json.loads(file.read_text())
    assert [row["name"] for row in report["sweeps"]["pool"]] == ["4,096"] and "interrupted" in report["notes"][-1]
    said = capfd.readouterr()
    assert "| 4,096" in said.out and "what had been measured by then is kept" in said.err


def test_scenes_keep_their_results_when_they_are_interrupted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    def interrupted(_: object, __: object, ___: object, ____: object, outcomes: dict[str, Outcome]) -> None:
        outcomes["carpaint"], outcomes["city"] = measured(), Outcome()
        raise KeyboardInterrupt

    monkeypatch.setattr(runner, "run_side_by_side", interrupted)
    file = tmp_path / "bench.json"
    assert main(["bench", "carpaint", "city", "--json", str(file)]) == 130
    assert [scene["name"] for scene in json.loads(file.read_text())["scenes"]] == ["carpaint"]
    assert "| carpaint |" in capfd.readouterr().out


@pytest.mark.parametrize(
    ("what", "peer", "said"),
    [
        (["materials", "triangles"], "mitsuba", "'materials' is no scene that --peer mitsuba compares"),
        (["triangles"], "mitsuba", "'triangles' is no scene that --peer mitsuba compares"),
        (["city", "lights"], "embree", "'lights' is no scene that --peer embree compares"),
    ],
)
def test_sweeps_are_not_compared(what: list[str], peer: str, said: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", *what, "--peer", peer]) == 2
    assert said in capfd.readouterr().err


def test_peers_end_with_the_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    limits: list[float] = []

    def compared(*arguments: Any) -> None:
        limits.append(arguments[-1])
        raise compare.OutOfTime("it did not end")

    monkeypatch.setattr(compare, "why_absent", lambda _: "")
    monkeypatch.setattr(compare, "compare", compared)
    stage = tmp_path / "stage.usda"
    stage.write_text(EMPTY)
    file = tmp_path / "peers.json"
    assert main(["bench", str(stage), "--peer", "mitsuba", "--peer", "cycles", "--quick", "--json", str(file)]) == 0
    assert len(limits) == 2 and limits[0] <= 105 / 2 and limits[1] <= 105
    assert "by mitsuba: left out: it did not end" in capfd.readouterr().out
    assert json.loads(file.read_text())["seconds"] > 0
    assert main(["bench", str(stage), "--peer", "mitsuba", "--minutes", "0.01"]) == 0
    assert len(limits) == 2 and "left out" in capfd.readouterr().out


def test_a_peer_that_hangs_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "mitsuba_peer.py").write_text("import time; time.sleep(600)")
    monkeypatch.setattr(compare, "_HERE", tmp_path)
    with pytest.raises(compare.OutOfTime, match="mitsuba did not end within"):
        compare._run("mitsuba", "", {}, 0.2)


def test_our_own_side_of_a_comparison_ends_with_the_time(tmp_path: Path) -> None:
    stage = tmp_path / "stage.usda"
    stage.write_text(EMPTY)
    with pytest.raises(compare.OutOfTime, match="our own picture"):
        compare.compare("mitsuba", stage_scene(str(stage)), str(tmp_path), 16, 1, "", "scalar_rgb", 0.0)
