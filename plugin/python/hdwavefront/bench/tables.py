# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Text of the results: the paper's two tables with its figures beside ours, and a table for each sweep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .measure import GROUPS
from .paper import PAPER

Row = Sequence[str]


def table(head: Row, rows: Sequence[Row]) -> str:
    """Columns as wide as they must be; the first one to the left, the others to the right. Markdown, too."""
    widths = [max(len(row[i]) for row in [head, *rows]) for i in range(len(head))]

    def line(row: Row) -> str:
        cells = [
            cell.ljust(w) if i == 0 else cell.rjust(w) for i, (cell, w) in enumerate(zip(row, widths, strict=True))
        ]
        return "| " + " | ".join(cells) + " |"

    rule = "|" + "|".join("-" * (w + 1) + ("-" if i == 0 else ":") for i, w in enumerate(widths)) + "|"
    return "\n".join([line(head), rule, *(line(row) for row in rows)])


def number(value: float, digits: int = 3) -> str:
    """So many digits that count, never as a power of ten."""
    if value == 0:
        return "0"
    size = abs(value)
    places = max(0, digits - 1 - (len(str(int(size))) - 1 if size >= 1 else 0))
    if size < 1:
        places = digits
        while places < 8 and round(size, places) < 10 ** (digits - 1) * 10**-places:
            places += 1
    return f"{value:,.{places}f}"


def percent(value: float) -> str:
    return f"{value * 100:+.0f} %"


def with_spread(value: float, spread: float) -> str:
    return f"{number(value)} ± {spread / value * 100:.0f} %" if value else "–"


def scene_table(scenes: Sequence[Mapping[str, Any]], on_processor: bool) -> str:
    """Mpaths/s of both ways, and the gain: the paper's table 2."""
    head = ["scene", "triangles", "materials", "megakernel Mpaths/s", "wavefront Mpaths/s", "gain"]
    head += ["gain in CPU time"] if on_processor else []
    head += ["same picture", "paper: mega", "wave", "gain"]
    rows = []
    for scene in scenes:
        wave, mega = scene["wavefront"], scene["megakernel"]
        row = [scene["name"], f"{scene['triangles']:,}", f"{scene['materials']} ({scene['topologies']})"]
        row.append(with_spread(mega["mpathsPerSecond"], mega["mpathsPerSecondSpread"]) if mega else "–")
        row.append(with_spread(wave["mpathsPerSecond"], wave["mpathsPerSecondSpread"]))
        row.append(percent(scene["gain"]) if mega else "–")
        if on_processor:
            row.append(percent(scene["gainInCpuTime"]) if mega else "–")
        row.append({True: "yes", False: "NO", None: "–"}[scene["identical"]])
        paper = PAPER.get(scene["name"])
        row += [f"{paper.megakernel:.2f}", f"{paper.wavefront:.2f}", percent(paper.gain)] if paper else ["–", "–", "–"]
        rows.append(row)
    return table(head, rows)


def kernel_table(scenes: Sequence[Mapping[str, Any]], copy_bytes_per_second: float) -> str:
    """Milliseconds of a million segments by kernel, with the paper's below: its table 3."""
    head = ["ms per 1M segments", *(g for g in GROUPS), "segments a path", "state B/segment", "of copy bandwidth"]
    rows = []
    for scene in scenes:
        wave = scene["wavefront"]
        times, share = wave["millisecondsPerMillionSegments"], wave["share"]
        moved = wave["stateBytesPerSegment"] * wave["segments"] / max(wave["kernelMilliseconds"] * 1e-3, 1e-9)
        rows.append(
            [
                scene["name"],
                *(f"{number(times[g])} ({share[g] * 100:.0f} %)" for g in GROUPS),
                f"{wave['segmentsPerPath']:.2f}",
                f"{wave['stateBytesPerSegment']:.0f}",
                f"{moved / copy_bytes_per_second * 100:.0f} %",
            ]
        )
        paper = PAPER.get(scene["name"])
        if paper:
            total = sum(paper.milliseconds.values())
            rows.append(
                [
                    "  paper",
                    *(f"{paper.milliseconds[g]:.2f} ({paper.milliseconds[g] / total * 100:.0f} %)" for g in GROUPS),
                    f"{paper.segments_per_path:.2f}",
                    "",
                    "",
                ]
            )
    return table(head, rows)


def start_table(scenes: Sequence[Mapping[str, Any]]) -> str:
    """What comes before the steady state."""
    head = [
        "start-up",
        "open s",
        "compile s, wave",
        "first path s, wave",
        "first picture s, wave",
        "compile s, mega",
        "first picture CPU s, mega",  # several compile side by side
    ]
    rows = []
    for scene in scenes:
        wave, mega = scene["wavefront"], scene["megakernel"]
        row = [scene["name"], f"{wave['openSeconds']:.2f}", f"{wave['compileSeconds']:.1f}"]
        row += [f"{wave['firstPathSeconds']:.2f}", f"{wave['firstPictureSeconds']:.1f}"]
        row += [f"{mega['compileSeconds']:.1f}", f"{mega['firstPictureCpuSeconds']:.1f}"] if mega else ["–", "–"]
        rows.append(row)
    return table(head, rows)


def all_kernels(scene: Mapping[str, Any], most: int = 12) -> str:
    """Each kernel's share of the wavefront time, the largest first."""
    names = [
        [
            k["name"][:60],
            f"{k['share'] * 100:.1f} %",
            f"{k['milliseconds'] * 1e6 / k['items']:.0f}" if k["items"] else "–",
        ]
        for k in scene["wavefront"]["kernels"]
    ]
    rest = len(names) - most
    text = table([f"{scene['name']}: kernel", "share", "ns an item"], names[:most])
    return text + (f"\nand {rest} more kernels" if rest > 0 else "")


def peer_table(rows: Sequence[Mapping[str, Any]]) -> str:
    """Of bench/peers/compare.py; more than 1 in the last column is in our favour."""
    body = []
    for row in rows:
        peer = row["peer"] + (f" {row['variant']}" if row["peer"] == "mitsuba" else "")
        ours, theirs = row["ours"], row["theirs"]
        if row["peer"] == "embree":
            of = f"{row['kind']}, {row['triangles']:,} triangles"
            cells = [of, f"{ours:.2f} Mrays/s", f"{theirs:.2f} Mrays/s"]
        else:
            cells = [f"{ours['samples']} samples", *(_noise(r) for r in (ours, theirs))]
        body.append([row["scene"], peer, *cells, f"{row['ratio']:.2f}"])
    return table(["scene", "peer", "of", "ours, of a core", "theirs, of a core", "ours / theirs"], body)


def _noise(side: Mapping[str, Any]) -> str:
    return f"{number(side['efficiency'])} (relMSE {number(side['relMse'])}, {number(side['cpuSeconds'])} s)"
