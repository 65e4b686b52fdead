# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A render that fails ends with a non-zero exit code and leaves no file for its frame."""

from pathlib import Path

import bpy
import pytest
from blender_process import programs

# Each makes a render fail: Python code that runs before it.
AT_ONCE = {
    "samples not square": "import bpy; bpy.context.scene.whittle.samples = 5",
    "depth beyond the range": "import bpy; bpy.context.scene.whittle.max_depth = 65",
    "bins beyond the range": "import bpy; bpy.context.scene.whittle.bins = 1",
    "stereoscopy": "import bpy; bpy.context.scene.render.use_multiview = True",
    "native module missing": "import sys; sys.modules['whittle_core'] = None",
    "no camera": "import bpy; bpy.context.scene.camera = None",
}
# Each makes the second frame fail, by an error raised in the function that it names.
IN_FRAME_2 = """
import bpy
import PACKAGE.{module} as module
original = module.{function}
def failing(*arguments, **keywords):
    if bpy.context.scene.frame_current == 2:
        raise {error}
    return original(*arguments, **keywords)
module.{function} = failing
"""
INJECTED = {
    "the exporter": ("export.meshes", "arrays", "RuntimeError('injected')"),
    "the camera's export": ("export.camera", "export", "KeyError('injected')"),
    "the build": ("engine", "_build", "MemoryError('injected')"),
    "the trace": ("engine", "_trace", "ValueError('injected')"),
    "handing over": ("engine", "_hand_over", "OSError('injected')"),
    "an interrupt": ("export.lights", "export", "KeyboardInterrupt('injected')"),
}


@pytest.fixture(params=programs(), ids=lambda blender: blender.package)
def blender(request):
    return request.param


@pytest.fixture
def file(scene, tmp_path) -> Path:
    """A .blend of a lit cube with three frames."""
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.light_add(type="POINT", location=(2, -2, 5))
    scene.frame_end = 3
    path = tmp_path / "cube.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return path


def job(file: Path, code: str, *render: str, form: str = "PNG") -> list[str]:
    """The arguments of a batch job that runs some code and then renders."""
    out = str(file.parent / "out_####")
    return ["-b", str(file), "-E", "WHITTLE", "-o", out, "-F", form, "--python-expr", code, *render]


def written(file: Path) -> list[str]:
    return sorted(path.name for path in file.parent.glob("out_*"))


@pytest.mark.parametrize("form", ["PNG", "OPEN_EXR_MULTILAYER"])
def test_a_render_that_works_leaves_its_files(blender, file, form):
    done = blender.run(*job(file, "pass", "-a", form=form))
    suffix = ".png" if form == "PNG" else ".exr"
    assert done.returncode == 0, done.stdout + done.stderr
    assert written(file) == [f"out_000{frame}{suffix}" for frame in (1, 2, 3)]


@pytest.mark.parametrize("reason", AT_ONCE)
def test_a_still_that_fails(blender, file, reason):
    done = blender.run(*job(file, AT_ONCE[reason], "-f", "1"))
    assert done.returncode == 1, done.stdout + done.stderr
    assert written(file) == []
    assert "error" in (done.stdout + done.stderr).lower()


@pytest.mark.parametrize("reason", ["samples not square", "native module missing"])
def test_an_animation_that_fails_at_once(blender, file, reason):
    done = blender.run(*job(file, AT_ONCE[reason], "-a"))
    assert done.returncode == 1
    assert written(file) == []


@pytest.mark.parametrize(
    "place, form", [(place, "PNG") for place in INJECTED] + [("the trace", "OPEN_EXR_MULTILAYER")]
)
def test_an_animation_that_fails_in_the_middle(blender, file, place, form):
    module, function, error = INJECTED[place]
    code = IN_FRAME_2.format(module=module, function=function, error=error)
    done = blender.run(*job(file, code, "-a", form=form))
    assert done.returncode == 1, done.stdout + done.stderr
    assert "injected" in done.stdout + done.stderr
    assert [name[:8] for name in written(file)] == ["out_0001"]


def test_a_broken_library_is_named_with_its_reason(blender, file, tmp_path):
    broken = tmp_path / "broken"
    broken.mkdir()
    (broken / "whittle_core.abi3.so").write_bytes(b"not a library")
    code = f"import sys; sys.path.insert(0, {str(broken)!r})"
    done = blender.run(*job(file, code, "-f", "1"))
    text = done.stdout + done.stderr
    assert done.returncode == 1 and written(file) == []
    assert "broken/whittle_core.abi3.so" in text and "ImportError" in text


def test_a_library_of_another_version_is_refused(blender, file):
    code = "import whittle_core; whittle_core.__version__ = '9.9.9'"
    done = blender.run(*job(file, code, "-f", "1"))
    assert done.returncode == 1 and written(file) == []
    assert "9.9.9" in done.stdout + done.stderr


def test_one_failing_view_layer_fails_the_frame(blender, file):
    code = IN_FRAME_2.format(module="engine", function="_keep", error="RuntimeError('injected')")
    code = code.replace("bpy.context.scene.frame_current == 2", "arguments[1].layer == 'Second'")
    layers = "import bpy; bpy.context.scene.view_layers.new('Second')\n"
    done = blender.run(*job(file, layers + code, "-f", "1"))
    assert done.returncode == 1 and written(file) == []
