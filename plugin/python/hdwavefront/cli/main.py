# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Entry point. Nothing heavy is imported before the arguments are known to make sense."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from ..errors import EXIT_FAILED, EXIT_INTERRUPTED, HdWavefrontError


def build_parser() -> argparse.ArgumentParser:
    from .arguments import add_capture_arguments, add_record_arguments
    from .bench import add_bench_arguments
    from .explain import add_explain_arguments

    parser = argparse.ArgumentParser(
        prog="hdwavefront", description="Renders USD stages by wavefront path tracing on Vulkan."
    )
    parser.add_argument("--version", action="store_true", help="print the version and end")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND")
    record = commands.add_parser(
        "record", help="render a stage to an image", description="Generates images from a USD file."
    )
    add_record_arguments(record)
    add_explain_arguments(
        commands.add_parser(
            "explain",
            help="a stage's materials: networks, closure trees, generated kernels, and what they cost",
            description="Explains what became of the materials of a USD file, and measures what they cost.",
        )
    )
    add_bench_arguments(
        commands.add_parser(
            "bench",
            help="speed: the paper's tables, wavefront against megakernel, and sweeps",
            description="Measures speed on scenes of the project's own: wavefront and megakernel in turns, in the "
            "paper's tables with the paper's figures beside them; and sweeps over one number.",
        )
    )
    add_capture_arguments(
        commands.add_parser(
            "capture",
            help="write a stage as a scene file that wavefront-bench replays on machines without USD",
            description="Writes what the renderer is told of a USD file into one file: meshes, lights, camera, texels, "
            "settings, and the kernels of its materials. wavefront-bench replays it to the bit.",
        )
    )
    commands.add_parser("doctor", help="device, driver, versions, colour configuration, and what is wrong")
    return parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Returns the exit code: 0 done, 1 the input or the environment failed, 2 wrong usage, 130 interrupted."""
    parser = build_parser()
    try:
        args = parser.parse_args(arguments)
    except SystemExit as end:  # argparse ends the process itself; in-process callers want the code
        return int(end.code or 0)
    try:
        if args.version:
            from .doctor import print_version

            return print_version()
        from . import named_scenes

        if args.command == "record":
            from .record import record

            with named_scenes.built(args):
                return record(args)
        if args.command == "explain":
            from .explain import explain

            with named_scenes.built(args):
                return explain(args)
        if args.command == "bench":
            from .bench import bench

            return bench(args)
        if args.command == "capture":
            from .capture import capture

            with named_scenes.built(args):
                return capture(args)
        if args.command == "doctor":
            from .doctor import doctor

            return doctor()
        parser.print_help()
        return 2
    except HdWavefrontError as error:
        print(f"hdwavefront: error: {error}", file=sys.stderr)
        return error.exit_code
    except KeyboardInterrupt:
        print("\nhdwavefront: interrupted before anything was rendered; nothing was written", file=sys.stderr)
        return EXIT_INTERRUPTED
    except MemoryError:
        print("hdwavefront: error: the memory does not suffice for this scene or image size", file=sys.stderr)
        return EXIT_FAILED
    except BrokenPipeError:
        return EXIT_FAILED


if __name__ == "__main__":
    sys.exit(main())
