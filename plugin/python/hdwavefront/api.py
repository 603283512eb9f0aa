# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The Python API: a stage, opened and rendered in the background."""

from __future__ import annotations

import dataclasses
import math
import os
import time as clock
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from .errors import Diagnostic, Diagnostics, HdWavefrontError, UsageError

REFINE_LEVELS = {"low": 0, "medium": 1, "high": 2, "veryhigh": 3}
COLOR_MODES = ("disabled", "sRGB", "openColorIO")
MAX_SIDE = 65536
MAX_PIXELS = 1 << 26
DEFAULT_WIDTH = 960

_DATA_FOLDER = os.path.join(os.path.dirname(os.path.abspath(__file__)), "data")


def open(path: str, **options: Any) -> Render:
    """Opens a USD stage for rendering. Options are those of `Render`."""
    return Render(path, **options)


def core() -> Any:
    """The native module; HdWavefrontError where it cannot be loaded."""
    try:
        from . import _core
    except ImportError as error:
        raise HdWavefrontError(f"The native module hdwavefront._core cannot be loaded: {error}") from None
    return _core


def create_delegate(**options: Any) -> Any:
    """A render delegate; options are those of `_core.RenderDelegate`."""
    try:
        return core().RenderDelegate(materialx_libraries=os.path.join(_DATA_FOLDER, "materialx"), **options)
    except (RuntimeError, ValueError) as error:
        raise HdWavefrontError(str(error)) from None


