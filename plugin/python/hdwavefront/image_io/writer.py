# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Writes renders. Paths are checked before rendering; files are written beside and renamed.

EXR: 32-bit float. The colour layer's channels are R, G, B, A; each other AOV is a layer of its token: albedo.R .G .B,
normal.X .Y .Z, Neye.X .Y .Z, primvars:st.X .Y .Z (any primvar), depth.Z, cameraDepth.Z, primId.id, instanceId.id,
elementId.id (-1 = miss), sampleCount.samples, materialCost.ns.
PNG, JPEG, TIFF, HDR and others hold the colour only. PNG and TIFF hold straight alpha.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import HdWavefrontError, UsageError

# Extension -> (scene-linear by default, bits of display-referred values).
FORMATS: dict[str, tuple[bool, int]] = {
    ".exr": (True, 32),
    ".hdr": (True, 32),
    ".png": (False, 8),
    ".jpg": (False, 8),
    ".jpeg": (False, 8),
    ".tif": (False, 16),
    ".tiff": (False, 16),
    ".bmp": (False, 8),
    ".tga": (False, 8),
}
_HOLDS_ALPHA = frozenset({".png", ".tif", ".tiff", ".tga"})

# CIE xy of red, green, blue and white, which EXR stores in `chromaticities`.
_CHROMATICITIES = {
    "lin_rec709": (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290),
    "lin_ap1": (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767),
    "acescg": (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, 0.32168, 0.33767),
    "lin_rec2020": (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290),
    "lin_p3d65": (0.680, 0.320, 0.265, 0.690, 0.150, 0.060, 0.3127, 0.3290),
}


def extension(path: str) -> str:
    return os.path.splitext(path)[1].lower()


def is_scene_linear(path: str) -> bool:
    return FORMATS[extension(path)][0]


def holds_alpha(path: str) -> bool:
    return extension(path) in _HOLDS_ALPHA or extension(path) == ".exr"


def check_output(path: str, aovs: list[str] | tuple[str, ...] = ("color",)) -> None:
    """Everything that can be known to go wrong before a render, as one clear error."""
    known = ", ".join(FORMATS)
    kind = extension(path)
    if kind not in FORMATS:
        what = f"the unknown extension '{kind}'" if kind else "no extension"
        raise UsageError(f"The output image {path} has {what}; one of {known} is needed.")
    extra = [a for a in aovs if a != "color"]
    if extra and kind != ".exr":
        raise UsageError(f"The AOVs {', '.join(extra)} need an .exr file; {path} can hold the colour only.")
    folder = os.path.dirname(os.path.abspath(path))
    if not os.path.isdir(folder):
        raise HdWavefrontError(f"The folder {folder} of the output image does not exist.")
    if os.path.isdir(path):
        raise HdWavefrontError(f"The output image {path} is a folder.")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise HdWavefrontError(f"The folder {folder} of the output image cannot be written to.")
    if os.path.exists(path) and not os.access(path, os.W_OK):
        raise HdWavefrontError(f"The output image {path} exists and cannot be overwritten.")


def write_linear(
    path: str,
    layers: Mapping[str, np.ndarray],
    metadata: Mapping[str, Any],
    rendering_space: str,
    place: tuple[int, int, int, int] | None = None,
) -> None:
    """An EXR with all layers, or an HDR with the colour. Layers by AOV token: (height, width, components).

    `place` of a part in the whole picture: left column, upper row, the picture's width and height.
    """
    from .._core import aov_channels

    if extension(path) == ".hdr":
        _write(path, np.ascontiguousarray(layers["color"][..., :3], dtype=np.float32), ["R", "G", "B"], {}, "float")
        return
    arrays: list[np.ndarray] = []
    names: list[str] = []
    for token, array in layers.items():
        array = np.asarray(array)
        array = array.reshape(array.shape[0], array.shape[1], -1)
        names += aov_channels(token)
        arrays.append(array.astype(np.float32, copy=False))
    attributes = dict(metadata)
    attributes["oiio:ColorSpace"] = rendering_space
    chromaticities = _CHROMATICITIES.get(rendering_space.lower())
    if chromaticities:
        attributes["chromaticities"] = chromaticities
    _write(path, np.concatenate(arrays, axis=2), names, attributes, "float", place)


def write_display(path: str, rgba: np.ndarray, metadata: Mapping[str, Any]) -> None:
    """Display-referred values in 0..1 with straight alpha, quantised to the bits of the format (float in .exr)."""
    kind = extension(path)
    if FORMATS[kind][1] == 32:
        write_linear(path, {"color": rgba}, metadata, "")
        return
    channels = 4 if kind in _HOLDS_ALPHA else 3
    bits = FORMATS[kind][1]
    top = (1 << bits) - 1
    values = np.nan_to_num(rgba[..., :channels], nan=0.0, posinf=1.0, neginf=0.0)
    dtype = np.uint8 if bits == 8 else np.uint16
    quantised = (np.clip(values, 0.0, 1.0) * top + 0.5).astype(dtype)
    attributes: dict[str, Any] = {k: v for k, v in metadata.items() if isinstance(v, str)}
    attributes["oiio:UnassociatedAlpha"] = 1
    _write(path, quantised, ["R", "G", "B", "A"][:channels], attributes, "uint8" if bits == 8 else "uint16")


def _write(
    path: str,
    pixels: np.ndarray,
    names: list[str],
    attributes: Mapping[str, Any],
    format_name: str,
    place: tuple[int, int, int, int] | None = None,
) -> None:
    import OpenImageIO as oiio

    folder, name = os.path.split(os.path.abspath(path))
    beside = os.path.join(folder, f".{name}.{os.getpid()}.part{extension(path)}")
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], format_name)
    spec.channelnames = tuple(names)
    if place:
        spec.x, spec.y, spec.full_width, spec.full_height = place
    if "A" in names:
        spec.alpha_channel = names.index("A")
    if extension(path) == ".exr":
        spec.attribute("compression", "zip")
    if extension(path) in (".jpg", ".jpeg"):
        spec.attribute("CompressionQuality", 95)
    for key, value in attributes.items():
        _set_attribute(spec, key, value, oiio)
    try:
        output = oiio.ImageOutput.create(beside)
        if output is None:
            raise HdWavefrontError(f"The image {path} cannot be written: {oiio.geterror().strip()}")
        written = output.open(beside, spec) and output.write_image(np.ascontiguousarray(pixels))
        reason = "" if written else output.geterror().strip()
        written = bool(output.close()) and written
        if not written:
            raise HdWavefrontError(f"The image {path} cannot be written: {reason or 'the disk may be full'}")
        os.replace(beside, path)
    except OSError as error:
        raise HdWavefrontError(f"The image {path} cannot be written: {error.strerror}") from None
    finally:
        if os.path.exists(beside):
            os.remove(beside)


def _set_attribute(spec: Any, key: str, value: Any, oiio: Any) -> None:
    if isinstance(value, np.ndarray) and value.size == 16:
        spec.attribute(key, oiio.TypeMatrix, tuple(float(x) for x in value.reshape(-1)))
    elif isinstance(value, tuple):
        spec.attribute(key, oiio.TypeDesc(f"float[{len(value)}]"), tuple(float(x) for x in value))
    else:
        spec.attribute(key, value)
