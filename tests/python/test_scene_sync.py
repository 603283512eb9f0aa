# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What is told no more is destroyed, by its kind, and only then."""

from __future__ import annotations

import pytest
from hdwavefront.scene_sync import TrackingSink
from recording import RecordingDelegate

TELL = {
    "mesh": lambda sink: sink.sync_mesh("/p"),
    "implicit": lambda sink: sink.sync_implicit("/p"),
    "instancer": lambda sink: sink.sync_instancer("/p"),
    "light": lambda sink: sink.sync_light("/p"),
    "material": lambda sink: sink.sync_material("/p", {}),
    "camera": lambda sink: sink.sync_camera("/p"),
}
DESTROYED = {
    "mesh": "destroy_rprim",
    "implicit": "destroy_rprim",
    "instancer": "destroy_instancer",
    "light": "destroy_sprim",
    "material": "destroy_sprim",
    "camera": "destroy_sprim",
}


def frames(*told):
    """The delegate's destroy calls after frames in which these kinds are told."""
    delegate = RecordingDelegate()
    sink = TrackingSink(delegate)
    for kinds in told:
        sink.begin()
        for tell in kinds:
            tell(sink)
        sink.finish()
    return [(name, args[0]) for name, args, _ in delegate.calls if name.startswith("destroy")]


@pytest.mark.parametrize("kind", TELL)
def test_what_is_gone_is_destroyed_once(kind):
    assert frames([TELL[kind]], [TELL[kind]]) == []
    assert frames([TELL[kind]], [], []) == [(DESTROYED[kind], "/p")]
    assert frames([TELL[kind]], [], [TELL[kind]], []) == [(DESTROYED[kind], "/p")] * 2


def test_a_path_that_changes_its_kind():
    assert frames([TELL["mesh"]], [TELL["light"]]) == [("destroy_rprim", "/p")]
    assert frames([TELL["mesh"]], [TELL["implicit"]]) == []  # the delegate turns one Rprim into the other


def test_instancers_go_last():
    first = [lambda s: s.sync_instancer("/a"), lambda s: s.sync_mesh("/b"), lambda s: s.sync_light("/c")]
    assert [name for name, _ in frames(first, [])] == ["destroy_rprim", "destroy_sprim", "destroy_instancer"]


def test_updates_pass_unchanged():
    delegate = RecordingDelegate()
    sink = TrackingSink(delegate)
    sink.begin()
    sink.sync_mesh("/m", visible=True)
    sink.sync_camera("/c", params={"fStop": 1})
    assert delegate.told == {"/m": {"visible": True}, "/c": {"params": {"fStop": 1}}}
