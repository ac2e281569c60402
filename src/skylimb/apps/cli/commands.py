"""The verbs: each a record of its options that does its work when called and returns the exit code."""

from __future__ import annotations

from typing import Any

from skylimb.apps.cli.calibrating import Calibrate
from skylimb.apps.cli.converting import Convert
from skylimb.apps.cli.drawing import Draw
from skylimb.apps.cli.exporting import ExportC
from skylimb.apps.cli.flying import Compare, Run
from skylimb.apps.cli.looking import List, Report, Show, VerifyContact, View
from skylimb.apps.cli.realtime import Fly
from skylimb.apps.cli.replaying import Replay
from skylimb.apps.cli.ros import Ros
from skylimb.apps.cli.studio import Studio

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
