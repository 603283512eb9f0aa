# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`hdwavefront record` over a delegate that records: arguments, messages, exit codes, files."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import OpenImageIO as oiio
import pytest
from usda import SCENE


def test_a_render_is_written(run, scene, tmp_path, recorded):
    image = tmp_path / "a.exr"
    code, out, err = run("record", scene, image, "-w", 40, "--aov", "depth", "--aov", "primId", "--samples", 9)
    assert code == 0 and str(image) in out and err == ""
    delegate = recorded[0]
    assert delegate.render_pass["camera"] == "/main_cam"
    assert (delegate.render_pass["width"], delegate.render_pass["height"]) == (40, 20)
    assert delegate.render_pass["aovs"] == ["color", "depth", "primId"] and delegate.settings["samples"] == 9
    source = oiio.ImageInput.open(str(image))
    spec = source.spec()
    assert set(spec.channelnames) == {"R", "G", "B", "A", "depth.Z", "primId.id"}
    assert spec.get_int_attribute("hdwavefront:samples") == 9
    assert spec.getattribute("worldToCamera") is not None and spec.getattribute("worldToNDC") is not None
    assert [p.name for p in tmp_path.iterdir() if p.suffix == ".exr"] == ["a.exr"]  # nothing is left beside


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (("missing.usda", "o.exr"), 1, "missing.usda does not exist"),
        ((".", "o.exr"), 1, "is a folder"),
        (("SCENE", "o.xyz"), 2, "unknown extension '.xyz'"),
        (("SCENE", "o"), 2, "no extension"),
        (("SCENE", "nowhere/o.exr"), 1, "does not exist"),
        (
            ("SCENE", "o.exr", "--camera", "nobody"),
            1,
            "no camera 'nobody' in the stage. The stage's cameras: /main_cam",
        ),
        (("SCENE", "o.exr", "--camera", "/c"), 1, "no camera '/c'"),
        (("SCENE", "o.exr", "--camera", "not a path"), 1, "no camera 'not a path'"),
        (("SCENE", "o.exr", "-w", "0"), 2, "--imageWidth is 0"),
        (("SCENE", "o.exr", "-w", "-5"), 2, "--imageWidth is -5"),
        (("SCENE", "o.exr", "--imageHeight", "0"), 2, "--imageHeight is 0"),
        (("SCENE", "o.exr", "-w", "1000000"), 2, "too large"),
        (("SCENE", "o.exr", "-w", "60000", "--imageHeight", "60000"), 2, "too large"),
        (("SCENE", "o.exr", "--aov", "beauty2"), 2, "no AOV 'beauty2'. There are: color"),
        (("SCENE", "o.png", "--aov", "depth"), 2, "need an .exr file"),
        (("SCENE", "o.exr", "--samples", "many"), 2, "invalid int value"),
        (("SCENE", "o.exr", "--purposes", "render,beauty"), 2, "'beauty' is none of"),
        (("SCENE", "o.exr", "--mask", "/a..b"), 2, "--mask"),
        (("SCENE", "o.exr", "--complexity", "extreme"), 2, "invalid choice"),
        (("SCENE", "o.exr", "--view", "Nice"), 2, "has no view 'Nice'. It has:"),
        (("SCENE", "o.exr", "--display", "Wall"), 2, "no display 'Wall'"),
        (("SCENE", "o.exr", "--ocio", "none.ocio"), 1, "none.ocio (named by --ocio) cannot be read"),
        (("SCENE", "o.exr", "--renderingColorSpace", "mine"), 2, "'mine' is neither in"),
        (("SCENE", "o.exr", "--renderSettingsPrimPath", "/c"), 1, "no RenderSettings prim '/c'"),
        (("SCENE", "o.exr", "--renderPassPrimPath", "/c"), 1, "no RenderPass prim '/c'"),
        (("SCENE", "o.exr", "--sessionLayer", "none.usda"), 1, "session layer none.usda does not exist"),
        (("SCENE", "o.exr", "--enableCameraLight", "--disableCameraLight"), 2, "cannot both"),
        (("SCENE", "o.exr", "--stats", "nowhere/s.json"), 1, "--stats"),
        (("SCENE", "o.exr", "--traceToFile", "nowhere/t.json"), 1, "--traceToFile"),
        (("SCENE", "o.###.exr"), 2, "cannot contain a frame number placeholder"),
        (("SCENE", "o.exr", "--frames", "1:3"), 2, "exactly one frame number placeholder"),
        (("SCENE", "o.#.exr", "--frames", "1:2x0.5"), 2, "need 1 decimals"),
        (("SCENE", "o.#.exr", "--frames", "one"), 2, "is no FrameSpec"),
        (("SCENE", "o.#.exr", "--frames", "1:5x-1"), 2, "never leads"),
        (("SCENE", "o.#.exr", "--frames", "0:1e12"), 2, "more than"),
        ((), 2, "usage"),
    ],
)
def test_what_makes_no_sense_is_said_before_rendering(
    run, scene, tmp_path, monkeypatch, recorded, arguments, code, words
):
    monkeypatch.chdir(tmp_path)
    got, _, err = run("record", *(scene if a == "SCENE" else a for a in arguments))
    assert (got, words in err) == (code, True), err
    assert not any(name == "start" for d in recorded for name, _, _ in d.calls)
    assert not list(tmp_path.glob("o*"))


