# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What each pattern node is tried with: values within its domain, and every choice that it offers."""

from __future__ import annotations

from itertools import product
from typing import Any

from node_harness import COMPONENTS, Case, Varying, pattern_definitions

# Pools (node_harness.POOLS) of inputs, by "category.input" or "input"; other numbers come from "any".
DOMAINS = {
    "in2": {"divide": "nonzero", "modulo": "nonzero"},
    "in1": {"power": "positive"},
    "in": {
        "sqrt": "positive", "ln": "positive", "asin": "cosine", "acos": "cosine", "unpremult": "positive",
        "rgbtohsv": "unit", "hsvtorgb": "unit", "hsvadjust": "unit", "saturate": "unit", "colorcorrect": "unit",
        "contrast": "unit", "range": "unit", "g18_rec709_to_lin_rec709": "unit",
    },
    "low": {"": "low"}, "high": {"": "high"}, "inlow": {"": "low"}, "inhigh": {"": "high"},
    "gamma": {"": "positive"}, "texcoord": {"": "far", "ramplr": "any", "ramptb": "any"},
    "position": {"": "far"}, "amount": {"rotate2d": "degrees", "rotate3d": "degrees", "": "any"},
    "fg": {"burn": "positive", "dodge": "low", "disjointover": "unit"}, "bg": {"disjointover": "unit"},
    "scale": {"place2d": "nonzero", "UsdTransform2d": "nonzero"}, "rotate": {"": "degrees"},
    "rotation": {"UsdTransform2d": "degrees"}, "which": {"": "index"}, "temperature": {"": "kelvin"},
    "reflectivity": {"": "unit"}, "edge_color": {"": "unit"}, "melanin_concentration": {"": "unit"},
    "melanin_redness": {"": "unit"}, "eumelanin_color": {"": "unit"}, "pheomelanin_color": {"": "unit"},
    "azimuthal_roughness": {"": "unit"}, "color": {"chiang_hair_absorption_from_color": "unit"},
    "longitudinal": {"": "unit"}, "azimuthal": {"": "unit"}, "roughness": {"roughness_dual": "any", "": "unit"},
    "anisotropy": {"": "unit"}, "glossiness": {"": "unit"}, "jitter": {"": "unit"}, "size": {"": "positive"},
    "coverage": {"": "unit"}, "normal": {"": "axis"}, "tangent": {"": "axis"}, "bitangent": {"": "axis"},
    "viewdirection": {"": "axis"}, "viewdir": {"": "axis"}, "axis": {"": "axis"}, "ior": {"": "positive"},
    "freq": {"": "unit"}, "outmin": {"": "unit"}, "outmax": {"": "unit"}, "diminish": {"": "unit"},
    "lacunarity": {"": "positive"},
}  # fmt: skip

# Inputs that choose, with the choices that are tried; every combination for each node.
CHOICES: dict[str, dict[str, list[Any]]] = {
    "texcoord": {"index": [0, 1]},
    "geomcolor": {"index": [0, 2]},
    "worleynoise2d": {"style": [0, 1]},
    "worleynoise3d": {"style": [0, 1]},
    "fractal2d": {"octaves": [1, 3]},
    "fractal3d": {"octaves": [1, 3]},
    "unifiednoise2d": {"type": [0, 1, 2, 3], "style": [0, 1], "octaves": [3], "jitter": [0.9999]},
    "unifiednoise3d": {"type": [0, 1, 2, 3], "style": [0, 1], "octaves": [3], "jitter": [0.9999]},
    "place2d": {"operationorder": [0, 1]},
    "ramp": {"type": [0, 1, 2, 3], "interpolation": [0, 1, 2]},
    "ramp_gradient": {"interpolation": [0, 1, 2]},
    "range": {"doclamp": [False, True]},
    "position": {"space": ["object", "world"]},
    "normal": {"space": ["object", "world"]},
    "tangent": {"space": ["object", "world"]},
    "bitangent": {"space": ["object", "world"]},
    "viewdirection": {"space": ["object", "world"]},
    "randomcolor": {"seed": [0, 7]},
    "hextiledimage": {"falloff": [0.5, 0.7], "rotationrange": [(0.0, 300.0)], "scalerange": [(0.5, 2.0)]},
    "hextilednormalmap": {"flip_g": [False, True], "rotationrange": [(0.0, 300.0)], "scalerange": [(0.5, 2.0)]},
    "image": {"uaddressmode": ["constant", "clamp", "periodic", "mirror"]},
}
for _name in ("transformpoint", "transformvector", "transformnormal"):
    CHOICES[_name] = {"fromspace": ["object", "world"], "tospace": ["object", "world"]}
for _name in ("line", "circle", "cloverleaf", "hexagon", "grid", "crosshatch"):
    CHOICES[_name] = {}
for _name in ("tiledcircles", "tiledcloverleafs", "tiledhexagons", "grid", "crosshatch"):
    CHOICES[_name] = {"staggered": [False, True]}

# Nodes whose inputs stay at their defaults but for these: thresholds that random numbers would make meaningless.
ONLY: dict[str, set[str]] = {
    "checkerboard": {"texcoord", "color1", "color2"},
    # Tangents follow the texture coordinates: those of the triangle, then.
    "gltf_normalmap": {"default", "pivot", "scale", "rotate", "offset"},
    "line": {"texcoord"},
    "circle": {"texcoord"},
    "cloverleaf": {"texcoord"},
    "hexagon": {"texcoord"},
    "grid": {"texcoord"},
    "crosshatch": {"texcoord"},
    "tiledcircles": {"texcoord"},
    "tiledcloverleafs": {"texcoord"},
    "tiledhexagons": {"texcoord"},
}