class Render:
    """A stage, a camera, settings, and the picture that comes of them.

    path: a USD file. Keyword options, all of which have defaults:
      camera: path or name of a camera; else the RenderSettings prim's, `main_cam`, the only camera of the stage, or a
        free camera that frames the stage.
      width, height: pixels; else the RenderSettings prim's resolution, or 960 wide with the camera's aspect.
      frame: a time code, "default" for the default time, None for the stage's start.
      complexity: low, medium, high, veryhigh: the level of subdivision.
      purposes: besides "default"; render_settings, render_pass: path of a prim; mask: prim paths to load;
      session_layer: a layer file over the stage; resolver: "root" or "inherit", the context that assets are found in.
      aovs: besides color: depth, cameraDepth, normal, Neye, albedo, primId, instanceId, elementId, sampleCount,
        materialCost (nanoseconds that a sample spends in material kernels, as measured), and
        primvars:<name> for up to four primvars (primvars:st, say).
      ocio, display, view: colour configuration and how display-referred files look.
      color_mode: openColorIO, sRGB, disabled; None: openColorIO in PNG, JPEG and TIFF, scene-linear in EXR and HDR.
      rendering_space: the scene-linear space that is rendered in. camera_light: None = where nothing shines.
      window_policy: how the aperture is fitted to the image, as UsdRenderSettings.aspectRatioConformPolicy has it.
      dome_visible: domes are seen by the camera. device: index or part of a name.
      on_diagnostic: called with each new `Diagnostic`. delegate: in place of one that renders on `device`.
      settings: values of render settings by token, such as {"maxBounces": 4}.
    """

    def __init__(
        self,
        path: str,
        *,
        camera: str = "",
        width: int | None = None,
        height: int | None = None,
        frame: float | str | None = None,
        complexity: str = "low",
        purposes: Iterable[str] | None = None,
        render_settings: str = "",
        render_pass: str = "",
        mask: Iterable[str] = (),
        session_layer: str = "",
        resolver: str = "root",
        aovs: Iterable[str] = (),
        ocio: str = "",
        display: str = "",
        view: str = "",
        color_mode: str | None = None,
        rendering_space: str = "",
        camera_light: bool | None = None,
        dome_visible: bool = False,
        window_policy: str = "",
        device: str = "",
        on_diagnostic: Callable[[Diagnostic], None] | None = None,
        delegate: Any = None,
        settings: Mapping[str, Any] | None = None,
    ) -> None:
        from .stage import open_stage

        self.path = path
        self.diagnostics = Diagnostics(on_diagnostic)
        self.timings: dict[str, float] = {}
        self._camera_name = camera
        self._size_wish = (width, height)
        self._refine_level = _refine_level(complexity)
        self._purposes = frozenset(purposes) | {"default"} if purposes is not None else None
        self._camera_light = camera_light
        self._dome_visible = dome_visible
        self._window_policy = window_policy
        self._display, self._view = display, view
        self._color_mode = _color_mode(color_mode)
        self._settings = dict(settings or {})
        _check_size_wish(width, height)
        begin = clock.perf_counter()
        self.stage = open_stage(
            path, self.diagnostics, mask=tuple(mask), session_layer=session_layer, resolver=resolver
        )
        self.timings["open"] = clock.perf_counter() - begin
        self.time = self._time_code(frame)
        self.render_settings = self._read_render_settings(render_settings, render_pass)
        self.shot = self.render_settings.shot
        self.aovs = _check_aovs([*aovs, *(a for p in self.render_settings.products for a in p.aovs)])
        from .color.manager import DEFAULT_RENDERING_SPACE, ColorManager

        self.colors = ColorManager(ocio, rendering_space or DEFAULT_RENDERING_SPACE)
        if not rendering_space and self.render_settings.rendering_space:
            self._use_rendering_space(self.render_settings.rendering_space)
        if display or view or self._color_mode == "openColorIO":
            self.colors.display_and_view(display, view)  # a wrong name is said before the render
        from .scene_sync import TrackingSink

        self.delegate = delegate if delegate is not None else create_delegate(device=device)
        self.delegate.set_unconverted_color_spaces(self.colors.unconverted_names())
        self._sink = TrackingSink(self.delegate)
        self._seen_diagnostics = 0
        self.camera = ""
        self.size = self.full_size = (0, 0)  # of what is rendered; of the picture, where a data window is a part of it
        self._prepared = False

    # -- Set-up

    def _time_code(self, frame: float | str | None) -> Any:
        from pxr import Usd

        if frame is None:
            return Usd.TimeCode(self.stage.GetStartTimeCode())
        return Usd.TimeCode.Default() if frame == "default" else Usd.TimeCode(float(frame))

    def _read_render_settings(self, name: str, render_pass: str) -> Any:
        from .stage_adapters.render_settings import (
            RenderSettingsPrim,
            find_render_settings,
            read_render_settings,
            settings_of_pass,
        )

        if render_pass:
            if name:
                raise UsageError("A RenderSettings prim and a RenderPass prim cannot both be given.")
            name = settings_of_pass(self.stage, render_pass, self.diagnostics)
        prim = find_render_settings(self.stage, name, self.diagnostics)
        return read_render_settings(prim, self.time, self.diagnostics) if prim else RenderSettingsPrim()

    def _use_rendering_space(self, space: str) -> None:
        """What the stage asks for, if there is such a space: its mistakes do not stop a render."""
        if self.colors.knows(space):
            self.colors.rendering_space = space
        else:
            self.diagnostics.warning(
                "render-settings-bad-value",
                self.render_settings.path,
                f"renderingColorSpace is '{space}', which no configuration knows; it is ignored",
            )

    def _find_camera(self) -> Any:
        """The camera's schema object; None for the free camera."""
        from .stage_adapters.camera import all_cameras, find_camera, require_camera

        if self._camera_name:
            return require_camera(self.stage, self._camera_name)
        if self.shot.camera:
            camera = find_camera(self.stage, self.shot.camera)
            if camera is not None:
                return camera
            self.diagnostics.warning(
                "camera-missing", self.render_settings.path, f"the camera {self.shot.camera} does not exist"
            )
        from pxr import UsdUtils

        camera = find_camera(self.stage, str(UsdUtils.GetPrimaryCameraName()))
        if camera is not None:
            return camera
        cameras = all_cameras(self.stage)
        return cameras[0] if len(cameras) == 1 else None

    def set_frame(self, frame: float | str | None) -> None:
        """Another frame of the same stage; what did not change is not done again."""
        self.time = self._time_code(frame)
        self.shot = self.render_settings.shot
        self._prepared = False

    def prepare(self) -> None:
        """Tells the renderer the scene at the frame. `start` does it where it was not done."""
        from .mtlx import replace_references
        from .stage import usd_warnings
        from .stage_adapters.context import Options
        from .stage_adapters.lights import emit_camera_light
        from .stage_adapters.traversal import translate

        begin = clock.perf_counter()
        settings = self.render_settings
        purposes = self._purposes or settings.purposes or frozenset({"default", "proxy"})
        material_purpose = settings.material_purpose if settings.material_purpose is not None else "full"
        options = Options(
            time=self.time,
            purposes=purposes,
            refine_level=self._refine_level,
            material_purpose=material_purpose,
            convert_color=self.colors.convert_color,
            knows_color_space=self.colors.knows,
        )
        self._sink.begin()
        transform = self._sync_camera(purposes)
        with usd_warnings(self.path, self.diagnostics):
            replace_references(self.stage, self.diagnostics)  # a variant may have brought another file
            translation = translate(self.stage, options, self._sink, self.diagnostics)
        shines = translation.light_count > 0 or translation.has_emission
        if self._camera_light or (self._camera_light is None and not shines):
            emit_camera_light(translation, transform)
        self._sink.finish()
        self._apply_settings(purposes)
        self.timings["translate"] = clock.perf_counter() - begin
        begin = clock.perf_counter()
        from .image_io.texture_loading import load_pending

        load_pending(self.delegate, self.colors, self.diagnostics)
        self.timings["textures"] = clock.perf_counter() - begin
        begin = clock.perf_counter()
        with _clear_errors():
            self.delegate.commit()
        self.timings["commit"] = clock.perf_counter() - begin
        self._take_diagnostics()
        self._prepared = True

    def _sync_camera(self, purposes: frozenset[str]) -> np.ndarray:
        from .stage_adapters import camera as cameras

        camera = self._find_camera()
        if camera is None:
            self.camera = cameras.FREE_CAMERA_PATH
            params, transform = cameras.free_camera(self.stage, self.time, purposes)
        else:
            self.camera = str(camera.GetPath())
            params = cameras.camera_params(camera, self.time, self.diagnostics)
            transform = cameras.camera_transform(camera, self.time)
            if self.shot.disable_depth_of_field:
                params["fStop"] = 0.0
        self._sink.sync_camera(self.camera, params=params, transform=transform)
        self.full_size = self._image_size(cameras.aspect_ratio(params))
        left, bottom, right, top = self.shot.data_window
        self.size = (round(self.full_size[0] * (right - left)), round(self.full_size[1] * (top - bottom)))
        if min(self.size) < 1:
            raise HdWavefrontError(f"{self.render_settings.path}: a dataWindowNDC has no pixels.")
        return transform

    def _image_size(self, aspect: float) -> tuple[int, int]:
        width, height = self._size_wish
        resolution = self.shot.resolution
        if width is None and height is None and resolution is not None:
            width, height = resolution
            if width <= 0 or height <= 0:
                raise HdWavefrontError(f"{self.render_settings.path}: the resolution {width} x {height} has no pixels.")
        elif width is None and height is not None:
            width = max(int(height * aspect), 1)
        width = width if width is not None else DEFAULT_WIDTH
        height = height if height is not None else max(int(width / aspect), 1)
        if width > MAX_SIDE or height > MAX_SIDE or width * height > MAX_PIXELS:
            raise UsageError(
                f"An image of {width} x {height} is too large: at most {MAX_SIDE} a side and {MAX_PIXELS} pixels."
            )
        return width, height

    def _apply_settings(self, purposes: frozenset[str]) -> None:
        settings = self.render_settings
        with _clear_errors():
            self.delegate.set_render_pass(
                camera=self.camera,
                width=self.size[0],
                height=self.size[1],
                pixel_aspect_ratio=self.shot.pixel_aspect_ratio or 1.0,
                data_window=self.shot.data_window,
                window_policy=self._window_policy or self.shot.window_policy or "expandAperture",
                render_tags=sorted("geometry" if p == "default" else p for p in purposes),
                aovs=self.aovs,
            )
        self.delegate.set_setting("domeLightCameraVisibility", self._dome_visible)
        if not self.time.IsDefault():
            self.delegate.set_setting("frame", float(self.time.GetValue()))
            self.delegate.set_setting("time", float(self.time.GetValue() / self.stage.GetTimeCodesPerSecond()))
        for token, value in settings.settings.items():
            try:
                self.delegate.set_setting(token, value)
            except (ValueError, TypeError) as error:
                self.diagnostics.warning("render-setting", f"{settings.path}.wavefront:{token}", str(error))
        for token, value in self._settings.items():
            try:
                self.delegate.set_setting(token, value)
            except (ValueError, TypeError) as error:
                raise UsageError(str(error)) from None

    def _take_diagnostics(self) -> None:
        for d in self.delegate.diagnostics(self._seen_diagnostics):
            self.diagnostics.add(d.severity, d.code, d.location, d.message)
            self._seen_diagnostics += 1

    # -- Rendering

    def start(self, samples: int | None = None, **settings: Any) -> None:
        """Begins in the background. Settings by token: samples, maxBounces, seed ..."""
        if samples is not None:
            settings["samples"] = samples
        self._settings.update(settings)
        if settings or not self._prepared:
            self.prepare()
        with _clear_errors():
            self.delegate.start()

    def wait(self, timeout: float | None = None) -> bool:
        """True when done; False when `timeout` seconds passed before. Ctrl-C is heard."""
        end = math.inf if timeout is None else clock.perf_counter() + timeout
        while True:
            with _clear_errors():
                done = self.delegate.wait(min(0.1, max(0.0, end - clock.perf_counter())))
            if done or clock.perf_counter() >= end:
                self._take_diagnostics()
                return done

    def pause(self) -> None:
        self.delegate.pause()

    def resume(self) -> None:
        self.delegate.resume()

    def stop(self) -> None:
        """Ends the render; what was rendered stays."""
        self.delegate.stop()

    @property
    def progress(self) -> dict[str, Any]:
        """samplesDone, pathsDone, pathsTotal, seconds, running, paused, converged."""
        return self.delegate.progress()

    def map(self, aov: str = "color") -> np.ndarray:
        """The picture so far: (height, width, components), row 0 at the top. Also while rendering."""
        with _clear_errors():
            return self.delegate.map(aov)

    def stats(self) -> dict[str, Any]:
        return self.delegate.stats()

    # -- Saving

    def save(self, path: str, aovs: Iterable[str] | None = None) -> None:
        """Writes the picture so far. EXR takes `aovs` (all that were rendered) as layers; others the colour only."""
        from .image_io import writer

        wanted = list(aovs) if aovs is not None else list(self.aovs) if writer.extension(path) == ".exr" else ["color"]
        writer.check_output(path, wanted)
        metadata = self._metadata()
        if self._is_linear(path):
            layers = {aov: self.map(aov) for aov in wanted}
            writer.write_linear(path, layers, metadata, self.colors.rendering_space, self._place())
            return
        kind = writer.extension(path)
        encoded = self._encode(self.map("color"), keep_alpha=writer.holds_alpha(path))
        if kind == ".exr":
            encoded[..., :3] *= encoded[..., 3:4]  # colour in EXR files is premultiplied, whatever it is encoded for
            others = {aov: self.map(aov) for aov in wanted if aov != "color"}
            writer.write_linear(path, {"color": encoded, **others}, metadata, "", self._place())
            return
        writer.write_display(path, encoded, metadata)

    def save_products(self, folder: str, render: Callable[[], bool] | None = None) -> list[str]:
        """Writes the products of the RenderSettings prim, relative names in `folder`; returns the paths.

        Those that look at what was rendered are written as it is. For the others, by camera, resolution and so on, one
        picture after the other is rendered, and the last one stays. `render` starts and waits; False: give up.
        """
        written = []
        for shot, products in self._shots(folder):
            if self.look_at(shot):
                if render is None:
                    self.start()
                    self.wait()
                elif not render():
                    break
            for product, path in products:
                self.save(path, product.aovs)
                written.append(path)
        return written

    def look_at(self, shot: Any) -> bool:
        """Another camera, resolution ... for the next render. False: it is what is looked at already."""
        if self._own(shot) == self._own(self.shot):
            return False
        self.shot = shot
        self._prepared = False
        return True

    def _own(self, shot: Any) -> Any:
        """What of a shot counts: flags win over prims."""
        changes: dict[str, Any] = {}
        if self._camera_name:
            changes["camera"] = ""
        if self._size_wish != (None, None):
            changes["resolution"] = None
        if self._window_policy:
            changes["window_policy"] = ""
        return dataclasses.replace(shot, **changes)

    def _shots(self, folder: str) -> list[tuple[Any, list[tuple[Any, str]]]]:
        """The products by what they look at, beginning with what was rendered."""
        shots: list[tuple[Any, list[tuple[Any, str]]]] = [(self.shot, [])]
        for product, path in self.product_paths(folder):
            for shot, products in shots:
                if self._own(shot) == self._own(product.shot):
                    products.append((product, path))
                    break
            else:
                shots.append((product.shot, [(product, path)]))
        return shots

    def product_paths(self, folder: str) -> list[tuple[Any, str]]:
        return [(p, os.path.join(folder, p.name)) for p in self.render_settings.products]

    def _is_linear(self, path: str) -> bool:
        from .image_io import writer

        if self._color_mode == "disabled" or (self._color_mode is None and not (self._display or self._view)):
            return writer.is_scene_linear(path)
        return False

    def _encode(self, rgba: np.ndarray, *, keep_alpha: bool) -> np.ndarray:
        """Display-referred colour with straight alpha (or over black), by OCIO's GPU shader in a compute kernel."""
        from .color.manager import gpu_shader

        pixels = np.array(rgba, dtype=np.float32)
        alpha = pixels[..., 3:4].copy()
        if keep_alpha:
            np.divide(pixels[..., :3], alpha, out=pixels[..., :3], where=alpha > 0)
        if self._color_mode == "disabled":
            return pixels
        if self._color_mode == "sRGB":
            processor = self.colors.encoding_processor("sRGB")
        else:
            processor = self.colors.display_processor(*self.colors.display_and_view(self._display, self._view))
        with _clear_errors():
            encoded = self.delegate.run_color_kernel(pixels, **gpu_shader(processor))
        encoded[..., 3:4] = alpha
        return encoded

    def _place(self) -> tuple[int, int, int, int]:
        """Of what is rendered in the picture: left column, upper row; the picture's width and height."""
        width, height = self.full_size
        return round(self.shot.data_window[0] * width), round((1 - self.shot.data_window[3]) * height), width, height

    def _metadata(self) -> dict[str, Any]:
        metadata: dict[str, Any] = {
            "Software": f"hdWavefront {core().__version__}",
            "hdwavefront:stage": os.path.basename(self.path),
            "hdwavefront:camera": self.camera,
            "hdwavefront:renderingColorSpace": self.colors.rendering_space,
            "PixelAspectRatio": float(self.shot.pixel_aspect_ratio or 1.0),
        }
        if not self.time.IsDefault():
            metadata["hdwavefront:frame"] = float(self.time.GetValue())
        for setting in core().render_settings():
            value = self.delegate.setting(setting["token"])
            metadata[f"hdwavefront:{setting['token']}"] = int(value) if isinstance(value, bool) else value
        metadata["hdwavefront:samplesDone"] = int(self.progress["samplesDone"])
        world_to_camera, world_to_ndc = self.delegate.camera_matrices()
        metadata["worldToCamera"] = np.asarray(world_to_camera)
        metadata["worldToNDC"] = np.asarray(world_to_ndc)
        return metadata