@pytest.mark.parametrize("content", ["", "#usda 1.0\ndef Cube {", "nonsense", "#usda 1.0\n" + "def " * 1000])
def test_a_broken_stage_is_said(run, tmp_path, content):
    broken = tmp_path / "broken.usda"
    broken.write_text(content)
    code, _, err = run("record", broken, tmp_path / "o.exr")
    assert code == 1 and "broken.usda" in err and err.count("\n") == 1


def test_an_output_that_cannot_be_written_is_said(run, scene, tmp_path):
    (tmp_path / "o.exr").mkdir()
    code, _, err = run("record", scene, tmp_path / "o.exr")
    assert code == 1 and "is a folder" in err
    if os.geteuid() == 0:
        return  # root may write everywhere
    locked = tmp_path / "locked"
    locked.mkdir(mode=0o500)
    code, _, err = run("record", scene, locked / "o.exr")
    assert code == 1 and "cannot be written to" in err


def test_frames(run, scene, tmp_path, recorded):
    code, out, _ = run("record", scene, tmp_path / "o.###.png", "--frames", "1,5:3x-2", "-w", 8)
    assert code == 0
    assert sorted(p.name for p in tmp_path.glob("*.png")) == ["o.001.png", "o.003.png", "o.005.png"]
    assert out.count("Time code:") == 3
    assert len(recorded) == 1  # one renderer for all frames


@pytest.mark.parametrize(("flags", "shown"), [((), "Time code: 3"), (("--defaultTime",), "Time code: default")])
def test_the_time_of_a_single_image(run, scene, tmp_path, flags, shown):
    _, out, _ = run("record", scene, tmp_path / "o.png", "-w", 8, *flags)
    assert shown in out


def test_prims_that_vanish_between_frames_are_removed(run, stage_file, tmp_path, recorded):
    stage = stage_file(
        """def Cube "c" {
    token visibility.timeSamples = { 1: "inherited", 2: "invisible" }
}
def Cube "d" {
}
"""
    )
    run("record", stage, tmp_path / "o.#.png", "--frames", "1:2", "-w", 8)
    assert recorded[0].named("implicit") == ["/d"]
    assert ("destroy_rprim", ("/c",), {}) in recorded[0].calls


LIGHT = "/__hdwavefront_camera_light"


