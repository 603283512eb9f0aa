# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`hdwavefront doctor` on machines where something is missing."""

from __future__ import annotations

import sys

import pytest

CARD = {
    "name": "A card",
    "type": "discrete GPU",
    "driver": "its driver",
    "apiVersion": "1.3.0",
    "heapBytes": 8 << 30,
    "usable": True,
    "whyNot": "",
    "details": [("limit", "7")],
}
OLD = {**CARD, "name": "Old card", "usable": False, "whyNot": "no shaderInt64"}


@pytest.fixture
def doctor(recorded, run, monkeypatch, tmp_path):
    """Runs it with these devices; gives (exit code, output)."""
    import hdwavefront._core as core
    import hdwavefront.api as api

    monkeypatch.delenv("HDWAVEFRONT_DEVICE", raising=False)
    monkeypatch.delenv("OCIO", raising=False)
    (tmp_path / "materialx/stdlib").mkdir(parents=True)
    monkeypatch.setattr(api, "_DATA_FOLDER", str(tmp_path))

    def call(*devices):
        monkeypatch.setattr(core, "list_devices", lambda: list(devices))
        code, out, _ = run("doctor")
        return code, out

    return call


def test_all_is_well(doctor):
    code, out = doctor(CARD)
    assert code == 0 and "PROBLEM" not in out and "Everything that renders need is there." in out
    for words in ("A card (discrete GPU) - usable", "its driver", "1.3.0", "8.0 GiB", "limit:", "0.0.test", "Python:"):
        assert words in out
    for words in ("OpenUSD:", "OpenColorIO:", "display, view:", "OpenImageIO:", "openexr,"):
        assert words in out


def test_no_device(doctor):
    code, out = doctor()
    assert code == 1 and "there is no Vulkan device; install a driver" in out


def test_no_device_that_will_do(doctor):
    code, out = doctor(OLD)
    assert code == 1 and "no Vulkan device is usable: Old card: no shaderInt64" in out
    assert doctor(OLD, CARD)[0] == 0


@pytest.mark.parametrize(
    ("wish", "problem"),
    [
        ("0", None),
        ("a CARD", None),
        ("1", "chooses no device that is usable"),
        ("old", "chooses no device that is usable"),
        ("2", "no Vulkan device has that index or name"),
        ("another", "no Vulkan device has that index or name"),
    ],
)
def test_the_device_of_the_environment(doctor, monkeypatch, wish, problem):
    monkeypatch.setenv("HDWAVEFRONT_DEVICE", wish)
    code, out = doctor({**CARD, "name": "A card 2"}, OLD)  # digits are an index, not a part of a name
    assert (code, "What is wrong:" in out) == ((1, True) if problem else (0, False))
    assert wish in out and (problem is None or (f"$HDWAVEFRONT_DEVICE is '{wish}'" in out and problem in out))


def test_missing_libraries_of_materialx(doctor, tmp_path):
    (tmp_path / "materialx/stdlib").rmdir()
    code, out = doctor(CARD)
    assert code == 1 and "the MaterialX libraries are missing in" in out


def test_a_section_that_fails_does_not_hide_the_rest(doctor, monkeypatch):
    monkeypatch.setenv("OCIO", "missing.ocio")
    monkeypatch.setitem(sys.modules, "OpenImageIO", None)
    code, out = doctor(CARD)
    assert code == 1 and "Colour: The OpenColorIO configuration missing.ocio" in out and "  - Images: " in out


def test_no_usd(doctor, monkeypatch):
    monkeypatch.setitem(sys.modules, "pxr", None)
    code, out = doctor(CARD)
    assert code == 1 and "pip install 'hdwavefront[usd]'" in out


def make_plugin(folder, openusd="25.02"):
    folder.mkdir(parents=True)
    (folder / "plugInfo.json").write_text('{"Plugins": [{"Info": {"Types": {"HdWavefrontRendererPlugin": {}}}}]}')
    (folder / "build.json").write_text(f'{{"openusd": "{openusd}"}}')
    return str(folder)


def test_the_hydra_plugin_is_found_where_the_environment_says(doctor, monkeypatch, tmp_path):
    other = tmp_path / "other"
    other.mkdir()
    (other / "plugInfo.json").write_text('{"Plugins": []}')
    monkeypatch.delenv("HDWAVEFRONT_HYDRA", raising=False)
    monkeypatch.setenv("PXR_PLUGINPATH_NAME", f"{other}:{make_plugin(tmp_path / 'listed')}")
    code, out = doctor(CARD)
    assert code == 0 and str(tmp_path / "listed") in out and "25.02" in out
    assert "this pxr has no imaging" in out  # usd-core
    monkeypatch.setenv("HDWAVEFRONT_HYDRA", make_plugin(tmp_path / "named", "24.11"))
    code, out = doctor(CARD)
    assert code == 0 and str(tmp_path / "named") in out and "24.11" in out


@pytest.mark.parametrize(("reason", "expected"), [(None, 0), ("undefined symbol: x", 1)])
def test_whether_the_hydra_plugin_loads(doctor, monkeypatch, tmp_path, reason, expected):
    import hdwavefront.cli.hydra_plugin as hydra_plugin

    monkeypatch.setenv("HDWAVEFRONT_HYDRA", make_plugin(tmp_path / "plugin"))
    monkeypatch.setattr(hydra_plugin, "why_not_loaded", lambda plugin: reason)
    code, out = doctor(CARD)
    assert code == expected
    assert ("loads:                 yes" in out) == (reason is None)
    assert ("does not load: undefined symbol: x" in out) == (reason is not None)


def test_no_hydra_plugin_is_no_problem(doctor, monkeypatch, tmp_path):
    import hdwavefront.cli.hydra_plugin as hydra_plugin

    monkeypatch.setattr(hydra_plugin, "_candidates", lambda: iter(("", str(tmp_path / "nowhere"))))
    code, out = doctor(CARD)
    assert code == 0 and "no plugin is found (configure with -Dpxr_DIR" in out
