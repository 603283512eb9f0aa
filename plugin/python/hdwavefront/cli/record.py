# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`hdwavefront record`."""

from __future__ import annotations

import argparse
import json
import os
import resource
import sys
import time
from collections import Counter
from typing import Any

from ..errors import EXIT_INTERRUPTED, EXIT_OK, Diagnostic, HdWavefrontError, UsageError
from ..stage_adapters import PURPOSES
from . import frames as frame_specs
from .arguments import settings_from
from .progress import ProgressDisplay

_LINES_PER_CODE = 8


class DiagnosticPrinter:
    """Prints the first diagnostics of each kind as they come, and counts the rest."""

    def __init__(self) -> None:
        self._counts: Counter[str] = Counter()
        self.progress: ProgressDisplay | None = None

    def __call__(self, diagnostic: Diagnostic) -> None:
        self._counts[diagnostic.code] += 1
        if self._counts[diagnostic.code] > _LINES_PER_CODE:
            return
        if self.progress:
            self.progress.clear()
        print(diagnostic, file=sys.stderr)

    def finish(self) -> None:
        for code, count in self._counts.items():
            if count > _LINES_PER_CODE:
                print(f"... and {count - _LINES_PER_CODE} more of [{code}]", file=sys.stderr)


def _purposes(text: str | None) -> frozenset[str] | None:
    if text is None:
        return None
    purposes = frozenset(text.replace(",", " ").split())
    unknown = sorted(purposes - set(PURPOSES))
    if unknown:
        raise UsageError(f"--purposes: '{unknown[0]}' is none of {', '.join(PURPOSES)}.")
    return purposes


def _check_before(args: argparse.Namespace) -> None:
    """What can be said without opening anything."""
    from ..image_io.writer import check_output

    frame_specs.check_path(args.outputImagePath, args.frames)
    check_output(args.outputImagePath, ("color", *args.aov))
    if args.disableCameraLight and args.enableCameraLight:
        raise UsageError("--disableCameraLight and --enableCameraLight cannot both be given.")
    for name in ("imageWidth", "imageHeight"):
        value = getattr(args, name)
        if value is not None and value <= 0:
            raise UsageError(f"--{name} is {value}; it must be at least 1.")
    for flag in ("stats", "traceToFile"):
        if not getattr(args, flag):
            continue
        folder = os.path.dirname(os.path.abspath(getattr(args, flag)))
        if not os.path.isdir(folder) or not os.access(folder, os.W_OK):
            raise HdWavefrontError(f"The folder {folder} of the --{flag} file does not exist or cannot be written to.")


def _say_what_changes_nothing(args: argparse.Namespace) -> None:
    """Flags that are taken so that usdrecord's command lines run, and that have no work to do here."""
    if args.memstats:
        print("--memstats changes nothing: --stats FILE writes memory by kind.", file=sys.stderr)
    if args.renderer and args.renderer.lower() not in ("wavefront", "hdwavefront"):
        print(f"--renderer {args.renderer} changes nothing: this renderer is always Wavefront.", file=sys.stderr)


def _device(args: argparse.Namespace) -> str:
    """--disableGpu means a device that is a processor."""
    if not args.disableGpu:
        return str(args.device)
    if args.device:
        raise UsageError("--device and --disableGpu cannot both be given.")
    from ..api import core

    for index, device in enumerate(core().list_devices()):
        if device["type"] == "CPU" and device["usable"]:
            return str(index)
    raise HdWavefrontError("--disableGpu: there is no Vulkan driver that runs on the processor (mesa-vulkan-drivers).")


def open_stage(args: argparse.Namespace, frame: float | str | None, printer: DiagnosticPrinter, **options: Any) -> Any:
    """The Render that the arguments ask for; `options` are further ones of it."""
    from ..api import Render

    return Render(
        args.usdFilePath,
        camera=args.camera,
        width=args.imageWidth,
        height=args.imageHeight,
        frame=frame,
        complexity=args.complexity,
        purposes=_purposes(args.purposes),
        render_settings=args.rsPrimPath,
        render_pass=args.rpPrimPath,
        mask=(args.populationMask or "").replace(",", " ").split(),
        session_layer=args.sessionLayerPath or "",
        resolver=args.resolver,
        aovs=args.aov,
        ocio=args.ocio,
        display=args.display,
        view=args.view,
        color_mode=args.colorCorrectionMode,
        rendering_space=args.renderingColorSpace,
        camera_light=True if args.enableCameraLight else False if args.disableCameraLight else None,
        dome_visible=args.domeLightVisibility,
        device=_device(args),
        on_diagnostic=printer,
        window_policy=args.windowPolicy,
        settings=settings_from(args),
        **options,
    )


