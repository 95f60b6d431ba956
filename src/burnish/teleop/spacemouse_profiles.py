"""The six-axis mice that are known by their USB numbers: name, full scale, signs of the axes, and buttons.

All of them count in the frame of the HID standard: x to the right, y towards the operator, z down. A half turn about
x takes it to the operator's frame. The full scale of the hardware is about 350 counts, on all of them.

Source: USB numbers as spacenavd 1.3 and pyspacemouse 2.1 list them; frame of the USB HID usage tables, section 4.2;
buttons as pyspacemouse 2.1 found them. Only the numbers are taken. We have had none of these devices at hand.
"""

from __future__ import annotations

from dataclasses import dataclass

from burnish.teleop.device import Axes

LOGITECH, CONNEXION = 0x046D, 0x256F
"""USB vendors: 3Dconnexion's devices were sold under the first until about 2014."""
FULL_SCALE = 350.0
"""Counts at the end of an axis."""
HALF_TURN_ABOUT_X: Axes = (1.0, -1.0, -1.0, 1.0, -1.0, -1.0)
"""HID axes to the operator's."""
PRO = (0, 1, 2, 4, 5, 8, 12, 13, 14, 15, 22, 23, 24, 25, 26)
"""Bits of a SpaceMouse Pro: menu, fit, top, right, front, roll, 1 to 4, esc, alt, shift, ctrl, lock of rotation."""
ENTERPRISE = (0, 1, 2, 4, 5, 8, 10, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26)
PILOT_PRO = (0, 1, 2, 4, 5, 8, 10, 14, 15, 16, 17, 18, 22, 23, 24, 25, 26, 27, 28, 29, 30)


@dataclass(frozen=True, kw_only=True)
class Profile:
    """A model."""

    name: str
    vendor: int
    """USB vendor."""
    product: int
    """USB product."""
    button_bits: tuple[int, ...]
    """Which bit of the button report each button is, in rising order: spacenavd numbers them the same way."""
    full_scale: float = FULL_SCALE
    """Counts that are ±1."""
    signs: Axes = HALF_TURN_ABOUT_X
    """What each of the six values, in the order in which they are sent, is multiplied with."""


def _model(vendor: int, product: int, name: str, buttons: int | tuple[int, ...]) -> Profile:
    bits = tuple(range(buttons)) if isinstance(buttons, int) else buttons
    return Profile(name=name, vendor=vendor, product=product, button_bits=bits)


PROFILES = (
    _model(CONNEXION, 0xC62E, "SpaceMouse Wireless, cabled", 2),
    _model(CONNEXION, 0xC62F, "SpaceMouse Wireless, receiver", 2),
    _model(CONNEXION, 0xC631, "SpaceMouse Pro Wireless, cabled", PRO),
    _model(CONNEXION, 0xC632, "SpaceMouse Pro Wireless, receiver", PRO),
    _model(CONNEXION, 0xC633, "SpaceMouse Enterprise", ENTERPRISE),
    _model(CONNEXION, 0xC635, "SpaceMouse Compact", 2),
    _model(CONNEXION, 0xC636, "SpaceMouse Module", 0),
    _model(CONNEXION, 0xC638, "SpaceMouse Pro Wireless BT", PRO),
    _model(CONNEXION, 0xC63A, "SpaceMouse Wireless BT", 2),
    _model(CONNEXION, 0xC641, "SpaceMouse Module USB", 0),
    # A Pro and a plain mouse may be behind it; the buttons of the plain one are the first two of the Pro.
    _model(CONNEXION, 0xC652, "3Dconnexion Universal Receiver", PRO),
    _model(LOGITECH, 0xC603, "SpaceMouse Plus XT", 11),
    _model(LOGITECH, 0xC605, "CadMan", 4),
    _model(LOGITECH, 0xC606, "SpaceMouse Classic", 8),
    _model(LOGITECH, 0xC621, "Spaceball 5000", 12),
    _model(LOGITECH, 0xC623, "SpaceTraveler", 8),
    _model(LOGITECH, 0xC625, "SpacePilot", 21),
    _model(LOGITECH, 0xC626, "SpaceNavigator", 2),
    _model(LOGITECH, 0xC627, "SpaceExplorer", 15),
    _model(LOGITECH, 0xC628, "SpaceNavigator for Notebooks", 2),
    _model(LOGITECH, 0xC629, "SpacePilot Pro", PILOT_PRO),
    _model(LOGITECH, 0xC62B, "SpaceMouse Pro", PRO),
)


def profile(vendor: int, product: int) -> Profile | None:
    """The model with these USB numbers; None for what is no six-axis mouse that we know."""
    return next((known for known in PROFILES if (known.vendor, known.product) == (vendor, product)), None)
