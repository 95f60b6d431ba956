"""The vendor's library: found, loaded, its layout and layer recognised, and every call checked."""

from __future__ import annotations

import ctypes
import os
from collections.abc import Mapping
from ctypes import POINTER, c_float, c_int
from pathlib import Path
from typing import Any

from burnish.errors import HardwareError
from burnish.hardware.kinova_codes import error_of
from burnish.hardware.kinova_types import (
    ETHERNET_PREFIX,
    MOST_DEVICES,
    SEVEN_ACTUATOR_SYMBOL,
    SUCCESS,
    EthernetCommConfig,
    KinovaDevice,
    Layout,
    TrajectoryFifo,
)

VARIABLE = "BURNISH_KINOVA_LIB"
"""Environment variable with the path of the command layer."""
FOLDERS = ("/usr/lib", "/usr/local/lib", "/opt/kinova/usr/lib", "/opt/kinova/lib")
"""Where the vendor's installers put the library; the last two are guesses."""
NAMES = (
    "Kinova.API.USBCommandLayerUbuntu.so",
    "USBCommandLayerUbuntu.so",
    "Kinova.API.EthCommandLayerUbuntu.so",
    "EthCommandLayerUbuntu.so",
)
"""The command layer as the SDK names it and as kinova-ros does, USB first."""
HOW_TO_GET_IT = (
    "install Kinova's JACO2 SDK, or take the command and the communication layer from kinova_driver/lib of "
    f"github.com/Kinovarobotics/kinova-ros, and name the file in {VARIABLE} or with --lib"
)
REFUSAL_IS_NO_ERROR = frozenset({"SetGravityType", "SetGravityOptimalZParam", "SetGravityPayload"})
"""Calls that return 2005 although they worked; kinova-ros takes it for a success as well."""
REFUSED = 2005


class LibraryMissingError(HardwareError):
    """The vendor's library is not there, or is no such library."""


class Library:
    """Kinova's command layer. `call` raises unless the vendor says 1."""

    def __init__(self, path: str | Path) -> None:
        """Load the library at ``path``.

        Raises:
            LibraryMissingError: if it cannot be loaded, or is not a command layer.
        """
        self.path = Path(path)
        folder = self.path.parent
        try:
            # The command layer looks for its neighbour by a bare name; loaded before, it is found in any folder.
            for neighbour in sorted(folder.glob("*CommLayerUbuntu.so")) if len(folder.parts) > 1 else ():
                ctypes.CDLL(str(neighbour), mode=ctypes.RTLD_GLOBAL)
            library = ctypes.CDLL(str(path))
        except OSError as error:
            raise LibraryMissingError(f"Kinova's library {path} cannot be loaded ({error}); {HOW_TO_GET_IT}") from error
        self.ethernet = hasattr(library, f"{ETHERNET_PREFIX}GetDevices")
        """Whether this is the layer for the network; else it is the one for USB."""
        prefix = ETHERNET_PREFIX if self.ethernet else ""
        if not hasattr(library, f"{prefix}GetDevices"):
            raise LibraryMissingError(
                f"{path} exports no GetDevices, so it is not a command layer of Kinova; {HOW_TO_GET_IT}"
            )
        self.layout = Layout.of(7 if hasattr(library, prefix + SEVEN_ACTUATOR_SYMBOL) else 6)
        self._functions = {
            name: _typed(getattr(library, prefix + name), arguments)
            for name, arguments in signatures(self.layout).items()
            if hasattr(library, prefix + name)
        }

    def call(self, name: str, *arguments: Any) -> None:
        """Call by the name without prefix.

        Raises:
            VendorError: if it returns anything but 1; a NACK of a gravity setting is none.
            LibraryMissingError: if this library does not export it.
        """
        try:
            code = self._functions[name](*arguments)
        except KeyError:
            raise LibraryMissingError(
                f"{self.path} does not export {name}; it is too old or too new: {HOW_TO_GET_IT}"
            ) from None
        if code != SUCCESS and not (code == REFUSED and name in REFUSAL_IS_NO_ERROR):
            raise error_of(name, code)

    def devices(self) -> list[Any]:
        """The structs of all connected arms.

        Raises:
            VendorError: if the search fails.
        """
        table, result = (KinovaDevice * MOST_DEVICES)(), c_int(0)
        # Of all calls this one alone returns a number of devices, and its code through the pointer.
        count = self._functions["GetDevices"](table, ctypes.byref(result))
        if result.value != SUCCESS:
            raise error_of("GetDevices", result.value)
        return list(table[: max(count, 0)])


def signatures(layout: Layout) -> Mapping[str, tuple[Any, ...]]:
    """Name of each call that burnish uses to the types of its arguments; all return an int."""
    floats, integers, angles = POINTER(c_float), POINTER(c_int), POINTER(layout.AngularPosition)
    without = "InitAPI CloseAPI StartControlAPI StopControlAPI SetAngularControl MoveHome InitFingers"
    gives_angles = "GetAngularPosition GetAngularVelocity GetAngularForce GetAngularCommand"
    takes_floats = (
        "SendAngularTorqueCommand SetTorqueActuatorGain SetTorqueActuatorDamping GetAngularTorqueGravityEstimation "
        "SetGravityOptimalZParam SetGravityPayload"
    )
    takes_integer = (
        "SwitchTrajectoryTorque SetTorqueControlType SetTorqueInactivityType SetGravityType SetTorqueZero SetJointZero"
    )
    return {
        "GetDevices": (POINTER(KinovaDevice), integers),
        "SetActiveDevice": (KinovaDevice,),
        "InitEthernetAPI": (POINTER(EthernetCommConfig),),
        "GetAPIVersion": (integers,),
        "GetCodeVersion": (integers,),
        "GetTrajectoryTorqueMode": (integers,),
        "GetGlobalTrajectoryInfo": (POINTER(TrajectoryFifo),),
        "SendBasicTrajectory": (layout.TrajectoryPoint,),
        "EraseAllTrajectories": (),
        "SetTorqueSafetyFactor": (c_float,),
        "SetTorqueVibrationController": (c_float,),
        "SetAngularTorqueMinMax": (layout.AngularInfo, layout.AngularInfo),
        **dict.fromkeys(without.split(), ()),
        **dict.fromkeys(gives_angles.split(), (angles,)),
        **dict.fromkeys(takes_floats.split(), (floats,)),
        **dict.fromkeys(takes_integer.split(), (c_int,)),
    }


def find(given: str | Path | None = None) -> Path:
    """The path of the command layer: as given, from the environment, or in the vendor's usual places.

    Raises:
        LibraryMissingError: if it is in none of them.
    """
    named = given or os.environ.get(VARIABLE)
    if named:
        if not Path(named).is_file():
            raise LibraryMissingError(f"there is no file {named}, which was to be Kinova's library; {HOW_TO_GET_IT}")
        return Path(named)
    for path in (Path(folder, name) for name in NAMES for folder in FOLDERS):
        if path.is_file():
            return path
    raise LibraryMissingError(f"Kinova's library is not in {', '.join(FOLDERS)}; {HOW_TO_GET_IT}")


def _typed(function: Any, arguments: tuple[Any, ...]) -> Any:
    """A foreign function with its types set."""
    function.argtypes, function.restype = arguments, c_int
    return function
