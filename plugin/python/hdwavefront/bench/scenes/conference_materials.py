# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The 40 materials of CONFERENCE: layered lobes over procedural patterns, in kinds that make kernels of their own."""

from __future__ import annotations

from collections.abc import Callable

from .builder import NetworkMaker
from .materials import Network, Output, Vector

Color = tuple[float, float, float]


def wood(dark: Color, light: Color, along: int, coat: float = 0.0) -> NetworkMaker:
    """Rings about an axis, bent by noise; lacquered where there is a coat."""

    def make(n: Network) -> None:
        stretch = [9.0, 9.0, 9.0]
        stretch[along] = 0.6
        p = n.position(Vector(*stretch))
        warp = n.fractal(p, octaves=3)
        grain = n.fractal(n.node("multiply_vector3FA", in1=p, in2=7.0), octaves=2)
        across = n.node("extract_vector3", in_=p, index=(along + 1) % 3)
        wave = n.node("multiply_float", in1=n.node("add_float", in1=across, in2=warp), in2=6.2832)
        ring = n.node("multiply_float", in1=n.node("sin_float", in_=wave), in2=0.5)
        amount = n.clamped(n.node("add_float", in1=ring, in2=n.mixed_float(0.2, 0.8, grain)))
        layers = {"coat": coat, "coat_roughness": 0.06} if coat else {}
        n.standard_surface(
            base_color=n.mixed(dark, light, amount),
            specular=0.5,
            specular_roughness=n.mixed_float(0.25, 0.5, grain),
            **layers,
        )

    return make


def fabric(low: Color, high: Color, scale: float) -> NetworkMaker:
    """Sheen over a rough weave."""

    def make(n: Network) -> None:
        p = n.position(scale)
        thread = n.node("cellnoise3d_float", position=p)
        weave = n.node("multiply_float", in1=n.fractal(n.position(scale * 0.3), octaves=3), in2=thread)
        fibre = n.node("oren_nayar_diffuse_bsdf", color=n.mixed(low, high, weave), roughness=0.8)
        fuzz = n.node("sheen_bsdf", color=high, roughness=n.mixed_float(0.25, 0.5, thread), weight=0.7)
        n.surface(n.node("surface", bsdf=n.node("layer_bsdf", top=fuzz, base=fibre)))

    return make


def leather(low: Color, high: Color) -> NetworkMaker:
    def make(n: Network) -> None:
        crease = n.node("worleynoise3d_float", position=n.position(55.0))
        large = n.fractal(n.position(6.0), octaves=3)
        n.standard_surface(
            base_color=n.mixed(low, high, n.node("multiply_float", in1=crease, in2=large)),
            specular=0.6,
            specular_roughness=n.mixed_float(0.55, 0.3, crease),
            coat=0.25,
            coat_roughness=0.2,
            sheen=0.15,
        )

    return make


def paint(low: Color, high: Color, scale: float) -> NetworkMaker:
    def make(n: Network) -> None:
        rolled = n.fractal(n.position(scale), octaves=4)
        n.standard_surface(
            base_color=n.mixed(low, high, rolled),
            diffuse_roughness=0.5,
            specular=0.3,
            specular_roughness=n.mixed_float(0.5, 0.8, rolled),
        )

    return make


def metal(color: Color, edge: Color, rough: tuple[float, float], stretch: Vector) -> NetworkMaker:
    def make(n: Network) -> None:
        scratch = n.fractal(n.position(stretch), octaves=3)
        roughness = n.mixed_float(rough[0], rough[1], scratch)
        n.standard_surface(
            metalness=1.0, base=1.0, base_color=color, specular_color=edge, specular_roughness=roughness, coat=0.1
        )

    return make


def plastic(low: Color, high: Color) -> NetworkMaker:
    def make(n: Network) -> None:
        cell = n.node("worleynoise3d_float", position=n.position(120.0))
        n.standard_surface(
            base_color=n.mixed(low, high, cell),
            specular=0.7,
            specular_roughness=n.mixed_float(0.2, 0.4, cell),
            coat=0.3,
        )

    return make


