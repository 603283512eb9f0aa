# SPDX-License-Identifier: Apache-2.0
# Copyright the hdWavefront authors
"""The Python host over the real core: colour on the device, broken scenes, the background render."""

from __future__ import annotations

import math
import os

import numpy as np
import OpenImageIO as oiio
import pytest


@pytest.fixture(scope="module")
def core():
    """The native module; without it these tests fail, they are not skipped."""
    try:
        from hdwavefront import _core
    except ImportError as error:
        pytest.fail(f"hdwavefront._core is not built: {error}", pytrace=False)
    return _core


@pytest.fixture(scope="module")
def delegate(core):
    import hdwavefront.api as api

    return core.RenderDelegate(materialx_libraries=os.path.join(api._DATA_FOLDER, "materialx"))


def ramp() -> np.ndarray:
    """Colours of 13 stops, saturated ones and greys among them, and some that no display shows."""
    rng = np.random.default_rng(7)
    pixels = np.exp2(rng.uniform(-8, 5, (32, 48, 4))).astype(np.float32)
    pixels[:4] = pixels[:4, :, :1]
    pixels[4:8, :, 1:] = 0
    pixels[8:10, :, 0] *= -0.05
    pixels[..., 3] = 1
    return pixels


CONFIGS = ["cg-config-v2.2.0_aces-v1.3_ocio-v2.4", "cg-config-v4.0.0_aces-v2.0_ocio-v2.5"]


@pytest.mark.parametrize("config", CONFIGS)
def test_the_device_gives_ocios_colours(delegate, config):
    """OCIO's GPU shader in a compute kernel against OCIO's CPU processor: 1e-3."""
    from hdwavefront.color.manager import ColorManager, gpu_shader

    colors = ColorManager(config)
    processor = colors.display_processor(*colors.display_and_view())
    pixels = ramp()
    got = delegate.run_color_kernel(pixels, **gpu_shader(processor))
    expected = pixels.copy()
    processor.getDefaultCPUProcessor().applyRGBA(expected)
    assert np.abs(expected[..., :3]).max() > 0.9  # the view does something
    np.testing.assert_allclose(got[..., :3], expected[..., :3], atol=1e-3)


def test_a_configuration_with_a_3d_lut(delegate, tmp_path):
    """4/255 where OCIO's GPU shader reads a 3-D LUT."""
    from hdwavefront.color.manager import ColorManager, gpu_shader

    size = 33
    grid = np.linspace(0, 1, size)
    lines = [f"LUT_3D_SIZE {size}"]
    for blue in grid:
        for green in grid:
            for red in grid:
                lines.append(f"{math.sqrt(red):.6f} {green * (1 - 0.3 * red):.6f} {blue**1.5:.6f}")
    (tmp_path / "look.cube").write_text("\n".join(lines) + "\n")
    (tmp_path / "lut.ocio").write_text(
        """ocio_profile_version: 2
search_path: .
roles:
  default: lin_rec709
  scene_linear: lin_rec709
displays:
  Wall:
    - !<View> {name: Graded, colorspace: graded}
colorspaces:
  - !<ColorSpace>
    name: lin_rec709
  - !<ColorSpace>
    name: graded
    from_scene_reference: !<FileTransform> {src: look.cube, interpolation: tetrahedral}
"""
    )
    colors = ColorManager(str(tmp_path / "lut.ocio"))
    processor = colors.display_processor("Wall", "Graded")
    shader = gpu_shader(processor)
    assert [lut["dimension"] for lut in shader["luts"]] == [3]
    pixels = np.clip(ramp(), 0, 1)
    pixels[..., :3] = np.random.default_rng(3).random(pixels[..., :3].shape)
    got = delegate.run_color_kernel(pixels, **shader)
    expected = pixels.copy()
    processor.getDefaultCPUProcessor().applyRGBA(expected)
    np.testing.assert_allclose(got[..., :3], expected[..., :3], atol=4 / 255)


