# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Documents and networks that nobody meant: no crash, no hang, and one diagnostic that names the file or the prim."""

from __future__ import annotations

import random
import re
import time

import pytest

pytest.importorskip("MaterialX", reason="the materialx package comes with the [usd] extra")

STAGE = """def "l" (
    references = @./m.mtlx@</MaterialX/Materials>
) {
}
def Cube "a" {
    rel material:binding = </l/red>
}
"""


def document(body):
    return (
        '<?xml version="1.0"?>\n<materialx version="1.39" xmlns:xi="http://www.w3.org/2001/XInclude">'
        f"{body}</materialx>\n"
    )


def surface(inputs="", name="red", body=""):
    return document(
        f'{body}<standard_surface name="s" type="surfaceshader">{inputs}</standard_surface>'
        f'<surfacematerial name="{name}" type="material">'
        '<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial>'
    )


def value(name, kind, text):
    return surface(f'<input name="{name}" type="{kind}" value="{text}"/>')


def joined(body, attributes):
    return surface(f'<input name="base_color" type="color3" {attributes}/>', body=body)


def doubling(levels):
    """Definitions of which each holds the last one twice."""
    text = ""
    for i in range(levels):
        inner = f"n{i - 1}" if i else "absval"
        text += (
            f'<nodedef name="ND_n{i}" node="n{i}"><input name="in" type="color3" value="0, 0, 0"/>'
            '<output name="out" type="color3"/></nodedef>'
            f'<nodegraph name="NG_n{i}" nodedef="ND_n{i}">'
            f'<{inner} name="a" type="color3"><input name="in" type="color3" interfacename="in"/></{inner}>'
            f'<{inner} name="b" type="color3"><input name="in" type="color3" nodename="a"/></{inner}>'
            '<output name="out" type="color3" nodename="b"/></nodegraph>'
        )
    return text + f'<n{levels - 1} name="n" type="color3"/>'


RECURSIVE = """
<nodedef name="ND_p" node="p"><input name="in" type="color3"/><output name="out" type="color3"/></nodedef>
<nodegraph name="NG_p" nodedef="ND_p"><q name="a" type="color3"><input name="in" type="color3" interfacename="in"/></q>
  <output name="out" type="color3" nodename="a"/></nodegraph>
<nodedef name="ND_q" node="q"><input name="in" type="color3"/><output name="out" type="color3"/></nodedef>
<nodegraph name="NG_q" nodedef="ND_q"><p name="a" type="color3"><input name="in" type="color3" interfacename="in"/></p>
  <output name="out" type="color3" nodename="a"/></nodegraph>
<q name="n" type="color3"/>"""
BAD_XML = "mtlx-reference-unsupported"
BAD_JOIN = "mtlx-bad-connection"
BAD_VALUE = "mtlx-bad-value"

CASES = {
    "nothing": (b"", BAD_XML),
    "no_xml": (b"\x00\xff\xfe\x80 materialx" * 40, BAD_XML),
    "truncated": (surface()[:-40].encode(), BAD_XML),
    "another_root": (b"<?xml version='1.0'?><html/>", BAD_XML),
    "deep_xml": (b"<?xml version='1.0'?><materialx>" + b"<a>" * 200000 + b"</a>" * 200000, BAD_XML),
    "includes_itself": (document('<xi:include href="m.mtlx"/>'), BAD_XML),
    "includes_nothing": (document('<xi:include href="nobody.mtlx"/>'), BAD_XML),
    "entities": (b'<!DOCTYPE a [<!ENTITY b "bbbb"><!ENTITY c "&b;&b;">]><materialx>&c;</materialx>', ""),
    "not_a_number": (value("metalness", "float", "nan"), BAD_VALUE),
    "infinite": (value("base_color", "color3", "1, inf, 0"), BAD_VALUE),
    "huge": (value("metalness", "float", "1e400"), BAD_VALUE),
    "words": (value("metalness", "float", "very"), BAD_VALUE),
    "too_few": (value("base_color", "color3", "1, 0"), BAD_VALUE),
    "too_many": (value("base_color", "color3", "1, 0, 0, 0"), BAD_VALUE),
    "no_boolean": (value("thin_walled", "boolean", "maybe"), BAD_VALUE),
    "huge_integer": (surface(body='<switch name="w" type="float"><input name="which" type="integer" '
                             'value="99999999999999999999"/></switch>',
                             inputs='<input name="metalness" type="float" nodename="w"/>'), BAD_VALUE),
    "file_of_bytes": (surface(body='<image name="i" type="color3"><input name="file" type="filename" '
                              'value="a&#10;b&#7;.png"/></image>',
                              inputs='<input name="base_color" type="color3" nodename="i"/>'), BAD_VALUE),
    "no_such_node": (joined("", 'nodename="nobody"'), BAD_JOIN),
    "no_such_graph": (joined("", 'nodegraph="nobody" output="out"'), BAD_JOIN),
    "no_such_output": (joined('<nodegraph name="g"/>', 'nodegraph="g" output="out"'), BAD_JOIN),
    "no_such_interface": (joined("", 'interfacename="nobody"'), BAD_JOIN),
    "no_surface": (document('<surfacematerial name="red" type="material"/>'), "material-no-surface"),
    "no_material": (document(""), "material-missing"),
    "recursive_definitions": (joined(RECURSIVE, 'nodename="n"'), "mtlx-recursive-definition"),
    "doubling_definitions": (joined(doubling(40), 'nodename="n"'), "mtlx-too-large"),
    "definition_without_graph": (
        joined('<nodedef name="ND_o" node="o"><output name="out" type="color3"/></nodedef><o name="n" type="color3"/>',
               'nodename="n"'), ""),
    "unknown_node": (joined('<nonsense name="n" type="color3"/>', 'nodename="n"'), ""),
    "wrong_type": (joined('<uniform_edf name="n" type="EDF"/>', 'nodename="n"'), ""),
    "cycle": (joined('<absval name="n" type="color3"><input name="in" type="color3" nodename="m"/></absval>'
                     '<absval name="m" type="color3"><input name="in" type="color3" nodename="n"/></absval>',
                     'nodename="n"'), ""),
    "cycle_through_a_graph": (
        joined('<nodegraph name="g"><input name="x" type="color3" nodename="m"/>'
               '<absval name="n" type="color3"><input name="in" type="color3" interfacename="x"/></absval>'
               '<output name="out" type="color3" nodename="n"/></nodegraph>'
               '<absval name="m" type="color3"><input name="in" type="color3" nodegraph="g" output="out"/></absval>',
               'nodename="m"'), ""),
    "a_long_chain": (joined('<absval name="n0" type="color3"/>' + "".join(
        f'<absval name="n{i}" type="color3"><input name="in" type="color3" nodename="n{i - 1}"/></absval>'
        for i in range(1, 10000)), 'nodename="n9999"'), ""),
}  # fmt: skip


