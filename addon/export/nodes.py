# SPDX-FileCopyrightText: 2026 The Whittle Authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads shader node trees: what feeds a socket, and its value where that is a constant."""

from collections.abc import Callable
from typing import Any

import bpy

Groups = tuple[bpy.types.Node, ...]  # the group nodes that a socket lies in, outermost first
Place = tuple[bpy.types.NodeSocket, Groups]


def feeding(socket: bpy.types.NodeSocket, groups: Groups) -> tuple[Place | None, Place]:
    """The output that feeds an input, through reroutes, groups and muted nodes, or None; and the
    last input on the way, which holds the value if nothing feeds it."""
    while socket.is_linked:
        output = socket.links[0].from_socket
        step = _through(output, groups)
        if step is None:
            return (output, groups), (socket, groups)
        socket, groups = step
    return None, (socket, groups)


def _through(output: bpy.types.NodeSocket, groups: Groups) -> Place | None:
    """The input that an output passes on unchanged, if it belongs to a node that only does so."""
    node = output.node
    if node.mute:
        for link in node.internal_links:
            if link.to_socket == output:
                return link.from_socket, groups
    if node.type == "REROUTE":
        return node.inputs[0], groups
    if node.type == "GROUP" and node.node_tree is not None:
        for inner in node.node_tree.nodes:
            if inner.type == "GROUP_OUTPUT" and inner.is_active_output:
                return _same(inner.inputs, output), (*groups, node)
    if node.type == "GROUP_INPUT" and groups:
        return _same(groups[-1].inputs, output), groups[:-1]
    return None


def _same(sockets: Any, socket: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    return next(other for other in sockets if other.identifier == socket.identifier)


class Reader:
    """Values of a node's inputs. What is not a constant is said in the notes and its socket's own
    value used."""

    def __init__(self, node: bpy.types.Node, groups: Groups, note: Callable[[str], None]) -> None:
        self.node = node
        self.groups = groups
        self.note = note

    def linked(self, name: str) -> bool:
        """Whether an input exists and something feeds it."""
        socket = self.node.inputs.get(name)
        return socket is not None and feeding(socket, self.groups)[0] is not None

    def value(self, name: str, default: float) -> float:
        """A number; the default where this version of Blender has no such input."""
        value = self._constant(name)
        return default if value is None else float(value)

    def color(self, name: str, default: float) -> tuple[float, float, float]:
        """Linear RGB; the default in all three where there is no such input."""
        value = self._constant(name)
        return (default,) * 3 if value is None else tuple(value[:3])

    def _constant(self, name: str) -> Any:
        socket = self.node.inputs.get(name)
        if socket is None:
            return None
        source, (last, _) = feeding(socket, self.groups)
        if source is None:
            return last.default_value
        output = source[0]
        if output.node.type in ("RGB", "VALUE"):
            return _fit(output.default_value, socket)
        self.note(
            f"node '{output.node.name}' ({output.node.bl_label}) is not understood, "
            f"{self.node.bl_label}'s own {name} is used"
        )
        return socket.default_value


def _fit(value: Any, socket: bpy.types.NodeSocket) -> Any:
    """A constant as the kind of the input it feeds: grey from a number, luminance from a colour."""
    wants_color = socket.type == "RGBA"
    is_color = not isinstance(value, float)
    if wants_color and not is_color:
        return (value, value, value)
    if is_color and not wants_color:
        return 0.2126 * value[0] + 0.7152 * value[1] + 0.0722 * value[2]
    return value


def in_use(owner: bpy.types.ID) -> bool:
    """Whether a material, light or world is what its nodes say."""
    # From 5.0 on nodes are always in use, and asking warns.
    return owner.node_tree is not None and (bpy.app.version >= (5, 0) or owner.use_nodes)


def surface_input(
    tree: bpy.types.NodeTree, input_name: str = "Surface"
) -> bpy.types.NodeSocket | None:
    """The Surface input of a tree's active output; None: the tree has no output."""
    output = tree.get_output_node("CYCLES")
    return None if output is None else output.inputs[input_name]
