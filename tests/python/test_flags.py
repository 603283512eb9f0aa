# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Every flag of `record` arrives where it acts."""

from __future__ import annotations

import json
import sys

import pytest
from hdwavefront.errors import HdWavefrontError


@pytest.fixture
def asked(run, scene, tmp_path, monkeypatch):
    """What `record` with these flags asks of the renderer."""
    import hdwavefront.api as api

    def call(*flags, output="o.exr"):
        seen = {}

        def render(path, **options):
            seen.update(options, path=path)
            raise HdWavefrontError("enough is known")

        monkeypatch.setattr(api, "Render", render)
        code, _, err = run("record", scene, tmp_path / output, *flags)
        assert code == 1 and "enough is known" in err, err
        return seen

    return call


DEFAULTS = {
    "camera": "",
    "width": None,
    "height": None,
    "frame": None,
    "complexity": "low",
    "purposes": None,
    "render_settings": "",
    "render_pass": "",
    "mask": [],
    "session_layer": "",
    "resolver": "root",
    "aovs": [],
    "ocio": "",
    "display": "",
    "view": "",
    "color_mode": None,
    "rendering_space": "",
    "camera_light": None,
    "dome_visible": False,
    "device": "",
    "window_policy": "",
    "settings": {},
}
FLAGS = [
    ("--camera /a", {"camera": "/a"}),
    ("-cam a", {"camera": "a"}),
    ("--imageWidth 7", {"width": 7}),
    ("-w 7", {"width": 7}),
    ("--imageHeight 7", {"height": 7}),
    ("--defaultTime", {"frame": "default"}),
    ("-d", {"frame": "default"}),
    ("--complexity high", {"complexity": "high"}),
    ("-c medium", {"complexity": "medium"}),
    ("--purposes render,guide", {"purposes": frozenset({"render", "guide"})}),
    ("--mask /a,/b", {"mask": ["/a", "/b"]}),
    ("--sessionLayer s.usda", {"session_layer": "s.usda"}),
    ("--colorCorrectionMode sRGB", {"color_mode": "sRGB"}),
    ("-color disabled", {"color_mode": "disabled"}),
    ("--renderSettingsPrimPath /s", {"render_settings": "/s"}),
    ("-rs /s", {"render_settings": "/s"}),
    ("--renderPassPrimPath /p", {"render_pass": "/p"}),
    ("-rp /p", {"render_pass": "/p"}),
    ("--disableCameraLight", {"camera_light": False}),
    ("--enableCameraLight", {"camera_light": True}),
    ("--enableDomeLightVisibility", {"dome_visible": True}),
    ("--resolver inherit", {"resolver": "inherit"}),
    ("--windowPolicy cropAperture", {"window_policy": "cropAperture"}),
    ("--aov depth --aov normal", {"aovs": ["depth", "normal"]}),
    ("--ocio c.ocio", {"ocio": "c.ocio"}),
    ("--display D", {"display": "D"}),
    ("--view V", {"view": "V"}),
    ("--renderingColorSpace acescg", {"rendering_space": "acescg"}),
    ("--device 3", {"device": "3"}),
    ("--disableGpu", {"device": "2"}),  # the usable processor of recording.py
    ("--samples 9", {"settings": {"samples": 9}}),
    ("--radianceClamp 0.5", {"settings": {"radianceClamp": 0.5}}),
    ("--enableShadows", {"settings": {"enableShadows": True}}),
    ("--enableShadows off", {"settings": {"enableShadows": False}}),
    ("--enableShadows no", {"settings": {"enableShadows": False}}),
    ("--enableShadows Yes", {"settings": {"enableShadows": True}}),
    ("--enableShadows 1", {"settings": {"enableShadows": True}}),
    ("--enableShadows 0", {"settings": {"enableShadows": False}}),
]


@pytest.mark.parametrize(("flags", "expected"), FLAGS)
def test_every_flag_arrives(asked, flags, expected):
    seen = asked(*flags.split())
    del seen["path"], seen["on_diagnostic"]
    assert seen == {**DEFAULTS, **expected}