class _clear_errors:  # noqa: N801 - used like a function
    """Turns the native module's exceptions for arguments and environment into sentences for the user."""

    def __enter__(self) -> None:
        return None

    def __exit__(self, kind: Any, error: Any, trace: Any) -> None:
        if isinstance(error, RuntimeError | ValueError) and not isinstance(error, HdWavefrontError):
            raise HdWavefrontError(str(error)) from error


def _refine_level(complexity: str) -> int:
    if complexity not in REFINE_LEVELS:
        raise UsageError(f"The complexity '{complexity}' is none of {', '.join(REFINE_LEVELS)}.")
    return REFINE_LEVELS[complexity]


def _color_mode(mode: str | None) -> str | None:
    if mode is not None and mode not in COLOR_MODES:
        raise UsageError(f"The color correction mode '{mode}' is none of {', '.join(COLOR_MODES)}.")
    return mode


def _check_size_wish(width: int | None, height: int | None) -> None:
    for name, value in (("width", width), ("height", height)):
        if value is not None and value <= 0:
            raise UsageError(f"The image {name} is {value}; it must be at least 1.")


def _check_aovs(wanted: Iterable[str]) -> list[str]:
    known = [row["token"] for row in core().aovs()]
    aovs = ["color"]
    for name in wanted:
        if name not in known and not (name.startswith("primvars:") and len(name) > len("primvars:")):
            raise UsageError(f"There is no AOV '{name}'. There are: {', '.join(known)}.")
        if name not in aovs:
            aovs.append(name)
    return aovs