@pytest.mark.parametrize(
    ("extra", "flags", "expected"),
    [
        ("", (), True),
        ("", ("--disableCameraLight",), False),
        ('def SphereLight "l" {\n}\n', (), False),
        ('def SphereLight "l" {\n}\n', ("--enableCameraLight",), True),
        (
            """def Material "m" {
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:emissiveColor = (1, 0, 0)
        token outputs:surface
    }
}
over "c" (prepend apiSchemas = ["MaterialBindingAPI"]) {
    rel material:binding = </m>
}
""",
            (),
            False,
        ),
    ],
)
def test_the_camera_light_comes_where_nothing_shines(run, stage_file, tmp_path, recorded, extra, flags, expected):
    # A second layer holds what is added, because one layer cannot say <c> twice.
    base = stage_file(SCENE, "base.usda")
    stage = stage_file(f"(\n    subLayers = [@{base}@]\n)\n{extra}")
    assert run("record", stage, tmp_path / "o.png", "-w", 8, *flags)[0] == 0
    assert (LIGHT in recorded[0].told) is expected


def test_cameras_are_found_in_order(run, stage_file, tmp_path, recorded):
    run("record", stage_file(SCENE), tmp_path / "o.png", "-w", 8, "--camera", "other")
    run("record", stage_file('def Camera "only" {\n}\n'), tmp_path / "o.png", "-w", 8)
    two = 'def Camera "a" {\n}\ndef Camera "b" {\n}\ndef Cube "c" {\n}\n'
    run("record", stage_file(two), tmp_path / "o.png", "-w", 8)
    names = [d.render_pass["camera"] for d in recorded]
    assert names == ["/other", "/only", "/__hdwavefront_free_camera"]


@pytest.mark.parametrize("up", ["Y", "Z"])
def test_the_free_camera_frames_the_stage(run, stage_file, tmp_path, recorded, up):
    """By usdrecord's rule: a 50 mm lens that just sees the front face of the box around everything."""
    run("record", stage_file(f'(\n    upAxis = "{up}"\n)\ndef Cube "c" {{\n}}\n'), tmp_path / "o.png", "-w", 8)
    camera = recorded[0].told["/__hdwavefront_free_camera"]
    distance = 2**0.5 / (20.955 / 2 / 50) + 1
    expected = (0, 0, distance) if up == "Y" else (0, -distance, 0)
    assert tuple(camera["transform"][3, :3]) == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("broken", ["double3 xformOp:scale = (1, 0, 1)", "double3 xformOp:scale = (1, inf, 1)"])
def test_the_free_camera_looks_past_broken_prims(run, stage_file, tmp_path, recorded, broken):
    """A singular transform makes USD's bound of the whole stage huge; the rest must be framed nevertheless."""
    sphere = 'def Sphere "S" {\n double radius = 2\n}\n'
    bad = f'def Cube "B" {{\n {broken}\n uniform token[] xformOpOrder = ["xformOp:scale"]\n}}\n'
    for text in (sphere, sphere + bad):
        assert run("record", stage_file(text), tmp_path / "o.png", "-w", 8)[0] == 0
    alone, beside = (d.told["/__hdwavefront_free_camera"]["transform"] for d in recorded)
    assert tuple(beside.flat) == pytest.approx(tuple(alone.flat))


def test_what_usd_warns_of_is_a_diagnostic(run, stage_file, tmp_path, capfd):
    text = 'def Sphere "S" {\n rel material:binding = </M>\n}\ndef Material "M" {\n}\n'
    code, _, err = run("record", stage_file(text), tmp_path / "o.png", "-w", 8)
    assert code == 0 and "MaterialBindingAPI" in err and "[usd-warning]" in err
    assert ".cpp" not in err + capfd.readouterr().err


RENDER = """(
    renderSettingsPrimPath = "/Render/s"
)
def Camera "a" {
}
def Camera "b" {
}
def Scope "Render" {
    def RenderSettings "s" {
        rel camera = </b>
        uniform int2 resolution = (30, 12)
        uniform float pixelAspectRatio = 2
        uniform token aspectRatioConformPolicy = "cropAperture"
        uniform token[] includedPurposes = ["default", "render"]
        custom int wavefront:samples = 5
        custom int wavefront:nonsense = 5
        rel products = [</Render/p>, </Render/q>]
    }
    def RenderProduct "p" {
        token productName = "layers.exr"
        rel orderedVars = [</Render/color>, </Render/z>, </Render/odd>]
    }
    def RenderProduct "q" {
        token productName = "look.png"
        rel orderedVars = [</Render/color>]
    }
    def RenderVar "color" {
        uniform string sourceName = "Ci"
    }
    def RenderVar "z" {
        uniform string sourceName = "cameraDepth"
    }
    def RenderVar "odd" {
        uniform string sourceName = "somethingElse"
    }
}
def Cube "r" {
    uniform token purpose = "render"
}
def Cube "x" {
    uniform token purpose = "proxy"
}
"""