BROKEN = """(
    upAxis = "Y"
)
def Camera "main_cam" {
    float horizontalAperture = 20
    float verticalAperture = 20
    float focalLength = 20
    double3 xformOp:translate = (0, 0, 6)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Sphere "good" {
}
def Mesh "nan" {
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(nan, 0, 0), (1, 0, 0), (1, 1, 0)]
}
def Mesh "indices" {
    int[] faceVertexCounts = [3]
    int[] faceVertexIndices = [0, 1, 99]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
}
def Mesh "counts" {
    int[] faceVertexCounts = [3, 4]
    int[] faceVertexIndices = [0, 1, 2]
    point3f[] points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
}
def Mesh "empty" {
}
def Cube "singular" {
    float3 xformOp:scale = (1, 0, 1)
    uniform token[] xformOpOrder = ["xformOp:scale"]
}
def RectLight "no_area" {
    float inputs:width = 0
    float inputs:intensity = 10
}
def SphereLight "singular_light" {
    float3 xformOp:scale = (0, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:scale"]
}
def DomeLight "no_texture" {
    asset inputs:texture:file = @missing.exr@
}
def Material "m" {
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor.connect = </m/t.outputs:rgb>
        token outputs:surface
    }
    def Shader "t" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @./gone.png@
        float4 inputs:fallback = (0, 1, 0, 1)
        color3f outputs:rgb
    }
}
def Material "odd" {
    token outputs:surface.connect = </odd/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "NoSuchShader"
        token outputs:surface
    }
}
def Cube "textured" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    rel material:binding = </m>
    double size = 0.5
    double3 xformOp:translate = (1.6, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Cube "unknown" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    rel material:binding = </odd>
    double size = 0.5
    double3 xformOp:translate = (-1.6, 0, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""


def test_broken_prims_are_named_and_the_rest_is_drawn(core, stage_file, tmp_path, capfd):
    from hdwavefront.cli.main import main

    image = tmp_path / "o.exr"
    arguments = ["record", stage_file(BROKEN), str(image), "-w", "48", "--samples", "4", "--aov", "primId"]
    code = main(arguments)
    _, err = capfd.readouterr()
    assert code == 0 and "Traceback" not in err, err
    for path in ("/nan", "/indices", "/counts", "/empty", "/singular", "/no_area", "/singular_light"):
        assert f": {path}: " in err, (path, err)
    assert "missing.exr" in err and "gone.png" in err and "/m/t" in err and "/odd/s" in err
    source = oiio.ImageInput.open(str(image))
    names = source.spec().channelnames
    pixels = source.read_image(oiio.FLOAT)
    assert pixels[24, 24, names.index("primId.id")] >= 0  # the sphere
    assert np.isfinite(pixels).all()


TILED = """def Mesh "quad" (
    prepend apiSchemas = ["MaterialBindingAPI"]
)
{
    rel material:binding = </m>
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
    texCoord2f[] primvars:st = [(0, 0), (2, 0), (2, 2), (0, 2)] (
        interpolation = "vertex"
    )
}
def Camera "main_cam" {
    token projection = "orthographic"
    float horizontalAperture = 20
    float verticalAperture = 20
    double3 xformOp:translate = (0, 0, 8)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def Material "m" {
    token outputs:surface.connect = </m/s.outputs:surface>
    def Shader "s" {
        uniform token info:id = "UsdPreviewSurface"
        color3f inputs:diffuseColor = (0, 0, 0)
        color3f inputs:specularColor = (0, 0, 0)
        int inputs:useSpecularWorkflow = 1
        color3f inputs:emissiveColor.connect = </m/t.outputs:rgb>
        token outputs:surface
    }
    def Shader "t" {
        uniform token info:id = "UsdUVTexture"
        asset inputs:file = @./t.<UDIM>.exr@
        token inputs:sourceColorSpace = "raw"
        float4 inputs:fallback = (4, 5, 6, 1)
        float2 inputs:st.connect = </m/r.outputs:result>
        color3f outputs:rgb
    }
    def Shader "r" {
        uniform token info:id = "UsdPrimvarReader_float2"
        string inputs:varname = "st"
        float2 outputs:result
    }
}
"""


def test_udim_tiles_lie_where_their_numbers_say(core, stage_file, tmp_path, capfd):
    """Columns to the right, rows upwards; no tile shows the fallback, and one diagnostic names it."""
    from hdwavefront.cli.main import main

    colors = {1001: (1, 0, 0), 1002: (0, 1, 0), 1011: (0, 0, 1)}
    for number, color in colors.items():
        output = oiio.ImageOutput.create(str(tmp_path / f"t.{number}.exr"))
        output.open(str(tmp_path / f"t.{number}.exr"), oiio.ImageSpec(4, 4, 3, oiio.HALF))
        output.write_image(np.broadcast_to(np.array(color, np.float32), (4, 4, 3)).copy())
        output.close()
    image = tmp_path / "o.exr"
    code = main(["record", stage_file(TILED), str(image), "-w", "16", "--samples", "1"])
    _, err = capfd.readouterr()
    assert code == 0 and err.count("texture-tiles-missing") == 1 and "there is no file for 1012" in err, err
    assert ": /m/t: " in err, err
    pixels = oiio.ImageInput.open(str(image)).read_image(oiio.FLOAT)
    assert pixels.shape[:2] == (16, 16)
    places = {(12, 4): colors[1001], (12, 12): colors[1002], (4, 4): colors[1011], (4, 12): (4, 5, 6)}
    for (y, x), color in places.items():
        np.testing.assert_allclose(pixels[y, x, :3], color, atol=1e-3)


def test_a_render_goes_on_in_the_background(core, stage_file):
    import hdwavefront

    render = hdwavefront.open(stage_file('def Sphere "s" {\n}\n'), width=64)
    render.start(samples=100000)
    assert not render.wait(0.2) and render.progress["running"]
    render.pause()
    early = render.map("color")
    assert early.shape == (46, 64, 4) and np.isfinite(early).all()
    render.resume()
    render.stop()
    done = render.progress["samplesDone"]
    assert not render.progress["running"] and done < 100000
    render.start(samples=2)
    assert render.wait(60) and render.progress["samplesDone"] == 2


@pytest.mark.parametrize("frames", [("1", "2")])
def test_frames_of_one_process_equal_fresh_renders(core, stage_file, tmp_path, frames):
    """What one frame leaves behind does not show in the next."""
    from hdwavefront.cli.main import main

    stage = stage_file(
        """def Sphere "s" {
    double radius.timeSamples = { 1: 0.5, 2: 1 }
}
def Cube "c" {
    token visibility.timeSamples = { 1: "inherited", 2: "invisible" }
}
def Camera "main_cam" {
    double3 xformOp:translate = (0, 0, 8)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def SphereLight "l" {
    double3 xformOp:translate = (4, 4, 4)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""
    )
    options = ["-w", "24", "--samples", "2"]
    assert main(["record", stage, str(tmp_path / "a.#.exr"), "--frames", "1:2", *options]) == 0
    for frame in frames:
        assert main(["record", stage, str(tmp_path / f"b{frame}.#.exr"), "--frames", frame, *options]) == 0
        together = oiio.ImageInput.open(str(tmp_path / f"a.{frame}.exr")).read_image(oiio.FLOAT)
        alone = oiio.ImageInput.open(str(tmp_path / f"b{frame}.{frame}.exr")).read_image(oiio.FLOAT)
        assert together.max() > 0
        np.testing.assert_array_equal(together, alone)


def test_doctor_finds_nothing_wrong(core, capfd):
    from hdwavefront.cli.main import main

    assert main(["doctor"]) == 0
    out, _ = capfd.readouterr()
    assert "OpenColorIO" in out and "Vulkan" in out and "PROBLEM" not in out


@pytest.mark.parametrize("wish", ["no such device", "99"])
def test_doctor_says_that_the_device_asked_for_is_not_there(core, capfd, monkeypatch, wish):
    from hdwavefront.cli.main import main

    monkeypatch.setenv("HDWAVEFRONT_DEVICE", wish)
    assert main(["doctor"]) == 1
    assert f"$HDWAVEFRONT_DEVICE is '{wish}', but no Vulkan device has that index or name" in capfd.readouterr().out


def test_disable_gpu_takes_a_processor(core, stage_file, tmp_path, capfd):
    """By the native module's own words for what a device is."""
    from hdwavefront.cli.main import main

    types = {device["type"] for device in core.list_devices()}
    assert types <= {"discrete GPU", "integrated GPU", "virtual GPU", "CPU", "other"}
    arguments = [stage_file('def Cube "c" {\n}\n'), str(tmp_path / "o.exr"), "-w", "8", "--samples", "1"]
    code = main(["record", *arguments, "--disableGpu"])
    _, err = capfd.readouterr()
    assert (code, "no Vulkan driver" in err) == ((0, False) if "CPU" in types else (1, True)), err