# Nodes that take what surfaces take.
UNIT = {"gooch_shade", "randomcolor", "standard_surface_to_gltf_pbr", "standard_surface_to_UsdPreviewSurface"}
UNIT |= {"hextiledimage", "hextilednormalmap", "gltf_anisotropy_image", "gltf_iridescence_thickness"}
UNIT |= {"standard_surface_to_open_pbr_surface", "open_pbr_surface_to_standard_surface", "open_pbr_anisotropy"}


def _domain(category: str, name: str, kind: str) -> str:
    if kind in ("integer", "boolean"):
        return "whole" if kind == "integer" else "truth"
    if category in UNIT and name not in ("normal", "tangent", "bitangent", "viewdirection", "texcoord"):
        return "unit"
    rows = DOMAINS.get(name, {})
    return rows.get(category, rows.get("", "any"))


# Files by category: what a file's texels stand for.
FILES = {"hextilednormalmap": "normals", "gltf_normalmap": "normals", "gltf_anisotropy_image": "normals"}


def _base(definition: Any, choices: dict[str, Any]) -> dict[str, Any]:
    category = definition.getNodeString()
    inputs: dict[str, Any] = {}
    used: dict[tuple[str, int], int] = {}
    for port in definition.getActiveInputs():
        name, kind = port.getName(), port.getType()
        if kind == "filename":
            inputs[name] = FILES.get(category, "smooth")
        elif name in choices:
            inputs[name] = choices[name]
        elif kind in COMPONENTS and not port.getIsUniform() and not port.hasAttribute("enum"):
            if category in ONLY and name not in ONLY[category]:
                continue
            domain = _domain(category, name, kind)
            slot = used.setdefault((domain, COMPONENTS[kind]), 0)
            used[(domain, COMPONENTS[kind])] += 1
            inputs[name] = Varying(domain, slot, kind)
    return inputs


def _authored(inputs: dict[str, Any]) -> dict[str, Any]:
    """The first point's values, as a user would write them."""
    found: dict[str, Any] = {}
    for name, value in inputs.items():
        if isinstance(value, Varying):
            first = value.values()[0].ravel().tolist()
            if value.type in ("boolean", "integer"):
                value = bool(first[0]) if value.type == "boolean" else int(first[0])
            else:
                value = float(first[0]) if len(first) == 1 else tuple(first)
        found[name] = value
    return found


def cases_of(definition: Any) -> list[Case]:
    category = definition.getNodeString()
    names = {p.getName() for p in definition.getActiveInputs()}
    offered = {k: v for k, v in CHOICES.get(category, {}).items() if k in names}
    if category == "extract":
        count = {"matrix33": 3, "matrix44": 4}.get(definition.getActiveInputs()[0].getType(), 0)
        offered = {"index": list(range(count or COMPONENTS[definition.getActiveInputs()[0].getType()]))}
    if category in ("geompropvalue", "UsdPrimvarReader"):
        kind = definition.getActiveOutputs()[0].getType()
        domain = {"integer": "whole", "boolean": "truth"}.get(kind, "any")
        if kind in COMPONENTS:
            name = "geomprop" if category == "geompropvalue" else "varname"
            offered = {name: [f"real_{domain}_0_{COMPONENTS[kind]}", "nowhere"]}
    found = []
    for values in product(*offered.values()):
        choices = dict(zip(offered, values, strict=True))
        inputs = _base(definition, choices)
        found.append(Case(definition, inputs, f"varying {choices or ''}"))
        if any(isinstance(v, Varying) for v in inputs.values()):
            found.append(Case(definition, _authored(inputs), f"authored {choices or ''}"))
    for kind in ("closest", "cubic") if category == "image" else ():
        filtered = {"filtertype": kind, "uaddressmode": "mirror"}
        found.append(Case(definition, _base(definition, filtered), f"varying {filtered}"))
    return found


# Texts that a primvar would have to give: a kernel cannot choose files or names by them.
TEXT_READERS = {
    "ND_geompropvalueuniform_string": "a text read from a primvar is not supported",
    "ND_geompropvalueuniform_filename": "a text read from a primvar is not supported",
    "ND_UsdPrimvarReader_string": "a text read from a primvar is not supported",
    "ND_UsdPrimvarReader_filename": "a text read from a primvar is not supported",
}
# Nodes with tests of their own: what they give lies in how they are connected.
TEXTS = {f"ND_{node}_{kind}" for node in ("constant", "dot") for kind in ("string", "filename")}
HEIGHTS = {"ND_heighttonormal_vector3", "ND_bump_vector3"}


def reads_file(definition: Any) -> bool:
    return any(p.getType() == "filename" for p in definition.getActiveInputs()) and not is_text(definition)


def is_text(definition: Any) -> bool:
    return definition.getName() in TEXTS or definition.getName() in TEXT_READERS


def plain_definitions() -> list[Any]:
    """Those that the table of cases tries."""
    special = HEIGHTS | TEXTS | set(TEXT_READERS)
    return [d for d in pattern_definitions() if d.getName() not in special and not reads_file(d)]
