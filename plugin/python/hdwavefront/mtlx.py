# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""References to .mtlx files where pxr has no UsdMtlx: said clearly, material by material file.

A pxr without UsdMtlx opens such stages with an empty prim in the reference's place.
"""

from __future__ import annotations

import re
from typing import Any

from .errors import Diagnostics

_MTLX_PATH = re.compile(r"Could not open asset @([^@]+?\.mtlx)(?::SDF_FORMAT_ARGS[^@]*)?@")


def missing_mtlx(stage: Any) -> list[tuple[str, str]]:
    """(prim path, file) of each reference or payload to a .mtlx file that could not be composed."""
    found: dict[tuple[str, str], None] = {}
    for error in stage.GetCompositionErrors():
        match = _MTLX_PATH.search(str(error))
        if match:
            found[(str(error.rootSite.path), match.group(1))] = None
    return list(found)


def author_missing_mtlx(stage: Any, diagnostics: Diagnostics) -> None:
    for site, asset in missing_mtlx(stage):
        diagnostics.warning(
            "mtlx-reference-unsupported",
            site,
            f"the referenced {asset} cannot be read by this pxr, which has no UsdMtlx; its materials are missing",
        )