def test_a_render_settings_prim_counts(run, stage_file, tmp_path, recorded):
    code, out, err = run("record", stage_file(RENDER), tmp_path / "o.exr")
    assert code == 0
    told = recorded[0]
    assert (told.render_pass["width"], told.render_pass["height"], told.render_pass["camera"]) == (30, 12, "/b")
    assert told.render_pass["pixel_aspect_ratio"] == 2 and told.render_pass["window_policy"] == "cropAperture"
    assert told.settings["samples"] == 5 and told.named("implicit") == ["/r"]
    assert told.render_pass["aovs"] == ["color", "cameraDepth"]
    assert "somethingElse" in err and "render-var-unsupported" in err
    layers = oiio.ImageInput.open(str(tmp_path / "layers.exr")).spec().channelnames
    assert set(layers) == {"R", "G", "B", "A", "cameraDepth.Z"}
    assert (tmp_path / "look.png").exists() and "look.png" in out


OTHERS = RENDER.replace(
    'token productName = "layers.exr"',
    'token productName = "layers.exr"\n        rel camera = </a>\n        uniform int2 resolution = (16, 8)\n'
    "        uniform float4 dataWindowNDC = (0.5, 0, 1, 1)\n",
)


def test_each_product_looks_for_itself(run, stage_file, tmp_path, recorded):
    assert run("record", stage_file(OTHERS), tmp_path / "o.exr")[0] == 0
    told = recorded[0]
    passes = [
        (values["camera"], values["width"], values["height"])
        for name, _, values in told.calls
        if name == "set_render_pass"
    ]
    assert passes == [("/b", 30, 12), ("/a", 8, 8)]
    assert [name for name, _, _ in told.calls].count("start") == 2  # look.png shares the first
    spec = oiio.ImageInput.open(str(tmp_path / "layers.exr")).spec()
    assert (spec.width, spec.height, spec.x, spec.y, spec.full_width, spec.full_height) == (8, 8, 8, 0, 16, 8)
    assert oiio.ImageInput.open(str(tmp_path / "look.png")).spec().width == 30


def test_flags_win_over_the_products_too(run, stage_file, tmp_path, recorded):
    text = OTHERS.replace("        uniform float4 dataWindowNDC = (0.5, 0, 1, 1)\n", "")
    assert run("record", stage_file(text), tmp_path / "o.exr", "-w", 60, "--camera", "/a")[0] == 0
    assert [name for name, _, _ in recorded[0].calls].count("start") == 1
    assert oiio.ImageInput.open(str(tmp_path / "layers.exr")).spec().width == 60


def test_flags_win_over_the_render_settings_prim(run, stage_file, tmp_path, recorded):
    flags = ("-w", 60, "--camera", "/a", "--purposes", "proxy", "--samples", 3)
    assert run("record", stage_file(RENDER), tmp_path / "o.exr", *flags)[0] == 0
    told = recorded[0]
    assert told.render_pass["width"] == 60 and told.render_pass["camera"] == "/a"
    assert told.settings["samples"] == 3 and told.named("implicit") == ["/x"]


def test_a_product_that_cannot_be_written_is_said_before_rendering(run, stage_file, tmp_path, recorded):
    text = RENDER.replace("layers.exr", "missing_folder/layers.exr")
    code, _, err = run("record", stage_file(text), tmp_path / "o.exr")
    assert code == 1 and "missing_folder" in err
    assert not any(name == "start" for name, _, _ in recorded[0].calls)


def test_the_mask_limits_the_stage(run, stage_file, tmp_path, recorded):
    text = 'def Cube "a" {\n}\ndef Cube "b" {\n}\ndef Cube "c" {\n}\n'
    run("record", stage_file(text), tmp_path / "o.png", "-w", 8, "--mask", "/a,/c")
    assert recorded[0].named("implicit") == ["/a", "/c"]


