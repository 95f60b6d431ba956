"""Whether a robot description can be an arm, found out before any engine reads it.

An engine believes what it is given: a mass of −3 kg, an inertia that no body has, joint limits in the wrong order.
"""

from __future__ import annotations

from pathlib import Path

from burnish.errors import DescriptionError
from burnish.model import description_mjcf, description_urdf
from burnish.model.description_xml import quoted, read


def check_description(path: str | Path, tool: str | None = None) -> None:
    """Refuse a URDF or MJCF file that is not a fixed-base serial arm of physical links.

    Refused are, each with one line that says what was found, what was expected and what to do:

    - files that are missing, empty, binary, over 10 MiB, over 100 levels deep, with a DOCTYPE, or not well-formed;
    - numbers that are no numbers, NaN or infinite, or beyond 1e12, in the places that matter for the arm's motion and,
      for NaN and infinity, anywhere;
    - moving links with a mass ≤ 0, or an inertia that is not positive definite or against the triangle inequality;
    - joints with lower ≥ upper, a zero axis, or a type other than revolute, continuous, prismatic and fixed (hinge and
      slide in MJCF), and joints that mimic or are tied to others;
    - in an MJCF: macros and frames, two joints in one body, masses left to a mesh or changed by the compiler, an arm
      that is not in the first body of the world;
    - two links or two joints of one name, references to what is not there, links with two parents, loops, links that
      hang on nothing, and moving joints beside or beyond the one chain that leads to the tool;
    - a tool frame that does not exist: the message lists those that do.

    It takes well under 2 s and 1 GiB for any file. It does not look at meshes, and an engine may still refuse a file
    for reasons of its own.

    Args:
        path: the file; its root element says whether it is a URDF or an MJCF.
        tool: the tool frame: a link of a URDF, a body or site of an MJCF. None leaves it open; then all moving joints
            must still be on one chain.

    Raises:
        DescriptionError: if the description is refused.
    """
    try:
        root = read(path)
        if root.tag == "robot":
            description_urdf.check(root, tool)
        elif root.tag == "mujoco":
            description_mjcf.check(root, tool)
        else:
            raise DescriptionError(
                f"found the root element <{quoted(root.tag)}>; expected <robot> (URDF) or <mujoco> (MJCF): convert it"
            )
    except DescriptionError as error:
        name = str(path) if len(str(path)) <= 60 else Path(path).name
        raise DescriptionError(f"{quoted(name)}: {error}") from None
