# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""What pattern nodes give, on numpy arrays in double precision.

Nodes that the library defines by a graph are evaluated through that graph, by MaterialX's own Python module; the others
have a function here or in image_reference, by category, written from MaterialX's specification. Values are
(points, components) arrays, matrices (points, rows, columns) for row vectors, texts are str.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import image_reference  # noqa: F401  its functions register themselves
import MaterialX as mx
import noise_reference as noise
import numpy as np
from reference_table import LEAVES, Array, Inputs, blend, divide, dot, join, leaf, mix, normalize, simple, wide

simple("add", lambda a, b: a + wide(b, a), "in1", "in2")
simple("subtract", lambda a, b: a - wide(b, a), "in1", "in2")
simple("multiply", lambda a, b: a @ b if b.ndim == 3 else a * b, "in1", "in2")
simple("divide", divide, "in1", "in2")
simple("modulo", lambda a, b: a - b * np.floor(a / b), "in1", "in2")
simple("power", lambda a, b: a**b, "in1", "in2")
simple("min", np.minimum, "in1", "in2")
simple("max", np.maximum, "in1", "in2")
simple("invert", lambda a, x: a - x, "amount", "in")
simple("mix", mix, "bg", "fg", "mix")
simple("clamp", lambda x, a, b: np.minimum(np.maximum(x, a), b), "in", "low", "high")
simple("atan2", np.arctan2, "iny", "inx")
for name, function in {
    "absval": np.abs, "floor": np.floor, "ceil": np.ceil, "round": np.round, "sign": np.sign, "sqrt": np.sqrt,
    "exp": np.exp, "ln": np.log, "sin": np.sin, "cos": np.cos, "tan": np.tan, "asin": np.arcsin, "acos": np.arccos,
    "fract": lambda x: x - np.floor(x), "normalize": normalize, "dot": lambda x: x, "determinant":
    lambda m: np.linalg.det(m)[:, None], "invertmatrix": np.linalg.inv, "transpose": lambda m: m.swapaxes(1, 2),
    "magnitude": lambda x: np.linalg.norm(x, axis=-1, keepdims=True), "not": lambda x: 1 - x,
}.items():  # fmt: skip
    simple(name, function, "in")
simple("constant", lambda x: x, "value")
simple("dotproduct", dot, "in1", "in2")
simple("crossproduct", np.cross, "in1", "in2")
simple("and", lambda a, b: np.minimum(a, b), "in1", "in2")
simple("or", np.maximum, "in1", "in2")
simple("roughness_anisotropy", lambda r, a: _anisotropic(r, a), "roughness", "anisotropy")


def _anisotropic(roughness: Array, anisotropy: Array) -> Array:
    alpha = np.clip(roughness**2, 1e-8, 1)
    aspect = np.sqrt(1 - np.clip(anisotropy, 0, 0.98))
    return join(np.minimum(alpha / aspect, 1), alpha * aspect)


@leaf("remap")
def remap(i: Inputs, d: Any, s: Any) -> Array:
    return i["outlow"] + (i["in"] - i["inlow"]) * (i["outhigh"] - i["outlow"]) / (i["inhigh"] - i["inlow"])


@leaf("smoothstep")
def smoothstep(i: Inputs, d: Any, s: Any) -> Array:
    t = np.clip((i["in"] - i["low"]) / (i["high"] - i["low"]), 0, 1)
    inside = t * t * (3 - 2 * t)  # where low is not below high: a step, high first
    return np.where(i["in"] >= i["high"], 1.0, np.where(i["in"] <= i["low"], 0.0, inside))


@leaf("ifgreater", "ifgreatereq", "ifequal")
def choose(i: Inputs, d: Any, s: Any) -> Array:
    compare = {"ifgreater": np.greater, "ifgreatereq": np.greater_equal, "ifequal": np.equal}[d.getNodeString()]
    condition = compare(i["value1"], i["value2"])
    if "in1" not in i:
        return condition.astype(float)
    return np.where(wide(condition, i["in1"]), i["in1"], i["in2"])


