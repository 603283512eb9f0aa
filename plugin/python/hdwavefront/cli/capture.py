# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`hdwavefront capture`: a stage as a scene file. Needs no device."""

from __future__ import annotations

import argparse
import os

from ..errors import EXIT_OK, HdWavefrontError, UsageError
from .record import DiagnosticPrinter, open_stage


def capture(args: argparse.Namespace) -> int:
    for name in ("imageWidth", "imageHeight"):
        value = getattr(args, name)
        if value is not None and value <= 0:
            raise UsageError(f"--{name} is {value}; it must be at least 1.")
    if not 0 <= args.maxTexture <= 65536:
        raise UsageError(f"--maxTexture is {args.maxTexture}; it must be 0 to 65536.")
    path = args.sceneFilePath
    folder = os.path.dirname(os.path.abspath(path))
    if not os.path.isdir(folder) or not os.access(folder, os.W_OK):
        raise HdWavefrontError(f"The folder {folder} of the scene file does not exist or cannot be written to.")
    if os.path.isdir(path):
        raise HdWavefrontError(f"{path} is a folder.")
    from ..api import create_delegate

    printer = DiagnosticPrinter()
    render = open_stage(
        args, "default" if args.defaultTime else args.timeCode, printer, delegate=create_delegate(capture_only=True)
    )
    render.prepare()
    printer.finish()
    try:
        shrunk = render.delegate.write_capture(path, os.path.basename(args.usdFilePath), args.maxTexture)
    except RuntimeError as error:
        raise HdWavefrontError(str(error)) from None
    if shrunk:
        print(f"{shrunk} textures were halved down to {args.maxTexture}: the picture is not `record`'s.")
    print(
        f"Camera: {render.camera}",
        f"Size: {render.size[0]} x {render.size[1]}",
        f"Wrote {path} ({os.path.getsize(path) / 1e6:.1f} MB)",
        sep="\n",
        flush=True,
    )
    return EXIT_OK
