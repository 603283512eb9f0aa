# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""`hdwavefront explain`: what became of a stage's materials, and what they cost."""

from __future__ import annotations

import argparse
import json
import os
import sys
from typing import Any

from ..errors import EXIT_INTERRUPTED, EXIT_OK, UsageError
from . import named_scenes

_NAMES_SHOWN = 6


def add_explain_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("usdFilePath", help=f"whose materials are explained: {named_scenes.HELP}")
    parser.add_argument(
        "material",
        nargs="?",
        default="",
        help="path or name of one material: its network, closure tree and generated GLSL (default: all, in short)",
    )
    parser.add_argument("--json", action="store_true", help="print JSON")
    parser.add_argument("--camera", "-cam", default="", help="camera to measure with; as of record")
    parser.add_argument(
        "--samples", type=int, default=8, help="samples to measure with; 0: none (default: %(default)s)"
    )
    parser.add_argument("--imageWidth", "-w", type=int, default=320, help="width to measure at (default: %(default)s)")
    parser.add_argument("--complexity", "-c", default="low", help="level of subdivision (default: %(default)s)")
    parser.add_argument("--device", default="", help="Vulkan device; as of record")


def _choose(kernels: list[dict[str, Any]], name: str) -> str:
    paths = sorted({path for kernel in kernels for path in kernel["materials"]})
    if name in paths:
        return name
    found = [path for path in paths if path.rsplit("/", 1)[-1] == name]
    if len(found) == 1:
        return found[0]
    if found:
        raise UsageError(
            f"{len(found)} materials are called {name}: give one path of {', '.join(found[:_NAMES_SHOWN])}."
        )
    known = ", ".join(paths[:_NAMES_SHOWN]) + (", ..." if len(paths) > _NAMES_SHOWN else "")
    raise UsageError(f"The stage has no material {name}" + (f"; it has {known}." if paths else "."))


def explain_material(render: Any, kernels: list[dict[str, Any]], path: str) -> dict[str, Any]:
    """All that is known about one material, as it is printed by --json."""
    kernel = next(kernel for kernel in kernels if path in kernel["materials"])
    return {
        "material": path,
        **render.delegate.explain_material(path),
        "kernel": {**kernel, "glsl": render.delegate.material_source(path)},
    }


def _number(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:.4g}"
    if isinstance(value, (list, tuple)):
        return "(" + ", ".join(_number(item) for item in value) + ")"
    if isinstance(value, dict):
        return str(value.get("resolvedPath") or value.get("authoredPath"))
    return str(value)


def _cost(kernel: dict[str, Any]) -> list[str]:
    made = kernel["codeMilliseconds"], kernel["createMilliseconds"] + kernel["firstDispatchMilliseconds"]
    lines = [
        f"compiled: {kernel['state']}; network to GLSL {kernel['generateMilliseconds']:.1f} ms, "
        f"to SPIR-V {made[0]:.0f} ms"
        + (" (cache)" if kernel["codeFromCache"] else "")
        + f", driver {made[1]:.0f} ms; SPIR-V {kernel['spirvBytes'] / 1e3:.0f} kB, "
        f"{kernel['spirvInstructions']} instructions"
    ]
    for statistic in kernel["driverStatistics"]:
        lines.append(f"driver: {statistic}")
    if not kernel["driverStatistics"] and kernel["state"] == "ready":
        lines.append("driver: tells nothing of its code (no VK_KHR_pipeline_executable_properties)")
    if kernel["paths"]:
        lines.append(
            f"render: {kernel['nanosecondsPerPath']:.0f} ns a path, {kernel['paths']} paths, "
            f"{kernel['share']:.1%} of all kernels' time"
        )
    else:
        lines.append("render: no path met it")
    return lines


def _short(names: list[str]) -> str:
    more = len(names) - _NAMES_SHOWN
    return ", ".join(names[:_NAMES_SHOWN]) + (f" and {more} more" if more > 0 else "")


def _print_material(facts: dict[str, Any]) -> None:
    kernel = facts["kernel"]
    print(facts["material"])
    context = facts["context"] or "universal"
    print(f"\nNetwork ({context} terminal), {len(facts['nodes'])} nodes")
    sources = {(c["downstreamNode"], c["downstreamInput"]): c for c in facts["connections"]}
    for node in facts["nodes"]:
        print(f"  {node['path']}  {node['identifier']}")
        for name, value in sorted(node["parameters"].items()):
            if (node["path"], name) not in sources:
                print(f"    {name} = {_number(value)}")
        for (downstream, name), c in sorted(sources.items()):
            if downstream == node["path"]:
                print(f"    {name} <- {c['upstreamNode']}.{c['upstreamOutput']}")
    print("\nClosure tree")
    for line in facts["closureTree"].splitlines():
        print("  " + line)
    print(f"\nKernel {kernel['key']}")
    print(f"  lobes: {', '.join(kernel['lobes']) or 'none'}")
    print(f"  primvars: {', '.join(kernel['primvars']) or 'none'}")
    others = [path for path in kernel["materials"] if path != facts["material"]]
    print(f"  shared with {len(others)} other materials" + (f": {_short(others)}" if others else ""))
    for line in _cost(kernel):
        print("  " + line)
    for entry, source in kernel["glsl"].items():
        print(f"\nGLSL of {entry}\n{source}")


def _print_all(kernels: list[dict[str, Any]], stats: dict[str, Any]) -> None:
    materials = sum(len(kernel["materials"]) for kernel in kernels)
    print(f"{materials} materials, {len(kernels)} kernels", end="")
    if stats["firstPathSeconds"]:
        print(f"; first path after {stats['firstPathSeconds']:.2f} s", end="")
    if stats["kernelsReadySeconds"]:
        print(f", all kernels ready after {stats['kernelsReadySeconds']:.2f} s", end="")
    print()
    for kernel in sorted(kernels, key=lambda k: -float(k["milliseconds"])):
        print(f"\nKernel {kernel['key']}: {', '.join(kernel['lobes']) or 'no lobes'}")
        print(f"  {len(kernel['materials'])} materials: {_short(kernel['materials'])}")
        for line in _cost(kernel):
            print("  " + line)


def explain(args: argparse.Namespace) -> int:
    from ..api import Render

    if args.samples < 0 or args.imageWidth < 1:
        raise UsageError("--samples must be at least 0, and --imageWidth at least 1.")
    os.environ.setdefault("HDWAVEFRONT_DRIVER_STATISTICS", "1")  # before the device is made
    render = Render(
        args.usdFilePath,
        camera=args.camera,
        width=args.imageWidth,
        complexity=args.complexity,
        device=args.device,
        on_diagnostic=lambda diagnostic: print(diagnostic, file=sys.stderr),
        settings={"samples": max(1, args.samples)},
    )
    render.prepare()
    kernels = [kernel for kernel in render.stats()["kernelSources"] if kernel["materials"]]
    path = _choose(kernels, args.material) if args.material else ""
    if args.samples:
        try:
            render.start()
            while not render.wait(0.25):
                pass
        except KeyboardInterrupt:
            render.stop()
            return EXIT_INTERRUPTED
    stats = render.stats()
    kernels = [kernel for kernel in stats["kernelSources"] if kernel["materials"]]
    if path:
        facts = explain_material(render, kernels, path)
        print(json.dumps(facts, indent=2, default=float)) if args.json else _print_material(facts)
    elif args.json:
        facts = {name: stats[name] for name in ("firstPathSeconds", "kernelsReadySeconds", "renderSeconds")}
        print(json.dumps({**facts, "kernels": kernels}, indent=2, default=float))
    else:
        _print_all(kernels, stats)
    return EXIT_OK
