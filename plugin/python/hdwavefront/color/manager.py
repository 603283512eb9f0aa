# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The colour configuration and what is asked of it.

The rendering space is scene-linear: by default lin_rec709, or any space that the configuration or OpenColorIO's
built-in one knows. Names are looked up in the configuration first, then in the built-in one, so that USD's names (raw,
sRGB, lin_rec709_scene, ...) mean the same with every configuration.
"""

from __future__ import annotations

import os
from functools import lru_cache
from typing import Any

import numpy as np

from ..errors import HdWavefrontError, UsageError

DEFAULT_CONFIG = "cg-config-v2.2.0_aces-v1.3_ocio-v2.4"
DEFAULT_RENDERING_SPACE = "lin_rec709"

# What other programs and USD's documentation call spaces that OpenColorIO's configurations name otherwise.
_ALIASES = {
    "srgb": "srgb_texture",
    "srgb_texture": "srgb_texture",
    "srgb_rec709_scene": "srgb_texture",
    "linear": "lin_rec709",
    "lin_srgb": "lin_rec709",
    "lin_rec709_scene": "lin_rec709",
    "lin_ap1_scene": "lin_ap1",
    "acescg": "lin_ap1",
    "lin_p3d65_scene": "lin_p3d65",
    "lin_rec2020_scene": "lin_rec2020",
    "g22_rec709_scene": "g22_rec709",
    "g18_rec709_scene": "g18_rec709",
    "lin_displayp3": "lin_p3d65",
    "lin_adobergb_scene": "lin_adobergb",
}
_DATA_NAMES = frozenset({"raw", "data", "none", "identity", "unknown", "utility - raw", "non-color"})


def _ocio() -> Any:
    import PyOpenColorIO

    PyOpenColorIO.SetLoggingLevel(PyOpenColorIO.LOGGING_LEVEL_WARNING)
    return PyOpenColorIO


class ColorManager:
    """`config`: a file, or a built-in configuration's name; empty: $OCIO, else the default built-in one."""

    def __init__(self, config: str = "", rendering_space: str = DEFAULT_RENDERING_SPACE) -> None:
        self._ocio = _ocio()
        self._source = config or os.environ.get("OCIO", "")
        self.origin = "--ocio" if config else "$OCIO" if self._source else "built in"
        self.config_name = self._source or DEFAULT_CONFIG
        self._config = self._load(self._source)
        self._builtin = self._config if not self._source else self._ocio.Config.CreateFromBuiltinConfig(DEFAULT_CONFIG)
        self.rendering_space = rendering_space
        try:
            self._find(rendering_space)
        except LookupError:
            raise UsageError(
                f"The rendering colour space '{rendering_space}' is neither in {self.config_name} nor in OpenColorIO's "
                "built-in configuration."
            ) from None
        self._processors: dict[tuple[str, str], Any] = {}

    def _load(self, source: str) -> Any:
        ocio = self._ocio
        try:
            if not source:
                return ocio.Config.CreateFromBuiltinConfig(DEFAULT_CONFIG)
            builtin = [entry[0] for entry in ocio.BuiltinConfigRegistry().getBuiltinConfigs()]
            if source in builtin:
                return ocio.Config.CreateFromBuiltinConfig(source)
            return ocio.Config.CreateFromFile(source)
        except (ocio.Exception, ocio.ExceptionMissingFile) as error:
            where = "named by --ocio" if self.origin == "--ocio" else "named by $OCIO"
            reason = str(error).splitlines()[0]
            raise HdWavefrontError(
                f"The OpenColorIO configuration {source} ({where}) cannot be read: {reason}"
            ) from None

    # -- Names

    def _find(self, name: str) -> tuple[Any, str]:
        """(configuration, canonical name); LookupError where nobody knows the name."""
        alias = _ALIASES.get(name.lower(), name)
        for config in (self._config, self._builtin):
            for candidate in (name, alias):
                space = config.getColorSpace(candidate)
                if space:
                    return config, space.getName()
        raise LookupError(name)

    def is_data(self, name: str) -> bool:
        """True for spaces whose values are numbers, not colours."""
        if name.lower() in _DATA_NAMES:
            return True
        try:
            config, canonical = self._find(name)
        except LookupError:
            return False
        return bool(config.getColorSpace(canonical).isData())

    def knows(self, name: str) -> bool:
        try:
            self._find(name)
        except LookupError:
            return name.lower() in _DATA_NAMES
        return True

    # -- Into the rendering space

    def to_rendering(self, source: str) -> Any | None:
        """An OCIO CPU processor from `source`; None where nothing is to be done. LookupError: unknown space."""
        return self._cpu(source, self.rendering_space)

    def unconverted_names(self) -> list[str]:
        """Names of the rendering space and of data that are in use: `to_rendering` has nothing to do for them."""
        config, canonical = here = self._find(self.rendering_space)
        names = {*_ALIASES, self.rendering_space, canonical, *config.getColorSpace(canonical).getAliases()}
        return sorted(_DATA_NAMES | {n for n in names if self.knows(n) and self._find(n) == here})

    def _cpu(self, source: str, target: str) -> Any | None:
        key = (source, target)
        if key not in self._processors:
            processor = None
            if source and not self.is_data(source) and not self.is_data(target):
                full = self._between(source, target)
                # Without the fast power, which is off by 2e-5: textures would be others than the Hydra plugin's.
                exact = ~int(self._ocio.OPTIMIZATION_FAST_LOG_EXP_POW) & int(self._ocio.OPTIMIZATION_DEFAULT)
                flags = self._ocio.OptimizationFlags(exact)
                processor = None if full.isNoOp() else full.getOptimizedCPUProcessor(flags)
            self._processors[key] = processor
        return self._processors[key]

    def _between(self, source: str, target: str) -> Any:
        source_config, source_name = self._find(source)
        target_config, target_name = self._find(target)
        if source_config is target_config:
            return source_config.getProcessor(source_name, target_name)
        try:
            return self._ocio.Config.GetProcessorFromConfigs(source_config, source_name, target_config, target_name)
        except self._ocio.Exception as error:
            # Configurations without interchange roles: take both names from the built-in one where it has them.
            try:
                return self._builtin.getProcessor(
                    _ALIASES.get(source.lower(), source), _ALIASES.get(target.lower(), target)
                )
            except self._ocio.Exception:
                raise HdWavefrontError(
                    f"Colour cannot be converted from {source} to {target}: {str(error).splitlines()[0]}"
                ) from None

    def convert_color(self, rgb: tuple[float, ...], space: str) -> tuple[float, float, float]:
        """A constant of a named space in the rendering space. Nothing authored means lin_rec709, as USD has it."""
        red, green, blue = (float(x) for x in rgb[:3])
        try:
            processor = self.to_rendering(space or DEFAULT_RENDERING_SPACE)
        except LookupError:
            processor = None
        if processor is None:
            return red, green, blue
        red, green, blue = (float(x) for x in processor.applyRGB([red, green, blue]))
        return red, green, blue

    # -- To a display

    def display_and_view(self, display: str = "", view: str = "") -> tuple[str, str]:
        """The configuration's defaults for what is empty; UsageError names the choices for what does not exist."""
        displays = list(self._config.getDisplays())
        if not displays:
            raise HdWavefrontError(f"The OpenColorIO configuration {self.config_name} has no display.")
        display = display or self._config.getDefaultDisplay()
        if display not in displays:
            raise UsageError(f"There is no display '{display}' in {self.config_name}. It has: {', '.join(displays)}.")
        views = list(self._config.getViews(display))
        view = view or self._config.getDefaultView(display)
        if view not in views:
            raise UsageError(f"The display '{display}' has no view '{view}'. It has: {', '.join(views)}.")
        return display, view

    def display_processor(self, display: str, view: str) -> Any:
        """Rendering space to a display and view, as a full OCIO processor."""
        ocio = self._ocio
        config, name = self._find(self.rendering_space)
        if config is self._config:
            return config.getProcessor(ocio.DisplayViewTransform(src=name, display=display, view=view))
        # The configuration does not know the rendering space: first to its scene_linear role, then on.
        linear = self._config.getRoleColorSpace(ocio.ROLE_SCENE_LINEAR) or ocio.ROLE_SCENE_LINEAR
        group = self._between(self.rendering_space, linear).createGroupTransform()
        group.appendTransform(ocio.DisplayViewTransform(src=linear, display=display, view=view))
        return self._config.getProcessor(group)

    def encoding_processor(self, target: str) -> Any:
        """Rendering space to another colour space, without a view."""
        return self._between(self.rendering_space, target)