def test_a_mask_that_names_nothing_is_said(run, scene, tmp_path, recorded):
    code, _, err = run("record", scene, tmp_path / "o.png", "-w", 8, "--mask", "/nobody")
    assert code == 0 and "/nobody: --mask names this path, but there is no prim [mask-empty]" in err


def test_the_session_layer_is_stronger(run, stage_file, tmp_path, recorded):
    session = stage_file('over "c" (\n    active = false\n) {\n}\n', "session.usda")
    run("record", stage_file(SCENE), tmp_path / "o.png", "-w", 8, "--sessionLayer", session)
    assert recorded[0].named("implicit") == []


def test_ctrl_c_writes_what_there_is(run, scene, tmp_path, monkeypatch, recorded):
    from recording import RecordingDelegate

    def interrupt(self, timeout=0):
        raise KeyboardInterrupt

    monkeypatch.setattr(RecordingDelegate, "_wait", interrupt)
    code, _, err = run("record", scene, tmp_path / "o.#.exr", "-w", 8, "--frames", "1:3")
    assert code == 130 and "Interrupted after 7 of 64 samples" in err
    assert [p.name for p in tmp_path.glob("o*")] == ["o.1.exr"]  # the other frames are not begun
    assert recorded[0].stopped


def test_ctrl_c_within_the_first_sample_writes_nothing(run, scene, tmp_path, monkeypatch):
    from recording import RecordingDelegate

    def interrupt(self, timeout=0):
        raise KeyboardInterrupt

    nothing = {"pathsDone": 0, "pathsTotal": 9, "samplesDone": 0, "seconds": 0.0}
    monkeypatch.setattr(RecordingDelegate, "_wait", interrupt)
    monkeypatch.setattr(RecordingDelegate, "_progress", lambda self: nothing)
    code, _, err = run("record", scene, tmp_path / "o.exr", "-w", 8)
    assert code == 130 and "before the first sample" in err and not list(tmp_path.glob("o*"))


def test_ctrl_c_before_the_first_sample_writes_nothing(run, scene, tmp_path, monkeypatch):
    from recording import RecordingDelegate

    def interrupt(self):
        raise KeyboardInterrupt

    monkeypatch.setattr(RecordingDelegate, "_commit", interrupt, raising=False)
    code, _, err = run("record", scene, tmp_path / "o.exr", "-w", 8)
    assert code == 130 and "nothing was written" in err and not (tmp_path / "o.exr").exists()


def test_a_renderer_that_fails_is_said(run, scene, tmp_path, monkeypatch):
    from recording import RecordingDelegate

    def fail(self, timeout=0):
        raise RuntimeError("the device was lost")

    monkeypatch.setattr(RecordingDelegate, "_wait", fail)
    code, _, err = run("record", scene, tmp_path / "o.exr", "-w", 8)
    assert code == 1 and "the device was lost" in err and not (tmp_path / "o.exr").exists()


def test_textures_that_fail_are_handed_on_with_the_reason(run, scene, tmp_path, monkeypatch, recorded):
    from types import SimpleNamespace

    from recording import RecordingDelegate

    damaged = tmp_path / "damaged.png"
    damaged.write_bytes(b"\x89PNG\r\n\x1a\n nothing")
    paths = [str(tmp_path / "gone.png"), str(damaged), str(tmp_path / "t.<UDIM>.png")]
    requests = [
        SimpleNamespace(key=k, resolved_path=p, authored_path=p, color_space="", is_color=True, location="/m/t")
        for k, p in enumerate(paths)
    ]
    monkeypatch.setattr(RecordingDelegate, "_pending_textures", lambda self: requests)
    assert run("record", scene, tmp_path / "o.exr", "-w", 8)[0] == 0
    reasons = recorded[0].textures
    assert "does not exist" in reasons[0] and "cannot be read" in reasons[1] and "no tile" in reasons[2]