simple("combine2", join, "in1", "in2")
simple("combine3", join, "in1", "in2", "in3")
simple("combine4", join, "in1", "in2", "in3", "in4")
simple("convert", lambda x: x, "in")  # the others are graphs


@leaf("extract")
def extract(i: Inputs, d: Any, s: Any) -> Array:
    index = int(i["index"].flat[0])
    return i["in"][:, index] if i["in"].ndim == 3 else i["in"][:, index : index + 1]


@leaf("creatematrix")
def creatematrix(i: Inputs, d: Any, s: Any) -> Array:
    side = 3 if d.getActiveOutputs()[0].getType() == "matrix33" else 4
    rows = [i[f"in{k + 1}"] for k in range(side)]
    if rows[0].shape[1] < side:
        rows = [join(r, np.full((len(r), 1), float(k == 3))) for k, r in enumerate(rows)]
    return np.stack(np.broadcast_arrays(*rows), 1)


@leaf("transformmatrix")
def transformmatrix(i: Inputs, d: Any, s: Any) -> Array:
    vector, matrix = i["in"], i["mat"]
    count = vector.shape[1]
    if matrix.shape[1] > count:
        vector = join(vector, np.ones((len(vector), 1)))
    return (vector[:, None, :] @ matrix)[:, 0, :count]


@leaf("rotate2d")
def rotate2d(i: Inputs, d: Any, s: Any) -> Array:
    angle, x, y = np.radians(i["amount"]), i["in"][:, :1], i["in"][:, 1:]
    return join(np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x)


@leaf("rotate3d")
def rotate3d(i: Inputs, d: Any, s: Any) -> Array:
    """Rodrigues, for row vectors (the axis' other way round)."""
    axis, angle, v = normalize(i["axis"]), np.radians(i["amount"]), i["in"]
    return v * np.cos(angle) + np.cross(v, axis) * np.sin(angle) + axis * dot(axis, v) * (1 - np.cos(angle))


@leaf("normalmap")
def normalmap(i: Inputs, d: Any, s: Any) -> Array:
    scale = np.broadcast_to(i["scale"], (len(i["scale"]), 2))
    v = np.where((i["in"] == 0).all(-1, keepdims=True), [0.0, 0.0, 1.0], i["in"] * 2 - 1)
    return normalize(
        i["tangent"] * v[:, :1] * scale[:, :1] + i["bitangent"] * v[:, 1:2] * scale[:, 1:] + i["normal"] * v[:, 2:]
    )


# -- Colour


@leaf("luminance")
def luminance(i: Inputs, d: Any, s: Any) -> Array:
    value = np.repeat(dot(i["in"][:, :3], i["lumacoeffs"]), 3, 1)
    return join(value, i["in"][:, 3:])


@leaf("rgbtohsv")
def rgbtohsv(i: Inputs, d: Any, s: Any) -> Array:
    c = i["in"]
    r, g, b = c[:, 0], c[:, 1], c[:, 2]
    high, low = c[:, :3].max(1), c[:, :3].min(1)
    chroma = np.where(high > low, high - low, 1)
    h = np.where(r == high, (g - b) / chroma, np.where(g == high, 2 + (b - r) / chroma, 4 + (r - g) / chroma)) / 6
    saturation = np.where(high > 0, (high - low) / np.where(high > 0, high, 1), 0)
    hue = np.where(saturation > 0, np.where(h < 0, h + 1, h), 0)
    return join(np.stack([hue, saturation, high], 1), c[:, 3:])


@leaf("hsvtorgb")
def hsvtorgb(i: Inputs, d: Any, s: Any) -> Array:
    """The piecewise linear form: channel n is v - v s max(0, min(k, 4 - k, 1)), k = (n + 6 h) mod 6."""
    h, saturation, v = (i["in"][:, k : k + 1] for k in range(3))
    k = (np.array([5.0, 3.0, 1.0]) + 6 * h) % 6
    rgb = v - v * np.maximum(saturation, 0) * np.clip(np.minimum(k, 4 - k), 0, 1)
    return join(rgb, i["in"][:, 3:])