def glazed(low: Color, high: Color) -> NetworkMaker:
    """Porcelain and lacquer: a hard coat over a patterned body."""

    def make(n: Network) -> None:
        body = n.fractal(n.position(14.0), octaves=4)
        under = n.node("oren_nayar_diffuse_bsdf", color=n.mixed(low, high, n.smoothstep(body, 0.4, 0.6)), roughness=0.2)
        rough = n.mixed_float(0.01, 0.05, body)
        gloss = n.node("dielectric_bsdf", ior=1.52, roughness=n.node("combine2_vector2", in1=rough, in2=rough))
        n.surface(n.node("surface", bsdf=n.node("layer_bsdf", top=gloss, base=under)))

    return make


def stone(low: Color, high: Color, vein: Color) -> NetworkMaker:
    def make(n: Network) -> None:
        p = n.position(3.0)
        warp = n.node("multiply_float", in1=n.fractal(p, octaves=5), in2=9.0)
        across = n.node("extract_vector3", in_=p, index=0)
        wave = n.node("sin_float", in_=n.node("add_float", in1=across, in2=warp))
        line = n.smoothstep(n.node("absval_float", in_=wave), 0.0, 0.25)
        cloud = n.fractal(n.position(1.3), octaves=3)
        n.standard_surface(
            base_color=n.mixed(vein, n.mixed(low, high, cloud), line), specular=0.8, specular_roughness=0.12, coat=0.5
        )

    return make


def foliage(low: Color, high: Color) -> NetworkMaker:
    def make(n: Network) -> None:
        vein = n.fractal(n.position(12.0), octaves=3)
        color = n.mixed(low, high, vein)
        body = n.node(
            "mix_bsdf",
            fg=n.node("translucent_bsdf", color=color),
            bg=n.node("burley_diffuse_bsdf", color=color),
            mix=0.3,
        )
        wax = n.node("dielectric_bsdf", ior=1.4, roughness=(0.12, 0.12))
        n.surface(n.node("surface", bsdf=n.node("layer_bsdf", top=wax, base=body)))

    return make


def painting(first: Color, second: Color, third: Color) -> NetworkMaker:
    """An abstract one, varnished."""

    def make(n: Network) -> None:
        field = n.node("unifiednoise3d_float", position=n.position(3.2), type=2, jitter=0.9)
        strokes = n.fractal(n.position(Vector(18.0, 4.0, 4.0)), octaves=3)
        color = n.mixed(n.mixed(first, second, n.smoothstep(field, 0.2, 0.5)), third, n.smoothstep(strokes, 0.5, 0.62))
        n.standard_surface(
            base_color=color, specular_roughness=0.45, coat=0.6, coat_roughness=n.mixed_float(0.05, 0.2, strokes)
        )

    return make


def clear_glass(n: Network) -> None:
    n.standard_surface(base=0.0, specular=1.0, specular_roughness=0.0, transmission=1.0)


def tiles(low: Color, high: Color, joint: Color, scale: float) -> NetworkMaker:
    def make(n: Network) -> None:
        p = n.position(scale)
        holes = n.node("worleynoise3d_float", position=n.node("multiply_vector3FA", in1=p, in2=26.0))
        x = _edge(n, p, 0)
        z = _edge(n, p, 2)
        flat = n.mixed(low, high, n.smoothstep(holes, 0.12, 0.3))
        n.standard_surface(
            base_color=n.mixed(flat, joint, n.node("max_float", in1=x, in2=z)),
            specular=0.1,
            specular_roughness=0.8,
            diffuse_roughness=0.6,
        )

    return make


def _edge(n: Network, position: Output, index: int) -> Output:
    place = n.node("modulo_float", in1=n.node("extract_vector3", in_=position, index=index), in2=1.0)
    return n.node("ifgreater_float", value1=place, value2=0.985, in1=1.0, in2=0.0)