def gpu_shader(processor: Any, function: str = "hdwavefrontColor") -> dict[str, Any]:
    """OCIO's own GPU shader: the arguments of `RenderDelegate.run_color_kernel` besides the pixels."""
    ocio = _ocio()
    description = ocio.GpuShaderDesc.CreateShaderDesc(language=ocio.GPU_LANGUAGE_GLSL_VK_4_6, functionName=function)
    processor.getDefaultGPUProcessor().extractGpuShaderInfo(description)
    luts = []
    for texture in description.getTextures():
        red_only = texture.channel == ocio.GpuShaderDesc.TEXTURE_RED_CHANNEL
        luts.append(
            {
                "sampler": texture.samplerName,
                "dimension": 1 if texture.dimensions == ocio.GpuShaderDesc.TEXTURE_1D else 2,
                "width": int(texture.width),
                "height": int(texture.height),
                "depth": 1,
                "components": 1 if red_only else 3,
                "linear": texture.interpolation != ocio.INTERP_NEAREST,
                "values": np.array(texture.getValues(), dtype=np.float32),
            }
        )
    for texture in description.get3DTextures():
        luts.append(
            {
                "sampler": texture.samplerName,
                "dimension": 3,
                "width": int(texture.edgeLen),
                "height": int(texture.edgeLen),
                "depth": int(texture.edgeLen),
                "components": 3,
                "linear": texture.interpolation != ocio.INTERP_NEAREST,
                "values": np.array(texture.getValues(), dtype=np.float32),
            }
        )
    return {"glsl": description.getShaderText(), "function": function, "luts": luts}


@lru_cache(maxsize=1)
def ocio_version() -> str:
    return str(_ocio().GetVersion())