simple("premult", lambda c: join(c[:, :3] * c[:, 3:], c[:, 3:]), "in")
simple("unpremult", lambda c: join(c[:, :3] / c[:, 3:], c[:, 3:]), "in")
LEAVES["plus"] = lambda i, d, s: blend(i, i["bg"] + i["fg"])
LEAVES["minus"] = lambda i, d, s: blend(i, i["bg"] - i["fg"])
LEAVES["difference"] = lambda i, d, s: blend(i, np.abs(i["bg"] - i["fg"]))
LEAVES["burn"] = lambda i, d, s: blend(i, 1 - (1 - i["bg"]) / i["fg"])
LEAVES["dodge"] = lambda i, d, s: blend(i, i["bg"] / (1 - i["fg"]))
LEAVES["screen"] = lambda i, d, s: blend(i, 1 - (1 - i["fg"]) * (1 - i["bg"]))
LEAVES["in"] = lambda i, d, s: blend(i, i["fg"] * i["bg"][:, 3:])
LEAVES["out"] = lambda i, d, s: blend(i, i["fg"] * (1 - i["bg"][:, 3:]))
LEAVES["mask"] = lambda i, d, s: blend(i, i["bg"] * i["fg"][:, 3:])
LEAVES["over"] = lambda i, d, s: blend(i, i["fg"] + i["bg"] * (1 - i["fg"][:, 3:]))
simple("inside", lambda x, m: x * m, "in", "mask")
simple("outside", lambda x, m: x * (1 - m), "in", "mask")


@leaf("matte")
def matte(i: Inputs, d: Any, s: Any) -> Array:
    fg, bg, a = i["fg"], i["bg"], i["fg"][:, 3:]
    return blend(i, join(fg[:, :3] * a + bg[:, :3] * (1 - a), a + bg[:, 3:] * (1 - a)))


@leaf("disjointover")
def disjointover(i: Inputs, d: Any, s: Any) -> Array:
    """Porter and Duff (1984): the parts that the two cover do not meet as long as there is room."""
    fg, bg = i["fg"], i["bg"]
    total = fg[:, 3:] + bg[:, 3:]
    left = np.where(total <= 1, 1, (1 - fg[:, 3:]) / bg[:, 3:])
    return blend(i, join(fg[:, :3] + bg[:, :3] * left, np.minimum(total, 1)))


# -- Procedurals


@leaf("ramplr", "ramptb", "splitlr", "splittb")
def ramp(i: Inputs, d: Any, s: Any) -> Array:
    """v grows upwards, where "t" is. Steps are as sharp as the footprint, 0 here."""
    horizontal = d.getNodeString().endswith("lr")
    t = np.clip(i["texcoord"][:, :1] if horizontal else i["texcoord"][:, 1:], 0, 1)
    if "center" in i:
        t = (i["texcoord"][:, :1] if horizontal else i["texcoord"][:, 1:]) > i["center"]
    a, b = ("valuel", "valuer") if horizontal else ("valueb", "valuet")
    return mix(i[a], i[b], t)


def _place(i: Inputs) -> Array:
    return i["texcoord"] if "texcoord" in i else i["position"]


@leaf("noise2d", "noise3d")
def noises(i: Inputs, d: Any, s: Any) -> Array:
    p, channels = _place(i), np.shape(i["amplitude"])[1]
    shift = (19, 73) if p.shape[1] == 2 else (19, 73, 29)
    lanes = 3 if channels == 2 else channels
    return noise.wide(noise.perlin, p, lanes, shift)[:, :channels] * i["amplitude"] + i["pivot"]


@leaf("fractal2d", "fractal3d")
def fractals(i: Inputs, d: Any, s: Any) -> Array:
    p, channels = _place(i), np.shape(i["amplitude"])[1]
    shift = (19, 193) if p.shape[1] == 2 else (19, 193, 17)

    def one(at: Array, lanes: int) -> Array:
        return noise.fractal(at, lanes, int(i["octaves"].flat[0]), i["lacunarity"], i["diminish"])

    if channels == 2:  # two scalar ones, unlike noise2d
        return join(one(p, 1), one(p + np.array(shift), 1)) * i["amplitude"]
    return noise.wide(one, p, channels, shift) * i["amplitude"]