def test_purposes_and_masks_may_be_apart_by_spaces(asked):
    seen = asked("--purposes", "render guide", "--mask", "/a /b")
    assert seen["purposes"] == {"render", "guide"} and seen["mask"] == ["/a", "/b"]


def test_the_first_frame_is_opened(asked):
    assert asked("--frames", "5,7", output="o.#.exr")["frame"] == 5


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ("--frames 1 --defaultTime", "not allowed with"),
        ("--enableShadows maybe", "neither true nor false"),
        ("--domeLightCameraVisibility on", "unrecognized arguments"),  # has usdrecord's flag
        ("--resolver mine", "invalid choice"),
        ("--windowPolicy stretch", "invalid choice"),
        ("--colorCorrectionMode best", "invalid choice"),
        ("--traceFormat xml", "invalid choice"),
        ("--imageWidth 7.5", "invalid int value"),
        ("--device 0 --disableGpu", "cannot both be given"),
    ],
)
def test_flags_that_make_no_sense(run, scene, tmp_path, flags, words):
    code, _, err = run("record", scene, tmp_path / "o.exr", *flags.split())
    assert code == 2 and words in err


def test_no_processor_to_render_on_is_said(run, scene, tmp_path, monkeypatch):
    import hdwavefront._core as core

    monkeypatch.setattr(core, "list_devices", lambda: [{"type": "CPU", "usable": False}])
    code, _, err = run("record", scene, tmp_path / "o.exr", "--disableGpu")
    assert code == 1 and "no Vulkan driver that runs on the processor" in err


@pytest.mark.parametrize(
    ("flags", "words"),
    [
        ("--memstats", "--memstats changes nothing"),
        ("--renderer GL", "--renderer GL changes nothing"),
        ("-r Wavefront", ""),
        ("--disableDrawMode", ""),
    ],
)
def test_flags_without_work_say_so(run, scene, tmp_path, flags, words):
    code, _, err = run("record", scene, tmp_path / "o.png", "-w", 8, *flags.split())
    assert code == 0 and (words in err if words else err == "")


def test_help_holds_the_settings_documentation(run):
    code, out, _ = run("record", "--help")
    assert code == 0 and "100 % of it (default: 0)" in out and "--enableShadows [BOOL]" in out


def test_help_comes_without_the_native_module(run, monkeypatch):
    monkeypatch.setitem(sys.modules, "hdwavefront._core", None)
    import hdwavefront

    monkeypatch.delattr(hdwavefront, "_core", raising=False)
    code, out, _ = run("record", "--help")
    assert code == 0 and "--imageWidth" in out and "--samples" not in out


def test_the_chrome_trace_is_the_default(run, scene, tmp_path):
    trace = tmp_path / "t.json"
    assert run("record", scene, tmp_path / "o.png", "-w", 8, "--traceToFile", trace)[0] == 0
    assert "traceEvents" in json.loads(trace.read_text())
    from pxr import Trace

    assert not Trace.Collector().enabled


def test_no_command_is_wrong_usage(run):
    code, out, _ = run()
    assert code == 2 and "record" in out and "doctor" in out


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (MemoryError(), 1, "memory does not suffice"),
        (BrokenPipeError(), 1, ""),
        (KeyboardInterrupt(), 130, "nothing was written"),
    ],
)
def test_what_ends_the_command_from_outside(run, scene, tmp_path, monkeypatch, error, code, words):
    from hdwavefront.cli import record

    def end(args):
        raise error

    monkeypatch.setattr(record, "record", end)
    got, _, err = run("record", scene, tmp_path / "o.png")
    assert got == code and words in err


def test_doctors_verdict_is_the_exit_code(run, monkeypatch):
    from hdwavefront.cli import doctor

    for verdict in (0, 1):
        monkeypatch.setattr(doctor, "doctor", lambda verdict=verdict: verdict)
        assert run("doctor")[0] == verdict
