"""ROS itself: this process as a node, the classes of the messages, and services that may not answer."""

from __future__ import annotations

import logging
import threading
from functools import cache
from importlib import import_module
from typing import Any

from burnish.errors import HardwareError
from burnish.hardware.kinova_codes import VendorError
from burnish.hardware.ros1_messages import Types, build

NODE = "burnish"


class DriverError(VendorError):
    """kinova-ros is not there, does not answer, or has fallen silent; ``call`` is the topic or service, the code 0."""

    def __init__(self, call: str, text: str) -> None:
        super().__init__(call, 0, text)


@cache
def types() -> Types:
    """The classes of all messages and services, built once in a process."""
    return build()


def start_node(ros: Any) -> None:
    """Make this process a node of ROS, once.

    Raises:
        DriverError: if there is no master.
    """
    graph = import_module("rosgraph")
    uri = graph.get_master_uri()
    if not graph.is_master_online():
        raise DriverError("master", f"no ROS master at {uri}; start roscore, or set ROS_MASTER_URI")
    if ros.core.is_initialized():
        return
    root = logging.getLogger()
    before = root.level, list(root.handlers)
    try:
        # Ctrl-C stays ours: the arm is left safe first.
        ros.init_node(NODE, argv=[], anonymous=True, disable_signals=True)
    except ros.ROSException as error:
        raise HardwareError(f"this process cannot become a ROS node: {error}") from error
    finally:
        # rospy takes the logging of the whole process for itself.
        for handler in root.handlers:
            if handler not in before[1]:
                handler.close()
        root.setLevel(before[0])
        root.handlers[:] = before[1]


def ask(ros: Any, service: str, kind: Any, *request: Any, patience: float, believed: bool) -> None:
    """Call a service, which rospy itself would wait for without end.

    Args:
        ros: rospy.
        service: its whole name.
        kind: its class.
        request: the fields of the request.
        patience: longest wait [s].
        believed: whether an answer that it failed is an error; else only a service that cannot be reached is one.

    Raises:
        DriverError: if there is no answer, or a bad one that is believed.
    """
    problem: list[Exception] = []
    proxy = ros.ServiceProxy(service, kind)

    def call() -> None:
        try:
            proxy(*request)
        except (ros.ServiceException, ros.ROSException, OSError) as error:
            problem.append(error)

    asking = threading.Thread(target=call, daemon=True)
    asking.start()
    asking.join(patience)
    if asking.is_alive():
        raise DriverError(service, f"{service} did not answer within {patience:g} s; restart the driver")
    if problem and (believed or not _answered(problem[0])):
        raise DriverError(service, f"{service}: {problem[0]}; look at what the driver printed")


def _answered(error: Exception) -> bool:
    """Whether a service was reached, and said that it failed or nothing at all."""
    return "responded with an error" in str(error)