@leaf("cellnoise2d", "cellnoise3d")
def cellnoise(i: Inputs, d: Any, s: Any) -> Array:
    return noise.cell(_place(i))


@leaf("worleynoise2d", "worleynoise3d")
def worleynoise(i: Inputs, d: Any, s: Any) -> Array:
    kind = d.getActiveOutputs()[0].getType()
    channels = {"float": 1, "vector2": 2, "vector3": 3}[kind]
    return noise.worley(_place(i), channels, i["jitter"], int(i["style"].flat[0]))


@leaf("flake2d", "flake3d")
def flake(i: Inputs, d: Any, s: Any) -> dict[str, Array]:
    p = i["texcoord"] if "texcoord" in i else i["position"]
    p = p if p.shape[1] == 3 else join(p, np.zeros((1, 1)))
    found = noise.flakes(p / i["size"], i["coverage"])
    phi, xi = 2 * np.pi * found["random"][:, :1], found["random"][:, 1:2]
    tangent = i["roughness"] ** 2 * np.sqrt(xi / (1 - xi))  # GGX: Walter et al. (2007), equation 35
    sine = tangent / np.sqrt(1 + tangent**2)
    bent = i["tangent"] * np.cos(phi) * sine + i["bitangent"] * np.sin(phi) * sine
    bent = normalize(bent + i["normal"] * np.sqrt(1 - sine**2))
    there = found["there"]
    rand = np.where(there, found["random"][:, 2:], 0)
    return {
        "id": np.floor(rand * 16777215),
        "rand": rand,
        "presence": np.where(there, found["priority"], 0),
        "flakenormal": np.where(there, bent, i["normal"]),
    }


# -- Geometry; `s` is node_harness.scene()


def _world(i: Inputs) -> bool:
    return i.get("space", "object") == "world"


def _object_to(s: Any, v: Array, kind: str, inverse: bool = False) -> Array:
    m = s["toWorld"].astype(float)
    m = np.linalg.inv(m) if inverse else m
    if kind == "normal":
        return normalize(v @ np.linalg.inv(m[:3, :3]))
    return v @ m[:3, :3].T + (m[:3, 3] if kind == "point" else 0)


def frame(s: Any) -> tuple[Array, Array]:
    """Unit dP/du across the shading normal, and the direction of dP/dv across both."""
    e1, e2 = (s[k].astype(float) for k in ("edge1", "edge2"))
    a, b = ((s["stCorners"][:, k] - s["stCorners"][:, 0]).astype(float) for k in (1, 2))
    determinant = a[:, :1] * b[:, 1:] - a[:, 1:] * b[:, :1]
    t, bt = (e1 * b[:, 1:] - e2 * a[:, 1:]) / determinant, (e2 * a[:, :1] - e1 * b[:, :1]) / determinant
    n = s["normalWorld"].astype(float)
    t = normalize(t - n * dot(n, t))
    across = np.cross(n, t)
    return t, np.where(dot(across, bt) < 0, -across, across)


@leaf("position")
def position(i: Inputs, d: Any, s: Any) -> Array:
    return s["positionWorld" if _world(i) else "positionObject"].astype(float)


@leaf("normal")
def normal(i: Inputs, d: Any, s: Any) -> Array:
    n = s["normalWorld"].astype(float)
    return n if _world(i) else _object_to(s, n, "normal", True)


@leaf("tangent", "bitangent")
def tangent(i: Inputs, d: Any, s: Any) -> Array:
    v = frame(s)[d.getNodeString() == "bitangent"]
    return v if _world(i) else normalize(_object_to(s, v, "vector", True))


@leaf("viewdirection")
def viewdirection(i: Inputs, d: Any, s: Any) -> Array:
    v = -s["wo"].astype(float)
    return v if _world(i) else normalize(_object_to(s, v, "vector", True))


@leaf("transformpoint", "transformvector", "transformnormal")
def transform(i: Inputs, d: Any, s: Any) -> Array:
    source, target = (i[k] == "world" for k in ("fromspace", "tospace"))
    kind = d.getNodeString().removeprefix("transform")
    return i["in"] if source == target else _object_to(s, i["in"], kind, source)


