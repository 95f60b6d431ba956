"""Where ROS 1 is: rospy comes from apt, not from pip, and a virtual environment does not see it."""

from __future__ import annotations

import sys
from importlib import import_module, invalidate_caches
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

from burnish.errors import HardwareError

PACKAGES = Path("/usr/lib/python3/dist-packages")
"""Where Debian and Ubuntu put the Python packages of their own Python."""
LIBRARIES = Path("/usr/lib")
"""Holds a folder ``pythonX.Y`` for the Python of the distribution."""
HOW_TO_GET_IT = "as root: apt install python3-rospy (Debian, Ubuntu), or start where ROS's setup.bash was sourced"


class RosMissingError(HardwareError):
    """There is no rospy that this Python can import; the text says how to get one."""


def rospy() -> ModuleType:
    """Import rospy.

    What the environment has comes first, and so does a PYTHONPATH that ROS has set. Only without a rospy there, the
    distribution's folder goes to the **end** of the search path: NumPy and all else stay the environment's own.

    Raises:
        RosMissingError: if there is none, or the distribution's is for another Python.
    """
    if find_spec("rospy") is None:
        sys.path.append(str(find()))
        invalidate_caches()
    return import_module("rospy")


def installed() -> Path:
    """The folder from which `rospy` would import it; nothing is imported.

    Raises:
        RosMissingError: if there is none.
    """
    own = find_spec("rospy")
    return find() if own is None or own.origin is None else Path(own.origin).parents[1]


def find(packages: Path = PACKAGES, libraries: Path = LIBRARIES) -> Path:
    """The distribution's folder, if it holds a rospy for this Python.

    Raises:
        RosMissingError: if it does not.
    """
    if not (packages / "rospy").is_dir():
        raise RosMissingError(f"rospy is not installed; {HOW_TO_GET_IT}")
    python = f"python{sys.version_info.major}.{sys.version_info.minor}"
    if not (libraries / python).is_dir():
        raise RosMissingError(
            f"the rospy in {packages} is not for {python}, which runs now; make the environment anew with the "
            "distribution's own python3"
        )
    return packages
