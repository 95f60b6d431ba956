"""The return codes of Kinova's library as typed errors that say what to do."""

from __future__ import annotations

from burnish.errors import HardwareError


class VendorError(HardwareError):
    """A call to the vendor's library did not return its success, 1."""

    def __init__(self, call: str, code: int, text: str) -> None:
        super().__init__(text)
        self.call = call
        """The call that failed."""
        self.code = code
        """What it returned."""


class ConnectionLostError(VendorError):
    """The arm does not answer: unplugged, switched off, or its cable is bad."""


class NackError(VendorError):
    """The arm answered, and said no."""


class AccessError(VendorError):
    """The arm is there, but this process may not or cannot have it."""


class LibraryError(VendorError):
    """The library lacks a part of itself, or its parts do not belong together."""


class NotStartedError(VendorError):
    """A call came before the library or the arm was ready for it."""


class ArgumentRefusedError(VendorError):
    """The library does not take what it was given."""


class UnknownCodeError(VendorError):
    """A code that no header of the vendor explains."""


PLUG = "check the cable, the arm's power switch and its emergency stop, then connect anew"
PARTS = (
    "keep the command layer and the communication layer of one SDK in one folder, put that folder on LD_LIBRARY_PATH, "
    "and install libusb-1.0"
)
AGAIN = "end other programs that use the arm, switch it off and on, and connect anew"
REPEAT = "repeat the call; if it goes on, look at the arm's lamps and restart it"
LOAD = "the files of the SDK are damaged or incomplete: install it anew"

CODES: dict[int, tuple[type[VendorError], str, str]] = {
    1001: (LibraryError, "the communication layer could not load libusb", "install libusb-1.0 (apt: libusb-1.0-0)"),
    1002: (LibraryError, "the communication layer has no method to open the port", PARTS),
    1003: (LibraryError, "the communication layer has no method to write", PARTS),
    1004: (LibraryError, "the communication layer has no method to read", PARTS),
    1005: (LibraryError, "the communication layer has no method to read interrupts", PARTS),
    1006: (LibraryError, "the communication layer could not be unloaded", "end this process and start it anew"),
    1007: (ConnectionLostError, "the connection to the arm failed", PLUG),
    1008: (AccessError, "the arm's USB interface is claimed by somebody else", "end other programs that use the arm"),
    1009: (ConnectionLostError, "the device on the port is not known", PLUG),
    1010: (NotStartedError, "the communication layer was not started", "connect before anything else is called"),
    1011: (ConnectionLostError, "there is no such device on the bus any more", PLUG),
    1012: (AccessError, "the USB device is busy", "end other programs that use the arm"),
    1013: (AccessError, "the system does not support this USB operation", "see 'burnish doctor' for the udev rule"),
    1014: (ConnectionLostError, "a packet could not be sent, the reason is not known", PLUG),
    1015: (
        ConnectionLostError,
        "no arm was found",
        "check cable and power, and the permissions that 'burnish doctor' shows",
    ),
    1016: (ConnectionLostError, "an operation was not completed", REPEAT),
    1017: (ConnectionLostError, "the handle of the serial bus is invalid", PLUG),
    1018: (ConnectionLostError, "an operation on the serial bus is still pending", REPEAT),
    1019: (LibraryError, "the serial bus has not enough memory", "end this process and start it anew"),
    1020: (ConnectionLostError, "the serial bus timed out", PLUG),
    1021: (LibraryError, "this function is not accessible on this layer", "use the USB layer, or leave the call out"),
    1022: (ConnectionLostError, "the communication timed out", PLUG),
    2001: (NotStartedError, "the library could not be started", AGAIN),
    2002: (LibraryError, "the communication layer could not be loaded", PARTS),
    2003: (NackError, "the arm refused the first packet", REPEAT),
    2004: (ConnectionLostError, "the communication with the arm failed", PLUG),
    2005: (NackError, "the arm refused the command", REPEAT),
    2006: (LibraryError, "the communication layer has no method to start", PARTS),
    2007: (LibraryError, "the communication layer has no method to close", PARTS),
    2008: (LibraryError, "the communication layer has no method to count devices", PARTS),
    2009: (LibraryError, "the communication layer has no method to send packets", PARTS),
    2010: (LibraryError, "the communication layer has no method to choose a device", PARTS),
    2011: (LibraryError, "the communication layer has no method to list devices", PARTS),
    2012: (AccessError, "a semaphore of the library failed", AGAIN),
    2013: (ConnectionLostError, "the search for devices failed", PLUG),
    2014: (LibraryError, "the communication layer has no method to tell the active device", PARTS),
    2015: (AccessError, "the serial bus could not be opened for direct access", AGAIN),
    2100: (ArgumentRefusedError, "a parameter is invalid", "this is a fault of burnish: please report the call"),
    2101: (NotStartedError, "the library was not started", "connect before anything else is called"),
    2102: (NotStartedError, "the library could not set up its data", AGAIN),
    5001: (LibraryError, "a file of the library is not known", LOAD),
    5002: (LibraryError, "the library ran out of memory", "end this process and start it anew"),
    5003: (LibraryError, "a file of the library could not be read", LOAD),
    9999: (NackError, "the arm answered with a refusal", REPEAT),
    666: (UnknownCodeError, "an error that the vendor calls unknown", AGAIN),
}
"""Code to the kind of error, what it means, and what to do. The wording is ours: the headers give names only."""


def error_of(call: str, code: int) -> VendorError:
    """The error for a code that a call returned in place of 1."""
    kind, meaning, remedy = CODES.get(code, (UnknownCodeError, "a code that no header explains", AGAIN))
    return kind(call, code, f"{call}: {meaning} (code {code}); {remedy}")
