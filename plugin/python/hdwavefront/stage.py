# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Opens stages: population mask, session layer, materials in .mtlx files."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from .errors import Diagnostics, HdWavefrontError, UsageError


def import_pxr() -> Any:
    """The pxr package, or a sentence that says how to get one."""
    try:
        from pxr import Usd
    except ImportError as error:
        raise HdWavefrontError(
            f"OpenUSD's Python modules (pxr) are not installed ({error}). "
            "Install them with: pip install 'hdwavefront[usd]'"
        ) from None
    return Usd


@contextmanager
def usd_warnings(path: str, diagnostics: Diagnostics) -> Iterator[None]:
    """What USD's C++ warns of meanwhile becomes diagnostics; by itself it prints lines that name its source files."""
    from pxr import UsdUtils

    listener = UsdUtils.CoalescingDiagnosticDelegate()
    try:
        yield
    finally:
        # UsdMtlx's own complaints do not count: mtlx/ reads those files, and says what is wrong with them.
        taken = [w for w in listener.TakeUncoalescedDiagnostics() if "/usdMtlx/" not in w.sourceFileName]
        warnings = [str(w.commentary) for w in taken]
        del listener
        for warning in warnings:
            text = " ".join(warning.split())
            if ".mtlx" not in text:
                diagnostics.warning("usd-warning", path, text.split(" (instantiating stage")[0])


def open_stage(
    path: str,
    diagnostics: Diagnostics,
    *,
    mask: tuple[str, ...] = (),
    session_layer: str = "",
    resolver: str = "root",
) -> Any:
    """A Usd.Stage. HdWavefrontError says in one sentence what is wrong with the file. `resolver`: asset paths are
    resolved in a context made for the root layer ("root"), or in the environment's ("inherit"), as in usdrecord."""
    import_pxr()
    from pxr import Sdf, Tf, Usd

    from .mtlx import replace_references

    root = _find_layer(path, "stage")
    session = (
        _find_layer(session_layer, "session layer") if session_layer else Sdf.Layer.CreateAnonymous("session.usda")
    )
    population = Usd.StagePopulationMask()
    for item in mask:
        if not Sdf.Path.IsValidPathString(item) or not Sdf.Path(item).IsAbsoluteRootOrPrimPath():
            raise UsageError(f"--mask: '{item}' is no prim path; an absolute one such as /World/Set is needed.")
        population.Add(Sdf.Path(item).MakeAbsolutePath(Sdf.Path.absoluteRootPath))
    with usd_warnings(path, diagnostics):
        try:
            stage = _open(root, session, population if mask else None, path, resolver)
        except Tf.ErrorException as error:
            raise HdWavefrontError(f"The stage {path} cannot be opened: {_reason(error)}") from None
        if not stage:
            raise HdWavefrontError(f"The stage {path} cannot be opened.")
        replace_references(stage, diagnostics)
    for item in population.GetPaths():
        if not stage.GetPrimAtPath(item):
            diagnostics.warning("mask-empty", item, "--mask names this path, but there is no prim")
    return stage


def _open(root: Any, session: Any, population: Any, path: str, resolver: str) -> Any:
    from pxr import Ar, Usd

    resolvers = Ar.GetResolver()
    context = (
        resolvers.CreateDefaultContext() if resolver == "inherit" else resolvers.CreateDefaultContextForAsset(path)
    )
    if population is not None:
        return Usd.Stage.OpenMasked(root, session, context, population)
    return Usd.Stage.Open(root, session, context)


def _find_layer(path: str, what: str) -> Any:
    from pxr import Sdf, Tf

    if not path:
        raise UsageError(f"The {what} has no name.")
    looks_local = "://" not in path
    if looks_local and "[" not in path:
        if os.path.isdir(path):
            raise HdWavefrontError(f"The {what} {path} is a folder.")
        if not os.path.exists(path):
            raise HdWavefrontError(f"The {what} {path} does not exist.")
        if not os.access(path, os.R_OK):
            raise HdWavefrontError(f"The {what} {path} cannot be read.")
    try:
        layer = Sdf.Layer.FindOrOpen(path)
    except Tf.ErrorException as error:
        raise HdWavefrontError(f"The {what} {path} is broken: {_reason(error)}") from None
    if not layer:
        raise HdWavefrontError(f"The {what} {path} is no USD file that can be read.")
    return layer


def _reason(error: Exception) -> str:
    """The text of a Tf error without its C++ context."""
    texts = [getattr(e, "commentary", "") for e in error.args if not isinstance(e, str)]
    text = "; ".join(t for t in texts if t) or str(error)
    return " ".join(text.split())[:400]
