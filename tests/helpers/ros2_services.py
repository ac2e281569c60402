"""Calls the services of a node, as a program for a Python with rclpy; says what they answered.

python ros2_services.py NODE OUT.json
"""

from __future__ import annotations

import json
import sys
import time
from importlib import import_module
from pathlib import Path
from typing import Any

rclpy: Any = import_module("rclpy")
LEAVE = 7
"""lifecycle_msgs/Transition: from active to its end."""


def main(name: str, out: Path) -> None:
    rclpy.init()
    node = rclpy.create_node("asking")

    def ask(package: str, kind: str, service: str, **fields: Any) -> Any:
        form = getattr(import_module(f"{package}.srv"), kind)
        client = node.create_client(form, f"{name}/{service}")
        assert client.wait_for_service(90.0), service
        future = client.call_async(form.Request(**fields))
        rclpy.spin_until_future_complete(node, future, timeout_sec=30.0)
        return future.result()

    def order(word: str) -> tuple[bool, str]:
        answer = ask("std_srvs", "Trigger", word)
        return answer.success, answer.message

    said: dict[str, Any] = {"early": order("takeoff"), "start": order("start")}
    time.sleep(1.0)
    said["takeoff"] = order("takeoff")
    said["state"] = ask("lifecycle_msgs", "GetState", "get_state").current_state.label
    said["names"] = ask("rcl_interfaces", "ListParameters", "list_parameters").result.names
    asked = {"names": ["plant.mass_scale"]}
    (told,) = ask("rcl_interfaces", "DescribeParameters", "describe_parameters", **asked).descriptors
    said["described"] = told.description
    said["range"] = [[one.from_value, one.to_value] for one in told.floating_point_range]
    (value,) = ask("rcl_interfaces", "GetParameters", "get_parameters", **asked).values
    parameter = import_module("rcl_interfaces.msg").Parameter(name="plant.mass_scale", value=value)
    (result,) = ask("rcl_interfaces", "SetParameters", "set_parameters", parameters=[parameter]).results
    said["value"], said["set"] = value.double_value, (result.successful, result.reason)
    transition = import_module("lifecycle_msgs.msg").Transition(id=LEAVE)
    said["left"] = ask("lifecycle_msgs", "ChangeState", "change_state", transition=transition).success
    out.write_text(json.dumps(said), encoding="utf-8")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
