# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The walk over a stage: inherited state, time, and what one broken prim leaves alone."""

from __future__ import annotations

from usda import primvars_of, translation_of


def test_time_samples_are_interpolated_at_the_frame(translated):
    text = """def Sphere "s" {
    double radius.timeSamples = { 1: 1, 3: 3 }
    double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 3: (4, 0, 0) }
    uniform token[] xformOpOrder = ["xformOp:translate"]
    color3f[] primvars:displayColor.timeSamples = { 1: [(0, 0, 0)], 3: [(1, 1, 1)] }
}"""
    delegate, _ = translated(text, time=2)
    sphere = delegate.told["/s"]
    assert sphere["shape"]["radius"] == 2 and translation_of(sphere) == (2, 0, 0)
    assert primvars_of(sphere)["displayColor"][2][0, 0] == 0.5


def test_transforms_compose_and_reset(translated):
    delegate, _ = translated(
        """def Xform "a" {
    double3 xformOp:translate = (1, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Cube "below" {
        double3 xformOp:translate = (0, 2, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Cube "reset" {
        double3 xformOp:translate = (0, 5, 0)
        uniform token[] xformOpOrder = ["!resetXformStack!", "xformOp:translate"]
    }
}"""
    )
    assert translation_of(delegate.told["/a/below"]) == (1, 2, 0)
    assert translation_of(delegate.told["/a/reset"]) == (0, 5, 0)


def test_visibility_activation_and_purpose(translated):
    text = """
def Xform "hidden" { token visibility = "invisible"
    def Cube "c" {}
    def SphereLight "l" {}
}
def Cube "inactive" (active = false) {}
def Xform "proxies" { uniform token purpose = "proxy"
    def Cube "c" {}
    def Cube "own" { uniform token purpose = "render" }
}
def Cube "guide" { uniform token purpose = "guide" }
def Cube "plain" {}
"""
    delegate, _ = translated(text)
    assert set(delegate.told) == {"/proxies/c", "/plain"}
    assert delegate.told["/proxies/c"]["render_tag"] == "proxy" and delegate.told["/plain"]["render_tag"] == "geometry"
    delegate, _ = translated(text, purposes=frozenset({"default", "render", "guide"}))
    assert set(delegate.told) == {"/proxies/own", "/guide", "/plain"}


def test_constant_primvars_are_inherited(translated):
    delegate, _ = translated(
        """def Xform "a" {
    color3f[] primvars:displayColor = [(1, 0, 0)]
    float[] primvars:local = [1, 2] (interpolation = "vertex")
    def Xform "b" {
        def Cube "c" {}
        def Cube "d" { color3f[] primvars:displayColor = [(0, 1, 0)] }
    }
}"""
    )
    assert list(primvars_of(delegate.told["/a/b/c"])["displayColor"][2][0]) == [1, 0, 0]
    assert list(primvars_of(delegate.told["/a/b/d"])["displayColor"][2][0]) == [0, 1, 0]
    assert "local" not in primvars_of(delegate.told["/a/b/c"])  # only constants are inherited


def test_what_is_not_defined_is_not_drawn(translated):
    delegate, _ = translated('over "o" { def Cube "c" {} } def Cube "c" {}\nclass "k" { def Cube "c" {} }')
    assert list(delegate.told) == ["/c"]


def test_a_transform_above_acts_on_all_of_one_below(translated):
    """Row vectors: the local matrix first."""
    delegate, _ = translated(
        """def Xform "a" {
    float3 xformOp:scale = (2, 3, 4)
    uniform token[] xformOpOrder = ["xformOp:scale"]
    def Cube "c" {
        double3 xformOp:translate = (1, 1, 1)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
}"""
    )
    assert translation_of(delegate.told["/a/c"]) == (2, 3, 4)


def test_visibility_is_that_of_the_frame(translated):
    text = 'def Cube "c" { token visibility.timeSamples = { 1: "inherited", 2: "invisible" } }'
    assert translated(text, time=1)[0].told and not translated(text, time=2)[0].told


def test_what_is_told_is_visible(translated):
    delegate, _ = translated('def Cube "c" {}\ndef SphereLight "l" {}')
    assert delegate.told["/c"]["visible"] is True and delegate.told["/l"]["visible"] is True
    assert delegate.translation.light_count == 1


def test_the_garbage_collector_is_left_as_it_was(translated):
    import gc

    assert gc.isenabled()
    translated('def Cube "c" {}')
    assert gc.isenabled()
    gc.disable()
    try:
        translated('def Cube "c" {}')
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_a_prim_that_fails_does_not_stop_the_rest(translated, monkeypatch):
    from hdwavefront.stage_adapters import traversal

    def broken(translation, rprim):
        raise ZeroDivisionError("oh")

    monkeypatch.setitem(traversal.RPRIM_ADAPTERS, "Sphere", broken)
    delegate, diagnostics = translated('def Sphere "s" {}\ndef Cube "c" {}')
    assert set(delegate.told) == {"/c"}
    assert [(d.code, d.location, d.severity) for d in diagnostics] == [("prim-failed", "/s", "error")]


def test_deep_hierarchies_do_not_end_the_stack(translated):
    depth = 1500
    from pxr import Sdf

    layer = Sdf.Layer.CreateAnonymous(".usda")
    path = Sdf.Path.absoluteRootPath
    for _ in range(depth):
        path = path.AppendChild("x")
        spec = Sdf.CreatePrimInLayer(layer, path)
        spec.specifier, spec.typeName = Sdf.SpecifierDef, "Xform"
    spec = Sdf.CreatePrimInLayer(layer, path.AppendChild("c"))
    spec.specifier, spec.typeName = Sdf.SpecifierDef, "Cube"
    delegate, _ = translated(layer.ExportToString().removeprefix("#usda 1.0"))
    assert len(delegate.told) == 1


def test_every_third_party_stage_is_translated(assets):
    """No prim fails, and every call fits the native module's signature."""
    from hdwavefront.errors import Diagnostics
    from hdwavefront.stage import open_stage
    from hdwavefront.stage_adapters.context import Options
    from hdwavefront.stage_adapters.traversal import translate
    from pxr import Usd
    from recording import RecordingDelegate

    count = 0
    for path in sorted(p for p in assets.rglob("*") if p.suffix in (".usd", ".usda", ".usdc", ".usdz")):
        diagnostics = Diagnostics()
        stage = open_stage(str(path), diagnostics)
        translate(stage, Options(time=Usd.TimeCode(stage.GetStartTimeCode())), RecordingDelegate(), diagnostics)
        assert "prim-failed" not in diagnostics.codes(), (path, [str(d) for d in diagnostics])
        count += 1
    assert count > 200
