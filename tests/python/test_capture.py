# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`hdwavefront capture` and wavefront-bench: what is replayed is what would have been rendered, to the bit."""

from __future__ import annotations

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

TESTENV = Path(__file__).resolve().parents[2] / "testenv"
BUILD = Path(os.environ.get("HDWAVEFRONT_BUILD_DIR", Path(__file__).resolve().parents[2] / "build/run"))
BENCH = BUILD / "bin/wavefront-bench"
WIDTH, SAMPLES = 24, 2

# name: options of `capture` and of `Render`
SCENES: dict[str, tuple[list[str], dict[str, Any]]] = {
    "Mitsuba.Cornell": ([], {}),
    "Material.Texture": (["--aov", "depth", "--aov", "albedo"], {"aovs": ["depth", "albedo"]}),
    "Instance.PointInstancer": (["--camera", "/cam"], {"camera": "/cam"}),
    "Media.NestedDielectrics": ([], {}),
    "Displacement.Closed": ([], {}),
}


def film_hash(film: Any) -> str:
    """As delegate/capture/scene_file.cpp's Checksum, over the sums and then the first samples."""

    def add(data: bytes, value: int) -> int:
        words = np.frombuffer(data[: len(data) // 8 * 8], dtype="<u8").tolist()
        for word in (*words, int.from_bytes(data[len(data) // 8 * 8 :], "little"), len(data)):
            value = ((value ^ word) * 0x100000001B3) & 0xFFFFFFFFFFFFFFFF
            value ^= value >> 29
        return value

    return f"{add(film.first.tobytes(), add(film.sums.tobytes(), 0xCBF29CE484222325)):016x}"


def capture(stage: Path, file: Path, *options: str) -> None:
    from hdwavefront.cli.main import main

    arguments = ["capture", str(stage), str(file), "--imageWidth", str(WIDTH), "--samples", str(SAMPLES), *options]
    assert main(arguments) == 0


def replay(file: Path, *options: str) -> subprocess.CompletedProcess[str]:
    if not BENCH.exists():
        pytest.fail(f"{BENCH} is not built", pytrace=False)
    # Nothing of Python or USD reaches it but Mesa's cache.
    kept = ("HOME", "XDG_CACHE_HOME", "MESA_SHADER_CACHE_DIR", "HDWAVEFRONT_CACHE_DIR", "VK_ICD_FILENAMES")
    environment = {name: os.environ[name] for name in kept if name in os.environ}
    command = [str(BENCH), str(file), "--runs", "1", *options]
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)


@pytest.mark.parametrize("name", SCENES)
def test_replays_to_the_bit(name: str, tmp_path: Path) -> None:
    from hdwavefront.api import Render

    flags, options = SCENES[name]
    stage = TESTENV / name / "scene.usda"
    render = Render(str(stage), width=WIDTH, settings={"samples": SAMPLES}, **options)
    render.start()
    render.wait()
    film = render.delegate.read_film()
    assert np.ptp(render.map("color")) > 0, "a picture of nothing proves nothing"
    expected = film_hash(film)

    file, facts_file = tmp_path / "a.hdwscene", tmp_path / "a.json"
    capture(stage, file, *flags)
    mode = "both" if name == "Mitsuba.Cornell" else "wavefront"
    done = replay(file, "--json", str(facts_file), "--image", str(tmp_path / "a.pfm"), "--mode", mode)
    assert done.returncode == 0, done.stdout + done.stderr
    facts = json.loads(facts_file.read_text())["scenes"][0]
    assert facts["identical"] is True
    assert facts["wavefront"]["film"] == expected
    assert facts["wavefront"]["mpathsPerSecond"] > 0
    if mode == "both":
        assert facts["megakernel"]["film"] == expected
        assert facts["gain"] > -1
    magic, size, scale, pixels = (tmp_path / "a.pfm").read_bytes().split(b"\n", 3)
    assert (magic, scale) == (b"PF", b"-1.0")
    width, height = map(int, size.split())
    image = np.frombuffer(pixels, dtype="<f4").reshape(height, width, 3)[::-1]
    assert np.array_equal(image, render.map("color")[..., :3])


def test_rays_are_cast_through_a_captured_scene(tmp_path: Path) -> None:
    file, facts_file = tmp_path / "a.hdwscene", tmp_path / "a.json"
    capture(TESTENV / "Mitsuba.Cornell/scene.usda", file)
    done = replay(file, "--rays", "--json", str(facts_file))
    assert done.returncode == 0, done.stdout + done.stderr
    rays = json.loads(facts_file.read_text())["scenes"][0]["rays"]
    assert [r["kind"] for r in rays] == ["camera", "bounce 1", "bounce 2"]
    assert all(r["mraysPerSecond"] > 0 and r["nodeBytesPerRay"] > 0 for r in rays)
    assert rays[1]["hits"] / rays[1]["rays"] > 0.5, "most of what a box's walls see is the box"
    assert "node B" in done.stdout and "bounce 2" in done.stdout


def test_capture_needs_no_device(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("VK_ICD_FILENAMES", str(tmp_path / "none.json"))
    monkeypatch.setenv("VK_DRIVER_FILES", str(tmp_path / "none.json"))
    capture(TESTENV / "Mitsuba.Cornell/scene.usda", tmp_path / "a.hdwscene")
    assert (tmp_path / "a.hdwscene").read_bytes().startswith(b"HDWSCENE")


def test_a_scene_of_the_benchmark_is_captured_by_name(tmp_path: Path) -> None:
    """With its long paths, which the stage asks for: the same as where options do."""
    from hdwavefront.bench.scenes import SCENES
    from hdwavefront.cli.main import main

    named, optioned = tmp_path / "named.hdwscene", tmp_path / "optioned.hdwscene"
    assert main(["capture", "conference", str(named)]) == 0
    scene = SCENES["conference"](str(tmp_path))
    assert scene.settings == {"maxBounces": 16, "rouletteBounce": 6}
    options = ["--maxBounces", "16", "--rouletteBounce", "6", "--imageWidth", "640", "--imageHeight", "360"]
    assert main(["capture", scene.path, str(optioned), *options]) == 0
    done = replay(named, "--compare", str(optioned))
    assert (done.returncode, done.stdout) == (0, "The same to the bit.\n"), done.stdout + done.stderr


def test_a_file_comes_before_a_scene_of_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    from hdwavefront.cli.main import main

    Path("carpaint").write_text("no usd")
    assert main(["capture", "carpaint", "out.hdwscene"]) == 1
    assert "The stage carpaint is broken" in capfd.readouterr().err


def test_textures_are_halved_where_asked(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    stage = TESTENV / "Material.Texture/scene.usda"
    capture(stage, tmp_path / "whole.hdwscene")
    assert "textures were halved" not in capfd.readouterr().out
    capture(stage, tmp_path / "small.hdwscene", "--maxTexture", "1")
    assert "textures were halved" in capfd.readouterr().out
    assert (tmp_path / "small.hdwscene").stat().st_size < (tmp_path / "whole.hdwscene").stat().st_size


def test_bad_files_are_refused_by_name(tmp_path: Path) -> None:
    file = tmp_path / "a.hdwscene"
    capture(TESTENV / "Mitsuba.Cornell/scene.usda", file)
    data = bytearray(file.read_bytes())
    at = data.index(b"MESHES") + 40
    data[at] ^= 0x10
    for name, content, words in (
        ("cut.hdwscene", data[: len(data) // 2], "cut off"),
        ("damaged.hdwscene", data, "chunk MESHES is damaged"),
        ("foreign.hdwscene", b"#usda 1.0\n", "no scene"),
    ):
        bad = tmp_path / name
        bad.write_bytes(content)
        done = replay(bad)
        assert done.returncode == 1
        assert str(bad) in done.stderr
        assert words in done.stderr
    assert replay(tmp_path / "missing.hdwscene").returncode == 1
    assert replay(file, "--pool", "many").returncode == 2


def test_what_cannot_be_captured_is_said(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    from hdwavefront.cli.main import main

    stage = str(TESTENV / "Mitsuba.Cornell/scene.usda")
    for arguments, code in (
        ([stage, str(tmp_path / "no/folder.hdwscene")], 1),
        ([stage, str(tmp_path)], 1),
        ([str(tmp_path / "none.usda"), str(tmp_path / "a.hdwscene")], 1),
        ([stage, str(tmp_path / "a.hdwscene"), "--imageWidth", "0"], 2),
        ([stage, str(tmp_path / "a.hdwscene"), "--maxTexture", "-1"], 2),
    ):
        assert main(["capture", *arguments]) == code
        assert "error:" in capfd.readouterr().err
    assert not list(tmp_path.iterdir())
