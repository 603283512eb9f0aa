# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Every folder <Group.Case> with a scene.usda and a case.json is a test."""

from __future__ import annotations

import pytest
from harness import FOLDER, Case, check_case

CASES = sorted(p.parent for p in FOLDER.glob("*/case.json"))


def test_cases_are_complete():
    """A folder that is half a case would be passed over in silence."""
    assert CASES
    scenes = {p.parent for p in FOLDER.glob("*/scene.usda") if not p.parent.name.startswith("Mitsuba.")}
    assert scenes == set(CASES)
    assert all(p.name.count(".") == 1 for p in CASES)


@pytest.mark.parametrize("folder", CASES, ids=lambda p: p.name)
def test_case(folder):
    case = Case.load(folder)
    failures = []
    for check in case.data["checks"]:
        try:
            check_case(case, check)
        except AssertionError as error:
            failures.append(str(error).split("\n")[0])
    expected = sorted(case.data.get("diagnostics", []))
    got = sorted({d for image in case.images.values() for d in image.diagnostics})
    if got != expected:
        failures.append(f"diagnostics {got}, expected {expected}")
    assert not failures, "\n".join([case.data["why"], *failures])