MATERIALS: dict[str, Callable[[Network], None]] = {
    "WallWhite": paint((0.74, 0.73, 0.7), (0.82, 0.81, 0.79), 9.0),
    "WallWarm": paint((0.68, 0.58, 0.44), (0.76, 0.67, 0.53), 9.0),
    "WallBlue": paint((0.26, 0.36, 0.45), (0.34, 0.45, 0.54), 9.0),
    "CeilingTiles": tiles((0.5, 0.5, 0.49), (0.84, 0.84, 0.83), (0.35, 0.35, 0.35), 1.667),
    "Carpet": fabric((0.07, 0.085, 0.12), (0.2, 0.23, 0.3), 90.0),
    "PanelFelt": fabric((0.3, 0.3, 0.31), (0.52, 0.52, 0.53), 140.0),
    "SkirtingOak": wood((0.3, 0.18, 0.08), (0.5, 0.33, 0.17), 2),
    "TableWalnut": wood((0.1, 0.045, 0.02), (0.34, 0.17, 0.08), 2, coat=0.8),
    "DoorOak": wood((0.32, 0.19, 0.09), (0.56, 0.38, 0.2), 1),
    "LeatherBlack": leather((0.01, 0.01, 0.01), (0.045, 0.042, 0.04)),
    "LeatherBrown": leather((0.09, 0.035, 0.015), (0.26, 0.12, 0.06)),
    "FabricRed": fabric((0.24, 0.02, 0.02), (0.58, 0.08, 0.06), 160.0),
    "FabricGreen": fabric((0.02, 0.1, 0.05), (0.1, 0.3, 0.16), 160.0),
    "FabricGrey": fabric((0.12, 0.12, 0.13), (0.36, 0.36, 0.38), 160.0),
    "PlasticBlack": plastic((0.012, 0.012, 0.012), (0.04, 0.04, 0.04)),
    "Chrome": metal((0.75, 0.76, 0.77), (1.0, 1.0, 1.0), (0.03, 0.14), Vector(30.0, 30.0, 30.0)),
    "BrushedSteel": metal((0.52, 0.52, 0.53), (0.9, 0.92, 0.95), (0.22, 0.42), Vector(4.0, 160.0, 4.0)),
    "Brass": metal((0.86, 0.64, 0.24), (1.0, 0.95, 0.8), (0.08, 0.25), Vector(25.0, 25.0, 25.0)),
    "Copper": metal((0.9, 0.45, 0.3), (1.0, 0.85, 0.75), (0.1, 0.35), Vector(18.0, 18.0, 18.0)),
    "AnodisedGrey": metal((0.28, 0.29, 0.31), (0.7, 0.72, 0.75), (0.28, 0.38), Vector(60.0, 60.0, 60.0)),
    "PorcelainWhite": glazed((0.72, 0.71, 0.69), (0.86, 0.85, 0.83)),
    "PorcelainBlue": glazed((0.82, 0.82, 0.82), (0.05, 0.12, 0.42)),
    "LacquerRed": glazed((0.5, 0.03, 0.02), (0.72, 0.1, 0.05)),
    "Coffee": plastic((0.02, 0.008, 0.003), (0.05, 0.02, 0.01)),
    "BinderRed": plastic((0.4, 0.03, 0.03), (0.6, 0.07, 0.06)),
    "BinderBlue": plastic((0.02, 0.06, 0.3), (0.05, 0.14, 0.5)),
    "BinderGreen": plastic((0.02, 0.2, 0.06), (0.06, 0.36, 0.13)),
    "Paper": paint((0.8, 0.79, 0.76), (0.87, 0.86, 0.84), 60.0),
    "GlassClear": clear_glass,
    "ScreenMatte": paint((0.76, 0.77, 0.78), (0.82, 0.83, 0.84), 30.0),
    "CabinetWhite": glazed((0.74, 0.73, 0.71), (0.8, 0.79, 0.77)),
    "Leaf": foliage((0.03, 0.13, 0.02), (0.12, 0.32, 0.06)),
    "LeafDark": foliage((0.015, 0.07, 0.02), (0.06, 0.2, 0.06)),
    "PotTerracotta": stone((0.42, 0.17, 0.09), (0.56, 0.26, 0.15), (0.36, 0.14, 0.08)),
    "PotStone": stone((0.2, 0.2, 0.2), (0.38, 0.37, 0.36), (0.1, 0.1, 0.1)),
    "Marble": stone((0.7, 0.7, 0.68), (0.85, 0.85, 0.83), (0.16, 0.15, 0.15)),
    "CurtainLinen": fabric((0.56, 0.5, 0.4), (0.74, 0.68, 0.56), 110.0),
    "CurtainVelvet": fabric((0.2, 0.03, 0.06), (0.42, 0.07, 0.12), 110.0),
    "PaintingA": painting((0.75, 0.6, 0.2), (0.7, 0.2, 0.1), (0.1, 0.12, 0.2)),
    "PaintingB": painting((0.2, 0.35, 0.5), (0.8, 0.78, 0.7), (0.6, 0.3, 0.1)),
}
