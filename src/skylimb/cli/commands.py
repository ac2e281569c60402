"""The verbs: each a record of its options that does its work when called and returns the exit code."""

from __future__ import annotations

from typing import Any

from skylimb.cli.calibrating import Calibrate
from skylimb.cli.converting import Convert
from skylimb.cli.drawing import Draw
from skylimb.cli.exporting import ExportC
from skylimb.cli.flying import Compare, Run
from skylimb.cli.looking import List, Report, Show, VerifyContact, View
from skylimb.cli.realtime import Fly
from skylimb.cli.replaying import Replay
from skylimb.cli.ros import Ros
from skylimb.cli.studio import Studio

VERBS: dict[str, Any] = {
    "run": Run,
    "compare": Compare,
    "draw": Draw,
    "calibrate": Calibrate,
    "studio": Studio,
    "list": List,
    "show": Show,
    "report": Report,
    "view": View,
    "verify-contact": VerifyContact,
    "fly": Fly,
    "ros": Ros,
    "replay": Replay,
    "convert": Convert,
    "export-c": ExportC,
}
