# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Opening stages; diagnostics and errors by themselves."""

from __future__ import annotations

import os
import sys

import pytest
from hdwavefront.errors import Diagnostic, Diagnostics, HdWavefrontError, UsageError
from hdwavefront.stage import import_pxr, open_stage, usd_warnings
from usda import said


def test_no_usd_is_one_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "pxr", None)
    with pytest.raises(HdWavefrontError, match=r"pip install 'hdwavefront\[usd\]'"):
        import_pxr()


@pytest.mark.parametrize(
    ("path", "error", "words"),
    [
        ("", UsageError, "The stage has no name"),
        ("none.usda", HdWavefrontError, "does not exist"),
        ("none://none.usda", HdWavefrontError, "is no USD file that can be read|is broken"),  # a resolver's business
    ],
)
def test_what_cannot_be_opened(path, error, words):
    with pytest.raises(error, match=words):
        open_stage(path, Diagnostics())


def test_a_file_without_permission_is_said(stage_file, monkeypatch):
    path = stage_file("")
    monkeypatch.setattr(os, "access", lambda *_: False)  # root may read everything
    with pytest.raises(HdWavefrontError, match="cannot be read"):
        open_stage(path, Diagnostics())


def test_layers_inside_packages_are_opened(stage_file, tmp_path):
    from pxr import UsdUtils

    inner = stage_file('def Cube "c" {\n}\n', "inner.usda")
    package = str(tmp_path / "p.usdz")
    assert UsdUtils.CreateNewUsdzPackage(inner, package)
    for path in (package, f"{package}[inner.usda]"):
        assert open_stage(path, Diagnostics()).GetPrimAtPath("/c")


@pytest.mark.parametrize("resolver", ["root", "inherit"])
def test_the_resolvers_context(stage_file, tmp_path, monkeypatch, resolver):
    """`root` searches beside the root layer, `inherit` where the environment says."""
    from pxr import Ar

    made = []

    class Spy:
        def __getattr__(self, name):
            made.append(name)
            return getattr(Ar.GetResolver(), name)

    spy = Spy()
    real = Ar.GetResolver
    path = stage_file("")
    monkeypatch.setattr(Ar, "GetResolver", lambda: real() if made else spy)
    stage = open_stage(path, Diagnostics(), resolver=resolver)
    wanted = {"root": "CreateDefaultContextForAsset", "inherit": "CreateDefaultContext"}[resolver]
    assert made == [wanted] and stage


def test_a_mask_takes_in_what_it_names(stage_file):
    text = 'def Xform "a" {\n    def Cube "c" {\n    }\n    def Cube "d" {\n    }\n}\ndef Cube "b" {\n}\n'
    stage = open_stage(stage_file(text), Diagnostics(), mask=("/a/c",))
    assert [str(p.GetPath()) for p in stage.Traverse()] == ["/a", "/a/c"]


@pytest.mark.parametrize("item", ["not a path", "/a.b", "/a..b"])
def test_a_mask_that_is_no_path(stage_file, item):
    with pytest.raises(UsageError, match="is no prim path"):
        open_stage(stage_file(""), Diagnostics(), mask=(item,))


def test_warnings_of_usd_lose_their_source_lines():
    from pxr import Tf

    diagnostics = Diagnostics()
    with usd_warnings("s.usda", diagnostics):
        Tf.Warn("something  is odd (instantiating stage on stage @s.usda@)")
        Tf.Warn("Could not open asset @m.mtlx@")
    assert [(d.code, d.location, d.message) for d in diagnostics] == [("usd-warning", "s.usda", "something is odd")]


def test_a_distinct_diagnostic_comes_once():
    fresh = []
    diagnostics = Diagnostics(fresh.append)
    for _ in range(2):
        diagnostics.warning("code", "/p", "words")
    diagnostics.info("code", "/p", "words")
    diagnostics.error("other", "/q", "words")
    assert fresh == list(diagnostics) and len(diagnostics) == 3 and diagnostics.codes() == {"code", "other"}
    assert said(diagnostics) == [("code", "/p"), ("code", "/p"), ("other", "/q")]
    assert str(fresh[0]) == "warning: /p: words [code]"
    assert fresh[0] == Diagnostic("warning", "code", "/p", "words")


def test_exit_codes():
    assert (HdWavefrontError.exit_code, UsageError.exit_code) == (1, 2)