def record(args: argparse.Namespace) -> int:
    if not args.traceToFile:
        return _record(args)
    from ..stage import import_pxr

    import_pxr()
    from pxr import Trace

    Trace.Collector().enabled = True
    try:
        return _record(args)
    finally:
        Trace.Collector().enabled = False
        reporter = Trace.Reporter.globalReporter
        (reporter.Report if args.traceFormat == "trace" else reporter.ReportChromeTracingToFile)(args.traceToFile)


def _record(args: argparse.Namespace) -> int:
    begin = time.perf_counter()
    frames: list[Any] = (
        frame_specs.parse_frames(args.frames) if args.frames else ["default" if args.defaultTime else None]
    )
    _check_before(args)
    _say_what_changes_nothing(args)
    printer = DiagnosticPrinter()
    render = open_stage(args, frames[0], printer)
    folder = os.path.dirname(os.path.abspath(args.outputImagePath))
    from ..image_io.writer import check_output

    for product, path in render.product_paths(folder):
        check_output(path, product.aovs)
    try:
        for index, frame in enumerate(frames):
            if index:
                render.set_frame(frame)
            path = (
                args.outputImagePath
                if frame in (None, "default")
                else frame_specs.frame_path(args.outputImagePath, frame)
            )
            interrupted = _record_frame(render, path, folder, printer)
            if args.stats:
                _write_stats(args.stats, render, time.perf_counter() - begin)
            if interrupted:
                return EXIT_INTERRUPTED
    finally:
        printer.finish()
    return EXIT_OK


def _record_frame(render: Any, path: str, folder: str, printer: DiagnosticPrinter) -> bool:
    """True if Ctrl-C ended it early."""
    time_code = "default" if render.time.IsDefault() else f"{render.time.GetValue():g}"
    render.prepare()
    samples = int(render.delegate.setting("samples"))
    print(
        f"Camera: {render.camera}",
        f"Time code: {time_code}",
        f"Size: {render.size[0]} x {render.size[1]}",
        sep="\n",
        flush=True,
    )
    finished = _run(render, samples, printer)
    state = render.progress
    if not finished and state["pathsDone"] == 0:
        print("Interrupted before the first sample; nothing was written.", file=sys.stderr)
        return True
    render.save(path)

    def run() -> bool:
        nonlocal finished
        finished = finished and _run(render, samples, printer)
        return finished

    written = [path, *render.save_products(folder, run)]
    done = f"{state['samplesDone']} of {samples} samples"
    if finished:
        print(f"Wrote {', '.join(written)} ({done}, {state['seconds']:.1f} s)", flush=True)
    else:
        print(f"Interrupted after {done}; what there is was written to {', '.join(written)}.", file=sys.stderr)
    return not finished


def _run(render: Any, samples: int, printer: DiagnosticPrinter) -> bool:
    """Renders, telling how far it is. False if Ctrl-C ended it early."""
    progress = ProgressDisplay(samples)
    printer.progress = progress
    try:
        render.start()
        while not render.wait(0.25):
            progress.update(render.progress)
    except KeyboardInterrupt:
        render.stop()
        return False
    finally:
        progress.clear()
        printer.progress = None
    return True


def _write_stats(path: str, render: Any, seconds: float) -> None:
    from ..api import core

    stats = dict(render.stats())
    stats["seconds"] = {"total": seconds, "render": render.progress["seconds"], **render.timings}
    rendering = max(stats["renderSeconds"], 1e-9)
    stats["mpathsPerSecond"] = stats["paths"] / rendering * 1e-6
    stats["mraysPerSecond"] = (stats["extensionRays"] + stats["shadowRays"]) / rendering * 1e-6
    stats["hostPeakMemoryBytes"] = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    stats["stage"] = render.path
    stats["camera"] = render.camera
    stats["width"], stats["height"] = render.size
    stats["settings"] = {row["token"]: render.delegate.setting(row["token"]) for row in core().render_settings()}
    stats["build"] = core().build_facts()
    stats["diagnostics"] = [
        {"severity": d.severity, "code": d.code, "location": d.location, "message": d.message}
        for d in render.diagnostics
    ]
    beside = f"{path}.{os.getpid()}.part"
    try:
        with open(beside, "w", encoding="utf-8") as file:
            json.dump(stats, file, indent=2, default=float)
            file.write("\n")
        os.replace(beside, path)
    except OSError as error:
        raise HdWavefrontError(f"The statistics {path} cannot be written: {error.strerror}") from None
    finally:
        if os.path.exists(beside):
            os.remove(beside)
