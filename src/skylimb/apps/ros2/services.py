"""Services of a node: orders, the life cycle, and what it flies with as parameters.

A reply finds its request by a field that Fast DDS adds to a sample and Cyclone cannot write. So services are
those of rclpy, where a ROS 2 is sourced (or its wheels are there); without it there are topics alone.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterable, Sequence
from importlib import import_module
from typing import Any

from skylimb.analysis.exchange.lab_topics import Topic
from skylimb.apps.ros.answers import END
from skylimb.apps.ros.asking import Calls
from skylimb.apps.ros.messages import Arrived

PARAMETERS = Topic("skylimb/parameters", "")
"""No topic: what is flown with, rows of `Parameter`."""

Parameter = tuple[str, Any, str, float | None, float | None]
"""Name, value, description, and the ends of its range where it has both."""


def _ros(name: str) -> Any:
    """A module of ROS 2, which no type checker finds where none is sourced."""
    return import_module(name)


class Services:
    """A node of rclpy, in a thread of its own.

    Args:
        profile: one of `PROFILES`.
        namespace: of the node.
        orders: that are services, each by the last word of its topic.

    Attributes:
        calls: that wait for an answer.

    Raises:
        ImportError: without rclpy.
    """

    def __init__(self, profile: str, namespace: str, orders: Sequence[Topic]) -> None:
        rclpy, lifecycle = _ros("rclpy"), _ros("rclpy.lifecycle")
        rclpy.init(args=[], signal_handler_options=_ros("rclpy.signals").SignalHandlerOptions.NO)
        self.calls = calls = Calls()
        done = lifecycle.TransitionCallbackReturn

        class Node(lifecycle.LifecycleNode):
            def on_deactivate(self, state: Any) -> Any:
                """Refused: who wants a flight to rest lands it."""
                return done.FAILURE

            def on_shutdown(self, state: Any) -> Any:
                """As Ctrl-C does, it lands first."""
                calls.add(Arrived(END, None, "life cycle", time.monotonic()))
                return done.SUCCESS

        self._node = Node(f"skylimb_{profile}", namespace=namespace.strip("/"))
        for topic in orders:
            name = topic.name.rpartition("/")[2]
            self._node.create_service(_ros("std_srvs.srv").Trigger, f"~/{name}", self._asking(topic.name))
        self._node.trigger_configure()
        self._node.trigger_activate()
        threading.Thread(target=rclpy.spin, args=[self._node], daemon=True).start()

    def declare(self, parameters: Iterable[Parameter]) -> None:
        """Say what is flown with: described, within its range, and not to be changed in flight."""
        messages = _ros("rcl_interfaces.msg")
        for name, value, meaning, low, high in parameters:
            told = messages.ParameterDescriptor(description=meaning, read_only=True)
            if low is not None and high is not None and isinstance(value, float):
                told.floating_point_range = [messages.FloatingPointRange(from_value=low, to_value=high)]
            elif low is not None and high is not None and isinstance(value, int):
                told.integer_range = [messages.IntegerRange(from_value=int(low), to_value=int(high))]
            self._node.declare_parameter(name, value, told)

    def _asking(self, topic: str) -> Callable[[Any, Any], Any]:
        """What hands an order on, and waits for what comes of it."""

        def ask(request: Any, response: Any) -> Any:
            response.success, response.message = self.calls.ask(topic)
            return response

        return ask
