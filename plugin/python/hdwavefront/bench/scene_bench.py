# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The scenes in both modes: what the paper's tables show."""

from __future__ import annotations

from typing import Any

from .runner import Outcome


def summary(name: str, outcome: Outcome) -> dict[str, Any] | None:
    """What --json and the tables have of a scene; None where nothing was measured."""
    wave, mega = outcome.modes.get("wavefront"), outcome.modes.get("megakernel")
    if wave is None or wave["mpathsPerSecond"] <= 0:
        return None
    result: dict[str, Any] = {
        "name": name,
        **outcome.scene,
        "wavefront": wave,
        "megakernel": mega,
        "gain": None,
        "gainInCpuTime": None,
        "identical": outcome.identical,
    }
    if mega is not None and mega["mpathsPerSecond"] > 0:
        result["gain"] = wave["mpathsPerSecond"] / mega["mpathsPerSecond"] - 1
        result["gainInCpuTime"] = wave["mpathsPerCpuSecond"] / mega["mpathsPerCpuSecond"] - 1
    else:
        result["megakernel"] = None
    return result


def brief(result: dict[str, Any]) -> str:
    """A line for those who wait."""
    text = f"wavefront {result['wavefront']['mpathsPerSecond']:.3g} Mpaths/s"
    if result["megakernel"]:
        text += f", megakernel {result['megakernel']['mpathsPerSecond']:.3g}, gain {result['gain'] * 100:+.0f} %"
    return text


def remarks(name: str, outcome: Outcome) -> list[str]:
    """What is missing, and why."""
    lines = [f"{name}: no {mode}: {why}" for mode, why in outcome.why_not.items()]
    if outcome.error:
        lines.append(f"{name}: FAILED: {outcome.error}")
    if outcome.timed_out:
        missing = "" if "megakernel" in outcome.modes else "; the megakernel was not ready (it compiles first)"
        lines.append(f"{name}: ended after {outcome.seconds:.0f} s, when its time was over{missing}")
    if outcome.identical is False:
        lines.append(f"{name}: THE PICTURES DIFFER between wavefront and megakernel")
    return lines