GEOMPROPS: dict[str, Callable[[Any], Array]] = {
    "Pworld": lambda s: s["positionWorld"].astype(float),
    "Pobject": lambda s: s["positionObject"].astype(float),
    "Nworld": lambda s: s["normalWorld"].astype(float),
    "Nobject": lambda s: _object_to(s, s["normalWorld"].astype(float), "normal", True),
    "Tworld": lambda s: frame(s)[0],
    "Bworld": lambda s: frame(s)[1],
    "Tobject": lambda s: normalize(_object_to(s, frame(s)[0], "vector", True)),
    "Bobject": lambda s: normalize(_object_to(s, frame(s)[1], "vector", True)),
    "Vworld": lambda s: -s["wo"].astype(float),
    "UV0": lambda s: s["st"].astype(float),
}


@leaf("texcoord")
def texcoord(i: Inputs, d: Any, s: Any) -> Array:
    st = s["st"].astype(float) if not i["index"].any() else s["primvar"](f"st{int(i['index'].flat[0])}")
    return st if d.getActiveOutputs()[0].getType() == "vector2" else join(st, np.zeros((len(st), 1)))


@leaf("geomcolor")
def geomcolor(i: Inputs, d: Any, s: Any) -> Array:
    kind = d.getActiveOutputs()[0].getType()
    color = s["primvar"]("displayColor" if not i["index"].any() else f"displayColor{int(i['index'].flat[0])}")
    return {"float": color[:, :1], "color3": color, "color4": join(color, np.ones((1, 1)))}[kind]


@leaf("geompropvalue")
def geompropvalue(i: Inputs, d: Any, s: Any) -> Array:
    return s["primvar"](i["geomprop"]) if i["geomprop"] != "nowhere" else i["default"]


LEAVES["frame"] = lambda i, d, s: np.full((1, 1), s["frame"])
LEAVES["time"] = lambda i, d, s: np.full((1, 1), s["time"])

# -- Physics


@leaf("roughness_dual")
def roughness_dual(i: Inputs, d: Any, s: Any) -> Array:
    r = i["roughness"]
    return np.clip(np.where(r < 0, r[:, :1], r) ** 2, 1e-8, 1)


@leaf("artistic_ior")
def artistic_ior(i: Inputs, d: Any, s: Any) -> dict[str, Array]:
    """Gulbrandsen, "Artist Friendly Metallic Fresnel" (2014), equations 4 to 9."""
    r, g = np.clip(i["reflectivity"], 0, 0.99), i["edge_color"]
    n = g * (1 - r) / (1 + r) + (1 - g) * (1 + np.sqrt(r)) / (1 - np.sqrt(r))
    k2 = (r * (n + 1) ** 2 - (n - 1) ** 2) / (1 - r)
    return {"ior": n, "extinction": np.sqrt(np.maximum(k2, 0))}


@leaf("blackbody")
def blackbody(i: Inputs, d: Any, s: Any) -> Array:
    """Chromaticity: Kim et al., "Design of advanced color temperature control system" (2002); Y = 1, to Rec.709."""
    kelvin = np.clip(i["temperature"], 800, 25000)
    t = 1000 / kelvin
    x = np.where(
        kelvin < 4000,
        np.polyval([-0.2661239, -0.2343580, 0.8776956, 0.179910], t),
        np.polyval([-3.0258469, 2.1070379, 0.2226347, 0.240390], t),
    )
    low = np.polyval([-1.1063814, -1.34811020, 2.18555832, -0.20219683], x)
    middle = np.polyval([-0.9549476, -1.37418593, 2.09137015, -0.16748867], x)
    high = np.polyval([3.0817580, -5.87338670, 3.75112997, -0.37001483], x)
    y = np.where(kelvin < 2222, low, np.where(kelvin < 4000, middle, high))
    xyz = join(x / y, np.ones_like(x), (1 - x - y) / y)
    m = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]])
    return np.maximum(xyz @ m.T, 0)


