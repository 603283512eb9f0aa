# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""Values with a unit become what nodes compute in: the unit that an input's definition names, else scene units for
distances, degrees for angles. A value without a unit is taken as it is (MaterialX specification, "Units").
"""

from __future__ import annotations

from typing import Any


class Units:
    """The units that a document knows, its own included."""

    def __init__(self, document: Any, library: Any, meters_per_unit: float) -> None:
        self._scales = {
            (definition.getAttribute("unittype"), unit.getName()): float(unit.getAttribute("scale"))
            for source in (library, document)
            for definition in source.getUnitDefs()
            for unit in definition.getUnits()
        }
        # Scales of the library are meters and degrees.
        self._targets = {"distance": meters_per_unit, "angle": 1.0}

    def factor(self, element: Any, port: Any) -> float | None:
        """By what a value of an input is multiplied; None where nothing is known about its unit."""
        unit = port.getUnit()
        if not unit:
            return 1.0
        definition = element.getNodeDef() if element.getCategory() != "nodegraph" else None
        declared = definition.getActiveInput(port.getName()) if definition is not None else None
        kind = port.getUnitType() or (declared.getUnitType() if declared is not None else "")
        if not kind:
            kind = next((k for k, name in self._scales if name == unit), "")
        scale = self._scales.get((kind, unit))
        native = declared.getUnit() if declared is not None else ""
        target = self._scales.get((kind, native)) if native else self._targets.get(kind)
        return scale / target if scale is not None and target else None