def test_statistics(run, scene, tmp_path):
    stats = tmp_path / "s.json"
    assert run("record", scene, tmp_path / "o.exr", "-w", 8, "--stats", stats)[0] == 0
    read = json.loads(stats.read_text())
    assert {"kernels", "queues", "seconds", "hostPeakMemoryBytes", "settings", "diagnostics"} <= set(read)
    assert {"total", "render", "open", "translate", "textures", "commit"} == set(read["seconds"])
    assert read["seconds"]["total"] > 0 and (read["width"], read["height"], read["camera"]) == (8, 4, "/main_cam")
    # The recording delegate: 10 paths, 20 extension and 10 shadow rays in 2 seconds.
    assert read["mpathsPerSecond"] == pytest.approx(5e-6) and read["mraysPerSecond"] == pytest.approx(15e-6)
    assert read["settings"]["samples"] == 64 and read["stage"] == scene and read["diagnostics"] == []
    assert [p.name for p in tmp_path.glob("s.json*")] == ["s.json"]


def test_diagnostics_of_a_kind_are_not_endless(run, stage_file, tmp_path):
    text = "".join(f'def BasisCurves "x{i}" {{\n}}\n' for i in range(30))
    code, _, err = run("record", stage_file(text), tmp_path / "o.png", "-w", 8)
    assert code == 0 and err.count("prim-unsupported") == 9 and "22 more" in err


def test_help_loads_nothing_heavy():
    """Arguments are parsed before pxr, OpenImageIO or OpenColorIO are loaded."""
    script = (
        "import sys; from hdwavefront.cli.main import main; code = main(['record', '--help']);"
        "heavy = {'pxr', 'OpenImageIO', 'PyOpenColorIO', 'numpy'} & set(sys.modules);"
        "sys.exit(f'{code} {heavy}' if heavy or code else 0)"
    )
    result = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert result.returncode == 0, result.stderr
    assert "--renderSettingsPrimPath" in result.stdout and "--aov" in result.stdout


def test_the_module_is_the_command():
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)}
    command = [sys.executable, "-m", "hdwavefront", "record", "no.usda"]
    result = subprocess.run(command, capture_output=True, text=True, env=environment)
    assert result.returncode == 2 and "outputImagePath" in result.stderr


def test_usdrecords_arguments_are_taken(run, scene, tmp_path):
    flags = (
        "--purposes proxy,render --disableGpu --renderer Wavefront -color sRGB -c veryhigh --enableDomeLightVisibility "
        "--resolver inherit --memstats --disableDrawMode --traceFormat trace"
    )
    trace = tmp_path / "trace.txt"
    output = tmp_path / "o.png"
    assert run("record", scene, output, "-cam", "main_cam", "-w", 8, "--traceToFile", trace, *flags.split())[0] == 0
    assert "Tree view" in trace.read_text()


def test_version(run):
    assert run("--version")[:2] == (0, "hdWavefront 0.0.test\n")


def test_five_lines_of_python(scene, tmp_path, recorded):
    import hdwavefront

    render = hdwavefront.open(scene, width=16)
    render.start(samples=4)
    assert render.wait()
    render.save(str(tmp_path / "o.exr"))
    assert Path(tmp_path / "o.exr").exists() and recorded[0].settings["samples"] == 4
    assert render.map("color").shape == (8, 16, 4)
    with pytest.raises(hdwavefront.UsageError, match="no AOV"):
        hdwavefront.open(scene, aovs=["none"])


@pytest.mark.parametrize("mode", ["disabled", "sRGB"])
def test_colour_of_exr_files_is_premultiplied_in_every_mode(run, scene, tmp_path, monkeypatch, mode):
    """The recording delegate's pixels are colour and alpha 0.25 each: premultiplied white, which no mode changes."""
    output = tmp_path / "o.exr"
    assert run("record", scene, output, "-w", 8, "--colorCorrectionMode", mode)[0] == 0
    pixels = oiio.ImageInput.open(str(output)).read_image(oiio.FLOAT)
    assert pixels[..., 3].max() == pytest.approx(0.25) and pixels[..., 0].max() == pytest.approx(0.25)