@leaf("deon_hair_absorption_from_melanin")
def melanin(i: Inputs, d: Any, s: Any) -> Array:
    """D'Eon et al., "An Energy-Conserving Hair Reflectance Model" (2011)."""
    amount = -np.log(np.maximum(1 - i["melanin_concentration"], 1e-4))
    dark, red = amount * (1 - i["melanin_redness"]), amount * i["melanin_redness"]
    return np.maximum(-dark * np.log(i["eumelanin_color"]) - red * np.log(i["pheomelanin_color"]), 0)


@leaf("chiang_hair_absorption_from_color")
def hair_absorption(i: Inputs, d: Any, s: Any) -> Array:
    """Chiang et al., "A Practical and Controllable Hair and Fur Model" (2016), equation 9."""
    b = i["azimuthal_roughness"]
    return (np.log(np.clip(i["color"], 0.001, 1)) / np.polyval([0.245, 5.574, -10.73, 2.532, -0.215, 5.969], b)) ** 2


@leaf("chiang_hair_roughness")
def hair_roughness(i: Inputs, d: Any, s: Any) -> dict[str, Array]:
    """The same, equations 7 and 8."""
    m, n = (np.clip(i[k], 0.001, 1) for k in ("longitudinal", "azimuthal"))
    v = (0.726 * m + 0.812 * m**2 + 3.7 * m**20) ** 2
    a = 0.265 * n + 1.194 * n**2 + 5.372 * n**22
    both = {"R": v, "TT": v * i["scale_TT"] ** 2, "TRT": v * i["scale_TRT"] ** 2}
    return {f"roughness_{k}": join(x, a) for k, x in both.items()}


# -- Graphs


def parse(text: str, kind: str) -> Any:
    if kind in ("string", "filename"):
        return text
    if kind == "boolean":
        return np.array([[float(text == "true")]])
    numbers = np.array([[float(x) for x in text.split(",")]]) if text else np.zeros((1, 1))
    side = {"matrix33": 3, "matrix44": 4}.get(kind)
    return numbers.reshape(1, side, side) if side else numbers


def defaults(definition: Any, s: Any) -> Inputs:
    found: Inputs = {}
    for port in definition.getActiveInputs():
        geomprop = port.getDefaultGeomPropString()
        found[port.getName()] = GEOMPROPS[geomprop](s) if geomprop else parse(port.getValueString(), port.getType())
    return found


class NoReferenceError(Exception):
    """No reference for this node."""


def evaluate(definition: Any, inputs: Inputs, s: Any) -> dict[str, Array]:
    """All outputs of a node; `inputs` where they are not the defaults."""
    values = defaults(definition, s) | inputs
    outputs = definition.getActiveOutputs()
    function = LEAVES.get(definition.getNodeString())
    implementation = definition.getImplementation("genglsl")
    is_graph = implementation is not None and implementation.isA(mx.NodeGraph)
    if is_graph:
        graph = _Graph(implementation, values, s)
        return {o.getName(): graph.output(o.getName()) for o in outputs}
    if function is None:
        raise NoReferenceError(definition.getName())
    result = function(values, definition, s)
    return result if isinstance(result, dict) else {outputs[0].getName(): result}


class _Graph:
    def __init__(self, graph: Any, interface: Inputs, s: Any) -> None:
        self.graph, self.interface, self.s = graph, interface, s
        self.known: dict[str, dict[str, Array]] = {}

    def output(self, name: str) -> Array:
        output = self.graph.getOutput(name)
        return self.node(output.getNodeName(), output.getOutputString())

    def node(self, name: str, output: str) -> Array:
        if name not in self.known:
            node = self.graph.getNode(name)
            definition = node.getNodeDef("genglsl")
            inputs: Inputs = {}
            for port in node.getInputs():
                if port.getNodeName():
                    inputs[port.getName()] = self.node(port.getNodeName(), port.getOutputString())
                elif port.getInterfaceName():
                    inputs[port.getName()] = self.interface[port.getInterfaceName()]
                else:
                    inputs[port.getName()] = parse(port.getValueString(), port.getType())
            with np.errstate(all="ignore"):
                self.known[name] = evaluate(definition, inputs, self.s)
        found = self.known[name]
        return found[output] if output else next(iter(found.values()))
