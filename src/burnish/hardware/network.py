"""Addresses of an arm on the network."""

from __future__ import annotations

import socket
import struct
from dataclasses import dataclass

from burnish.errors import InputError
from burnish.hardware.kinova_types import EthernetCommConfig


@dataclass(frozen=True, kw_only=True)
class Network:
    """Addresses of an arm on the network; the defaults are those of kinova-ros."""

    robot: str = "192.168.100.11"
    local: str = "192.168.100.100"
    mask: str = "255.255.255.0"
    robot_port: int = 55000
    local_port: int = 25000
    broadcast_port: int = 25025
    timeout: float = 1.0
    """Longest wait for an answer [s]."""

    def __post_init__(self) -> None:
        for text in (self.robot, self.local, self.mask):
            try:
                socket.inet_aton(text)
            except OSError:
                raise InputError(f"Network: '{text}' is no IPv4 address; expected one such as 192.168.100.11") from None
        if not 0.001 <= self.timeout <= 60.0:
            raise InputError(f"Network: timeout {self.timeout} s; expected 0.001 to 60 s")

    def configuration(self) -> EthernetCommConfig:
        """The same as the vendor wants it: addresses as 32 bits in network order, the time in ms."""

        def address(text: str) -> int:
            return int(struct.unpack("=I", socket.inet_aton(text))[0])

        return EthernetCommConfig(
            localIpAddress=address(self.local),
            subnetMask=address(self.mask),
            robotIpAddress=address(self.robot),
            localCmdport=self.local_port,
            localBcastPort=self.broadcast_port,
            robotPort=self.robot_port,
            rxTimeOutInMs=round(1000.0 * self.timeout),
        )
