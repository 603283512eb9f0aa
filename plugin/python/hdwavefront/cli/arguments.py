# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The flags of `hdwavefront record`: usdrecord's by usdrecord's names, then ours. Render settings make flags by
themselves, one per row of the core's table."""

from __future__ import annotations

import argparse
from typing import Any

from ..stage_adapters import WINDOW_POLICIES
from . import named_scenes

_COMPLEXITIES = ("low", "medium", "high", "veryhigh")
# Settings that have a flag of another name.
_OWN_FLAGS = frozenset({"domeLightCameraVisibility"})


def _truth(text: str) -> bool:
    if text.lower() in ("1", "true", "on", "yes"):
        return True
    if text.lower() in ("0", "false", "off", "no"):
        return False
    raise argparse.ArgumentTypeError(f"'{text}' is neither true nor false")


def add_record_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("usdFilePath", help=f"what to record: {named_scenes.HELP}")
    parser.add_argument(
        "outputImagePath",
        help="Output image path. For frame ranges, the path must contain exactly one frame number placeholder of the "
        'form "###" or "###.###". The number of hash marks is variable in each group.',
    )
    group = parser.add_argument_group("usdrecord's arguments")
    _add_usdrecord_stage_arguments(group)
    _add_usdrecord_image_arguments(group)
    group = parser.add_argument_group("hdWavefront's arguments")
    _add_own_stage_arguments(group)
    _add_own_image_arguments(group)
    _add_setting_arguments(parser.add_argument_group("render settings"))


def add_capture_arguments(parser: argparse.ArgumentParser) -> None:
    """What a scene is made of, by the names that `record` has for it."""
    parser.add_argument("usdFilePath", help=f"what to capture: {named_scenes.HELP}")
    parser.add_argument("sceneFilePath", help="file to write, for wavefront-bench; by habit NAME.hdwscene")
    _add_usdrecord_stage_arguments(parser)
    times = parser.add_mutually_exclusive_group()
    times.add_argument("--frames", "-f", dest="timeCode", type=float, metavar="TIMECODE", help="one time code")
    times.add_argument("--defaultTime", "-d", action="store_true", help="capture the default time")
    _add_own_stage_arguments(parser)
    parser.add_argument(
        "--maxTexture",
        type=int,
        default=0,
        metavar="N",
        help="halve textures until no side is longer than N pixels, for a smaller file; 0: keep all (default)",
    )
    _add_setting_arguments(parser.add_argument_group("render settings, which the file keeps"))
    # What only an image has.
    parser.set_defaults(colorCorrectionMode=None, display="", view="", device="", disableGpu=False)


def _add_usdrecord_stage_arguments(group: Any) -> None:
    """What is rendered, by usdrecord's names."""
    group.add_argument(
        "--camera",
        "-cam",
        default="",
        help="Camera to use: a prim path, or a prim name. Default: the RenderSettings prim's, "
        "main_cam, the stage's only camera, or one that frames the stage",
    )
    group.add_argument(
        "--imageWidth", "-w", type=int, help="Width in pixels (default 960); the height follows the camera's aspect"
    )
    group.add_argument(
        "--complexity", "-c", choices=_COMPLEXITIES, default="low", help="level of subdivision (default: %(default)s)"
    )
    group.add_argument(
        "--purposes",
        metavar="PURPOSE[,PURPOSE...]",
        help="purposes to render besides default: render, proxy, guide (default: proxy)",
    )
    group.add_argument(
        "--mask",
        dest="populationMask",
        metavar="PRIMPATH[,PRIMPATH...]",
        help="load these prims, their descendants and ancestors only",
    )
    group.add_argument(
        "--sessionLayer", dest="sessionLayerPath", metavar="SESSIONLAYER", help="layer to open over the stage"
    )
    group.add_argument(
        "--renderSettingsPrimPath", "-rs", dest="rsPrimPath", default="", help="RenderSettings prim to use"
    )
    group.add_argument(
        "--renderPassPrimPath", "-rp", dest="rpPrimPath", default="", help="RenderPass prim whose settings are used"
    )
    group.add_argument("--disableCameraLight", action="store_true", help="never add a camera light")
    group.add_argument(
        "--enableDomeLightVisibility",
        action="store_true",
        dest="domeLightVisibility",
        help="dome lights are seen in the background",
    )
    group.add_argument(
        "--resolver",
        choices=("root", "inherit"),
        default="root",
        help="asset paths are resolved for the root layer, or as the environment says (default: %(default)s)",
    )


