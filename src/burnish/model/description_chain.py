"""The tree of frames of a description, and whether it is one serial chain that leads to the tool."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from burnish.errors import DescriptionError
from burnish.model.description_xml import Element, fault, quoted


@dataclass(frozen=True, kw_only=True)
class Frame:
    """A frame of the tree: a link of a URDF, a body or a site of an MJCF."""

    name: str
    element: Element
    parent: int
    """Index of the frame that it hangs on; −1 for the root. Parents come before their children."""
    joints: tuple[str, ...] = ()
    """Names of the moving joints between the parent and this frame, for messages."""
    has_mass: bool = False
    """Whether this frame itself carries mass."""


def check_chain(frames: list[Frame], tool: str | None) -> None:
    """Refuse a tree without moving joints, with some off the chain to the tool, or with a massless moving link."""
    if not any(frame.joints for frame in frames):
        raise DescriptionError("found no joint that moves; expected an arm: check the joint types")
    depth = _moving_depth(frames)
    end = max(range(len(frames)), key=lambda i: depth[i]) if tool is None else _find(frames, tool)
    chain = set()
    i = end
    while i >= 0:
        chain.add(i)
        i = frames[i].parent
    beside = [i for i in range(len(frames)) if frames[i].joints and i not in chain]
    if beside:
        names = _listed(name for i in beside for name in frames[i].joints)
        raise fault(
            frames[beside[0]].element,
            f"moving joints that are not on the way to {quoted(frames[end].name)}: {names}",
            "one serial chain from the base to the tool",
            "make them fixed, or ask for another tool frame",
        )
    _check_masses(frames)


def _check_masses(frames: list[Frame]) -> None:
    """Refuse a moving joint behind which nothing rigidly attached has mass."""
    carrier = [0] * len(frames)
    loaded = set()
    for i, frame in enumerate(frames):
        carrier[i] = i if frame.joints or frame.parent < 0 else carrier[frame.parent]
        if frame.has_mass:
            loaded.add(carrier[i])
    for i, frame in enumerate(frames):
        if frame.joints and i not in loaded:
            raise fault(
                frame.element,
                f"no mass on {quoted(frame.name)}, which joint {quoted(frame.joints[-1])} moves",
                "mass and inertia for each moving link",
                "add an <inertial>",
            )


def _moving_depth(frames: list[Frame]) -> list[int]:
    """How many moving joints lie between the base and each frame."""
    depth: list[int] = []
    for frame in frames:
        depth.append((depth[frame.parent] if frame.parent >= 0 else 0) + len(frame.joints))
    return depth


def _find(frames: list[Frame], tool: str) -> int:
    for i, frame in enumerate(frames):
        if frame.name == tool:
            return i
    names = _listed(frame.name for frame in frames if frame.name)
    raise DescriptionError(f"found no tool frame {quoted(tool)}; expected one of: {names}")


def _listed(names: Iterable[str]) -> str:
    """Names for a message, the first forty of them."""
    every = [quoted(name)[1:-1] for name in names]
    return ", ".join(every[:40]) + (f" and {len(every) - 40} more" if len(every) > 40 else "")