@pytest.mark.parametrize("case", CASES)
def test_each_ends_with_a_diagnostic_that_names_its_place(looks, case):
    text, code = CASES[case]
    begin = time.process_time()
    _, diagnostics = looks(text, STAGE)
    assert time.process_time() - begin < 20
    # What has no code here is a network all the same: the generator says what is wrong with it (tests/materialgen).
    assert (code in diagnostics.codes()) if code else not diagnostics.codes() - {"material-missing"}
    for d in diagnostics:
        assert "m.mtlx" in d.location + d.message or d.location.startswith(("/a", "/l")), d


def test_ten_thousand_nodes_arrive(looks):
    delegate, _ = looks(CASES["a_long_chain"][0], STAGE)
    assert len(delegate.told["/l/red"]["mtlx"]["nodes"]) == 10001


def test_mutated_documents_neither_crash_nor_raise(looks, tmp_path):
    """Bytes that are changed, doubled and left out, and attributes that are swapped, with a fixed seed."""
    from hdwavefront.mtlx import convert_file
    from test_mtlx import DOCUMENT
    from test_mtlx_stages import DEFINED, LOOKS

    rng = random.Random(7)
    seeds = [DOCUMENT, LOOKS, surface(body=DEFINED), *(c[0] for c in CASES.values() if isinstance(c[0], str))]
    seeds = [s for s in seeds if len(s) < 20000]
    read = 0
    for i in range(400):
        text = rng.choice(seeds)
        for _ in range(rng.randint(1, 4)):
            at = rng.randrange(len(text))
            kind = rng.choice((0, 1, 2, 3, 3, 3, 3, 3))
            if kind == 0:
                text = (
                    text[:at] + chr(rng.choice([0, 34, 38, 60, 62, 0x1F600, rng.randrange(32, 127)])) + text[at + 1 :]
                )
            elif kind == 1:
                text = text[:at] + text[at : at + rng.randint(1, 80)] + text[at:]
            elif kind == 2:
                text = text[:at] + text[at + rng.randint(1, 40) :]
            else:
                words = re.findall(r'"[^"]*"', text)
                text = text.replace(rng.choice(words), rng.choice(words), 1) if words else text
        path = tmp_path / f"{i}.mtlx"
        path.write_bytes(text.encode("utf-8", "replace"))
        try:
            convert_file(str(path))
            read += 1
        except Exception as error:  # what cannot be read is reported by its reference
            assert type(error).__module__ == "MaterialX.PyMaterialXFormat" or isinstance(
                error, (LookupError, ValueError, FileNotFoundError)
            ), (text, error)
    assert read > 100


CHAIN = """
def Material "m" {{
    token outputs:mtlx:surface.connect = </m/s.outputs:out>
    def Shader "s" {{
        uniform token info:id = "ND_standard_surface_surfaceshader"
        color3f inputs:base_color.connect = </m/{first}>
        token outputs:out
    }}
{body}
}}
def Cube "c" {{
    rel material:binding = </m>
}}
"""


def graphs(count, last):
    """NodeGraphs of which each hands on the output of the next."""
    return "\n".join(
        f"""    def NodeGraph "g{i}" {{
        color3f outputs:out.connect = </m/{f"g{i + 1}.outputs:out" if i + 1 < count else last}>
    }}"""
        for i in range(count)
    )


@pytest.mark.parametrize(
    ("first", "body"),
    [
        ("g0.outputs:out", graphs(2000, "s.inputs:base_color")),
        ("g0.outputs:out", graphs(3, "g0.outputs:out")),
        ("g0.outputs:out", graphs(1, "g0.outputs:nobody")),
        ("s.inputs:base_color", ""),
        ("s.outputs:out", ""),
    ],
)
def test_networks_of_usd_that_go_in_circles_end(stage_file, first, body):
    from hdwavefront.errors import Diagnostics
    from hdwavefront.stage import open_stage
    from hdwavefront.stage_adapters.context import Options
    from hdwavefront.stage_adapters.traversal import translate
    from pxr import Usd
    from recording import RecordingDelegate

    delegate, diagnostics = RecordingDelegate(), Diagnostics()
    stage = open_stage(stage_file(CHAIN.format(first=first, body=body)), diagnostics)
    translate(stage, Options(time=Usd.TimeCode(0)), delegate, diagnostics)
    assert "/m" in delegate.told and all(d.location.startswith("/m") for d in diagnostics)