def _add_usdrecord_image_arguments(group: Any) -> None:
    times = group.add_mutually_exclusive_group()
    times.add_argument(
        "--defaultTime", "-d", action="store_true", help="render the default time, not the stage's start"
    )
    times.add_argument(
        "--frames",
        "-f",
        metavar="FRAMESPEC[,FRAMESPEC...]",
        help="time codes: 123, 101:105, 105:101, 101:109x2, 101:104x0.5",
    )
    group.add_argument(
        "--colorCorrectionMode",
        "-color",
        choices=("disabled", "sRGB", "openColorIO"),
        help="how colour is written (default: openColorIO for PNG, JPEG and TIFF, scene-linear for EXR and HDR)",
    )
    group.add_argument("--traceToFile", metavar="FILE", help="write what USD's tracing saw to this file")
    group.add_argument(
        "--traceFormat", choices=("chrome", "trace"), default="chrome", help="format of it (default: %(default)s)"
    )
    group.add_argument("--memstats", action="store_true", help="taken for usdrecord's sake, with a word; see --stats")
    group.add_argument(
        "--disableDrawMode", action="store_true", help="draw full geometry in place of model:drawMode; always so here"
    )
    group.add_argument("--disableGpu", action="store_true", help="render on the processor, by a Vulkan driver for it")
    group.add_argument("--renderer", "-r", help="taken for usdrecord's sake; this renderer is always Wavefront")


def _add_own_stage_arguments(group: Any) -> None:
    group.add_argument(
        "--imageHeight", type=int, help="Height in pixels (default: from the width and the camera's aspect)"
    )
    group.add_argument(
        "--windowPolicy",
        default="",
        choices=WINDOW_POLICIES,
        help="how the camera's aperture fits the image (default: the RenderSettings prim's, else expandAperture)",
    )
    group.add_argument(
        "--enableCameraLight", action="store_true", help="add a camera light even if the stage shines by itself"
    )
    group.add_argument(
        "--aov", action="append", default=[], metavar="NAME", help="further layer of an EXR; may be repeated"
    )
    group.add_argument(
        "--ocio", default="", metavar="CONFIG", help="OpenColorIO configuration (default: $OCIO, else built in)"
    )
    group.add_argument(
        "--renderingColorSpace",
        default="",
        metavar="SPACE",
        help="scene-linear space to render in (default: lin_rec709)",
    )


def _add_own_image_arguments(group: Any) -> None:
    group.add_argument("--display", default="", help="display of the OpenColorIO configuration (default: its own)")
    group.add_argument("--view", default="", help="view of the display (default: its own)")
    group.add_argument(
        "--device",
        default="",
        help="Vulkan device: index, or part of its name (default: $HDWAVEFRONT_DEVICE, else the best)",
    )
    group.add_argument("--stats", metavar="FILE", help="write times, counts and memory as JSON")


def setting_rows() -> list[dict[str, Any]]:
    """The core's render settings; none where the native module does not load, which is said when it is needed."""
    try:
        from .. import _core

        return [row for row in _core.render_settings() if row["token"] not in _OWN_FLAGS]
    except (ImportError, AttributeError):
        return []


def _add_setting_arguments(group: Any) -> None:
    types = {"int": int, "float": float, "string": str}
    for row in setting_rows():
        flag = row.get("flag") or row["token"]
        flag = flag if flag.startswith("-") else "--" + flag
        help_text = f"{row['doc']} (default: {row['default']})".replace("%", "%%")
        options: dict[str, Any] = {"dest": "setting_" + row["token"], "help": help_text, "default": None}
        if row["type"] == "bool":
            group.add_argument(flag, type=_truth, nargs="?", const=True, metavar="BOOL", **options)
        elif row["type"] == "token":
            group.add_argument(flag, choices=row["choices"], **options)
        else:
            group.add_argument(flag, type=types[row["type"]], metavar=row["type"].upper(), **options)


def settings_from(args: argparse.Namespace) -> dict[str, Any]:
    prefix = "setting_"
    return {k[len(prefix) :]: v for k, v in vars(args).items() if k.startswith(prefix) and v is not None}
