"""URDF: what has to be settled in its tree of elements before MuJoCo, which parses URDF itself, gets it."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from graph.base import asset_roots
from graph.base.errors import Mark, Problem, UserError

from .source import Element

READ = (".stl", ".obj", ".msh")
"""Mesh formats that MuJoCo reads."""
KEPT = {"fusestatic": "false", "discardvisual": "false", "strippath": "false"}
"""Settings of MuJoCo's compiler: links behind fixed joints stay links, and rays see visual geometry."""
_EXTENSION = ("compiler", "option", "size")
COLLISIONS = 3
"""Group of the collision geometry of links that have visual geometry: rays do not see it."""


def prepare(robot: Element) -> tuple[list[Problem], list[tuple[Mark, str]]]:
    """Settles the compiler's settings, and removes what MuJoCo cannot read; what is wrong, and what was left out.

    Of MuJoCo's own extension (`<mujoco>` in the robot) its compiler, option and size are kept.
    """
    problems = [
        Problem("this is a xacro file; run xacro on it and name the URDF that it writes", element.mark)
        for element in robot.walk()
        if element.tag.startswith("xacro:")
    ][:1]
    taken: set[tuple[str, str]] = set()
    for one in robot.children:
        kind = one.tag, one.get("name") or ""
        if kind in taken and one.tag in ("link", "joint"):
            problems.append(Problem(f"two {one.tag}s are called {kind[1]}; rename one", one.mark))
        taken.add(kind)
    left_out: list[tuple[Mark, str]] = []
    for link in robot.children:
        for part in list(link.children) if link.tag == "link" else ():
            name = next((mesh.get("filename") for mesh in part.walk() if mesh.tag == "mesh"), None) or ""
            if part.tag in ("visual", "collision") and name and Path(name).suffix.lower() not in READ:
                said = f"the {part.tag} mesh {name} of link {link.get('name')}"
                left_out.append((part.mark, f"{said} is left out; convert it to one of {', '.join(READ)}"))
                link.children.remove(part)
    textures = [(parent, child) for parent in robot.walk() for child in parent.children if child.tag == "texture"]
    for parent, child in textures:
        parent.children.remove(child)
    if textures:
        left_out.append((textures[0][1].mark, "textures are left out; its materials have their colours"))
    own = [child for child in robot.children if child.tag == "mujoco"]
    settings = [child for one in own for child in one.children if child.tag in _EXTENSION]
    compiler = Element("compiler", {}, robot.mark)
    for child in [child for child in settings if child.tag == "compiler"]:
        compiler.attributes |= child.attributes
        settings.remove(child)
    robot.children = [child for child in robot.children if child.tag != "mujoco"]
    robot.children.insert(0, Element("mujoco", {}, robot.mark, [compiler, *settings]))
    return problems, left_out


def speed_limits(robot: Element) -> dict[str, float]:
    """The largest speed of each joint [rad/s or m/s] by its name, which MuJoCo does not read; 0 means none."""
    found: dict[str, float] = {}
    for joint in robot.children:
        for limit in joint.children if joint.tag == "joint" else ():
            if limit.tag == "limit" and limit.get("velocity"):
                try:
                    most = float(limit.get("velocity") or 0)
                except ValueError:  # MuJoCo reports numbers that it reads; this one it does not
                    raise UserError([Problem("limit velocity is not a number", limit.mark)]) from None
                if 0 < most < math.inf:
                    found[joint.get("name") or ""] = most
    return found


def mesh_file(address: str, urdf: Path, folder: Path, roots: list[Path]) -> Path:
    """The file of a mesh: an address that `--asset-root` maps, `package://NAME/...`, `file://...` or a relative name.

    A package without a mapping is the nearest folder of its name at or above the URDF, below one of `roots`; relative
    names are below `folder`. Raises ValueError, with the remedy, for other addresses.
    """
    found = asset_roots.local_file(address)
    if found is not None:
        return found
    scheme, separator, rest = address.replace("\\", "/").partition("://")
    if not separator:
        return folder / address.replace("\\", "/")
    if scheme == "file":
        return Path("/") / rest.lstrip("/")
    package, _, below = rest.partition("/")
    if scheme == "package":
        for parent in urdf.resolve().parents:
            if parent.name == package and any(parent.is_relative_to(root) for root in roots):
                return parent / below
        raise ValueError(f"{address}: give the folder of the package with --asset-root package://{package}=DIR")
    raise ValueError(f"{address} is not a file; give its folder with --asset-root {scheme}://{package}=DIR")


def hide_collisions(spec: Any) -> None:
    """Puts the collision geometry of links that have visual geometry into a group that rays do not see."""
    for body in spec.bodies:
        geoms = list(body.geoms)
        if any(geom.contype == 0 and geom.conaffinity == 0 for geom in geoms):
            for geom in geoms:
                if geom.contype or geom.conaffinity:
                    geom.group = COLLISIONS
