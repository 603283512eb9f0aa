# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What Laine, Karras and Aila measured ("Megakernels Considered Harmful", HPG 2013; GeForce GTX 680)."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PaperScene:
    title: str
    triangles: int
    megakernel: float  # Mpaths/s
    wavefront: float
    milliseconds: dict[str, float]  # of a million segments, by group of kernels

    @property
    def gain(self) -> float:
        return self.wavefront / self.megakernel - 1

    @property
    def segments_per_path(self) -> float:
        """Of what stands in both tables: the time of a million paths over that of a million segments."""
        return 1e3 / self.wavefront / sum(self.milliseconds.values())


PAPER = {
    "carpaint": PaperScene(
        "CARPAINT", 9_500, 42.99, 58.38, {"logic": 2.40, "new path": 0.86, "materials": 2.31, "rays": 4.31}
    ),
    "city": PaperScene(
        "CITY", 879_000, 5.41, 9.70, {"logic": 3.42, "new path": 0.86, "materials": 5.47, "rays": 12.53}
    ),
    "conference": PaperScene(
        "CONFERENCE", 283_000, 2.71, 8.71, {"logic": 3.01, "new path": 0.79, "materials": 6.37, "rays": 9.62}
    ),
}
