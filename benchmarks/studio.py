"""How well the studio keeps time: late ticks, updates, how soon a gain acts, the first picture, memory.

    python benchmarks/studio.py --seconds 60        (--seconds 3600 for an hour)

A studio runs as a user's would, in a process of its own, with its page open in a headless Chromium that draws in
software. Beside it a second page, without a picture, counts what arrives. Flights follow each other.
"""

from __future__ import annotations

import argparse
import json
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from playwright import sync_api
from rich.console import Console
from rich.table import Table
from websockets.sync.client import ClientConnection, connect

BROWSERS = ("chromium", "chromium-browser", "google-chrome")
ARGUMENTS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
GAIN = "controller.translation.normalized_stiffness"
BEFORE, AFTER = [2.5, 2.5, 1.5], [3.0, 3.0, 2.0]
REPEATS = 15


@dataclass
class Found:
    """What was measured."""

    first_picture: float = 0.0
    ticks: int = 0
    late: int = 0
    updates: float = 0.0
    drawn: float = 0.0
    numbers: int = 0
    latencies: list[float] = field(default_factory=list)
    memory: list[float] = field(default_factory=list)
