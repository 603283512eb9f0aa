# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""FrameSpecs and the frame number in an output path, as usdrecord has them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from decimal import Decimal, InvalidOperation

from ..errors import UsageError

_PLACEHOLDER = re.compile(r"^[^#]*(?P<placeholder>#+(\.#+)?)[^#]*$")
MAX_FRAMES = 1_000_000


def _number(text: str, spec: str) -> Decimal:
    try:
        value = Decimal(text)
    except InvalidOperation:
        value = Decimal("nan")
    if not value.is_finite():
        raise UsageError(f"--frames: '{spec}' is no FrameSpec such as 123, 101:105, 101:109x2 or 101:104x0.5.")
    return value


def _one_spec(spec: str) -> Iterator[float]:
    ends, _, stride_text = spec.partition("x")
    parts = ends.split(":")
    if len(parts) > 2 or ("x" in spec and (len(parts) != 2 or not stride_text)):
        raise UsageError(f"--frames: '{spec}' is no FrameSpec such as 123, 101:105, 101:109x2 or 101:104x0.5.")
    start = _number(parts[0], spec)
    end = _number(parts[-1], spec)
    stride = _number(stride_text, spec) if stride_text else Decimal(1 if end >= start else -1)
    if stride == 0 or (end - start) * stride < 0:
        raise UsageError(f"--frames: the stride of '{spec}' never leads from its start to its end.")
    count = math.floor((end - start) / stride) + 1
    if count > MAX_FRAMES:
        raise UsageError(f"--frames: '{spec}' has more than {MAX_FRAMES} frames.")
    return (float(start + stride * i) for i in range(count))


def parse_frames(text: str) -> list[float]:
    return [frame for spec in text.split(",") for frame in _one_spec(spec.strip())]


def stride_precision(text: str) -> int:
    """Decimals that tell any two frames apart."""
    strides = [spec.partition("x")[2] for spec in text.split(",")]
    return max((len(s.partition(".")[2]) for s in strides), default=0)


def placeholder(path: str) -> str:
    match = _PLACEHOLDER.match(path)
    return match.group("placeholder") if match else ""


def check_path(path: str, frames: str | None) -> None:
    """UsageError where the path's placeholder and the frames do not go together."""
    mark = placeholder(path)
    if frames is None:
        if mark:
            raise UsageError("outputImagePath cannot contain a frame number placeholder when no --frames are given.")
        return
    if not mark:
        raise UsageError(
            "With --frames, outputImagePath must contain exactly one frame number placeholder of the form "
            '"###" or "###.###".'
        )
    precision = len(mark.partition(".")[2])
    if precision < stride_precision(frames):
        raise UsageError(
            f"The frames need {stride_precision(frames)} decimals, but the placeholder {mark} in outputImagePath "
            f"has {precision}."
        )


def frame_path(path: str, frame: float) -> str:
    mark = placeholder(path)
    if not mark:
        return path
    precision = len(mark.partition(".")[2])
    return path.replace(mark, f"{frame:0{len(mark)}.{precision}f}")
