# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in for the `blender` program where only the bpy module is there.

Understands [-b] FILE [-E ENGINE] [-o OUT] [-F FORMAT] [-t THREADS] [--python-expr CODE]
and -f FRAME, -a or --command NAME ARGS..., carried out in their order like Blender's own. As with
the program, a render operator that fails ends it with code 1.
"""

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))
import addon  # noqa: E402


def main(arguments: list[str]) -> int:
    commands = {}
    bpy.utils.register_cli_command = lambda name, function: commands.setdefault(name, function)
    bpy.utils.unregister_cli_command = lambda handle: None
    addon.register()
    words = iter(arguments)
    for word in words:
        render = bpy.context.scene.render
        match word:
            case "-b":
                pass
            case "-E":
                render.engine = next(words)
            case "-o":
                render.filepath = next(words)
            case "-F":
                addon.batch.set_format(render.image_settings, next(words))
            case "-t":
                render.threads_mode, render.threads = "FIXED", int(next(words))
            case "--python-expr":
                exec(next(words), {})
            case "-f":
                frame = int(next(words))
                bpy.context.scene.frame_start = bpy.context.scene.frame_end = frame
                bpy.ops.render.render(animation=True)
            case "-a":
                bpy.ops.render.render(animation=True)
            case "--command":
                return commands[next(words)](list(words))
            case _:
                bpy.ops.wm.open_mainfile(filepath=word)
    return 0


if __name__ == "__main__":
    try:
        sys.exit(main(sys.argv[1:]))
    except RuntimeError as error:
        print(error, file=sys.stderr)
        sys.exit(1)
