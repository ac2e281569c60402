"""Measure what docs/reports/benchmarks.md says, and write it around pages/benchmarks.md.

make bench-page          (a quarter of an hour on two idle cores, more where rivals are installed first)
python benchmarks/speed.py --flights 100 --repeats 2 --out out/speed          (a first look)
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import os
import platform
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import campaign
import compare
import loop
import native
import own_python

from skylimb.analysis.recording.versions import versions

HERE = Path(__file__).parent
DOCS = HERE.parent / "docs"
EXPERIMENT, CONTROLLER = "paper", "hybrid"


def measure(flights: int, repeats: int, before: Mapping[str, Any] | None) -> dict[str, Any]:
    """Everything, as plain tables; the rivals are those of `before`, where it is given."""
    where = machine()
    _, python = loop.measure(EXPERIMENT, CONTROLLER, repeats)
    plain, law, replayed = own_python.measure(repeats)
    found = native.measure(EXPERIMENT, CONTROLLER, 12, repeats)
    many = campaign.measure(flights)
    return {
        "machine": where,
        "versions": versions(),
        "python": {
            **dataclasses.asdict(python),
            "ratio": python.ratio,
            "strict": python.strict,
            "tick": python.tick,
        },
        "own_python": {"closed": plain, "raw": replayed, "ratio": plain / replayed},
        "own_law": {"closed": law, "raw": replayed, "ratio": law / replayed},
        "native": {**dataclasses.asdict(found), "ratio": found.ratio, "strict": found.strict},
        "campaign": {**dataclasses.asdict(many), "scaling": many.scaling},
        "rivals": compare.measure(min(repeats, 3)) if before is None else before.get("rivals", []),
        "rivals_machine": where if before is None else before.get("rivals_machine", before.get("machine")),
    }


def machine() -> dict[str, Any]:
    """What it was measured on; nothing that names the machine itself."""
    model = platform.processor() or platform.machine()
    listing = Path("/proc/cpuinfo")
    if listing.is_file():
        names = [
            line.partition(":")[2].strip()
            for line in listing.read_text().splitlines()
            if "model name" in line
        ]
        model = names[0] if names else model
    return {
        "processor": model,
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.release().partition('-')[0]}",
        "python": platform.python_version(),
        "load": round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None,
    }


def places(data: Mapping[str, Any]) -> dict[str, str]:
    """Name of a place in the page -> its text."""
    found, where = data["native"], data["machine"]
    ticks = f"{found['ticks']} control ticks of {found['substeps']} physics steps"
    cores, load = f"{where['cores']} cores of {where['processor']}", f"load before the run {where['load']}"
    return {
        "MACHINE": f"{cores}, {where['system']}, Python {where['python']}; {load}",
        "VERSIONS": ", ".join(f"{name} {version}" for name, version in data["versions"].items()),
        "FLIGHT": f"{found['flown']:.1f} s in {ticks}",
        "WANTED_TABLE": "\n".join(wanted(data)),
        "PARTS_TABLE": "\n".join(parts(data)),
        "CAMPAIGN_SIZE": f"{data['campaign']['two']['flights']} of the paper's flights",
        "CAMPAIGN_TABLE": "\n".join(campaigns(data)),
        "RIVALS_DESCRIBED": "\n".join(compare.described(data["rivals"])),
        "RIVALS_TABLE": "\n".join(compare.table(data["rivals"])),
        "RIVALS_LOAD": f"{(data['rivals_machine'] or where)['load']}",
    }


def wanted(data: Mapping[str, Any]) -> list[str]:
    """Each figure beside what is wanted of it."""
    found, many = data["native"], data["campaign"]
    minutes = many["two"]["seconds"] / 60.0 * campaign.FLIGHTS_WANTED / many["two"]["flights"]
    threads = found["threads"]
    used = max(many["one"]["memory"], many["two"]["memory"])
    campaign_title = f"campaign: {campaign.FLIGHTS_WANTED} flights, two workers"
    rows = (
        ("Python driver: closed loop over raw replay", data["python"]["ratio"], loop.RATIO_WANTED, 1, ""),
        ("native driver: closed loop over raw replay", found["ratio"], native.RATIO_WANTED, 1, ""),
        ("native driver: two threads over one", threads[1] / threads[2], native.SCALING_WANTED, 1, ""),
        *(
            (
                f"a Python {what} of 20 us a tick: flight over raw replay, in time",
                data[key]["ratio"],
                own_python.WANTED,
                -1,
                "",
            )
            for what, key in (("controller", "own_python"), ("law in a slot", "own_law"))
            if key in data  # older figures have no law
        ),
        ("campaign: two workers over one", many["scaling"], campaign.SCALING_WANTED, 1, ""),
        (
            campaign_title,
            minutes,
            campaign.MINUTES_WANTED,
            -1,
            " min",
        ),
        ("campaign: memory of a worker", used, campaign.MEMORY_WANTED, -1, " MB"),
    )
    lines = ["| | measured | wanted | |", "|---|---|---|---|"]
    for name, value, bound, sign, unit in rows:
        word = "at least" if sign > 0 else "at most"
        verdict = "" if sign * value >= sign * bound else "**short**"
        lines.append(f"| {name} | {value:.3g}{unit} | {word} {bound:g}{unit} | {verdict} |")
    alone = campaign.FLIGHTS_WANTED * found["bare"] / 2.0 / 60.0
    lines.append(
        f"| the physics alone of {campaign.FLIGHTS_WANTED} flights, on two cores | {alone:.3g} min | | |"
    )
    for name, figures in (("Python", data["python"]), ("native", found)):
        lines.append(
            f"| {name} driver: closed loop over a replay without clock | {figures['strict']:.3g} | | |"
        )
    return lines


def parts(data: Mapping[str, Any]) -> list[str]:
    """What a flight costs, ms, with both drivers."""
    python, found = data["python"], data["native"]
    flown, ticks = found["flown"], found["ticks"]
    rows = (
        ("Python driver, closed loop", python["closed"]),
        ("raw replay from Python", python["raw"]),
        ("raw replay from Python, without clock", python["bare"]),
        ("native driver, closed loop (processor time)", found["closed"]),
        ("raw replay in C (processor time)", found["raw"]),
        ("raw replay in C, without clock (processor time)", found["bare"]),
        ("native, 12 at once on one thread", found["threads"][1]),
        ("native, 12 at once on two threads", found["threads"][2]),
        ("before: scene, mission, noise", found["before"]),
        ("after: log and metrics", found["after"]),
    )
    lines = ["| | ms a flight | us a tick | times real time | flights a minute |", "|---|---|---|---|---|"]
    for name, seconds in rows:
        tail = "" if name.startswith(("before", "after")) else f"{flown / seconds:.0f}"
        each = "" if not tail else f"{60 / seconds:.0f}"
        lines.append(f"| {name} | {1e3 * seconds:.0f} | {1e6 * seconds / ticks:.1f} | {tail} | {each} |")
    lines += ["", f"The controller's tick alone, from Python: {1e6 * python['tick']:.2f} us."]
    return lines


def campaigns(data: Mapping[str, Any]) -> list[str]:
    """Rate, time and memory by workers."""
    lines = ["| workers | flights | time | flights a minute | memory of a worker |", "|---|---|---|---|---|"]
    for count, name in ((1, "one"), (2, "two")):
        flown = data["campaign"][name]
        lines.append(
            f"| {count} | {flown['flights']} | {flown['seconds']:.0f} s | {60 * flown['rate']:.0f} "
            f"| {flown['memory']:.0f} MB |"
        )
    return lines


def main() -> int:
    """Measure and write; 1 when a figure falls short."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--flights", type=int, default=campaign.FLIGHTS_WANTED)
    parser.add_argument("--repeats", type=int, default=7)
    parser.add_argument("--no-rivals", action="store_true", help="keep what is known of the others")
    parser.add_argument("--out", type=Path, default=DOCS, help="folder of page and figures")
    options = parser.parse_args()
    known = options.out / "benchmarks.json"
    before = json.loads(known.read_text(encoding="utf-8")) if known.is_file() else {}
    data = measure(options.flights, options.repeats, before if options.no_rivals else None)
    page = (HERE / "pages" / "benchmarks.md").read_text(encoding="utf-8")
    for place, text in places(data).items():
        page = page.replace(place, text)
    (options.out / "reports").mkdir(parents=True, exist_ok=True)
    (options.out / "benchmarks.json").write_text(json.dumps(data, indent=2) + "\n", encoding="utf-8")
    (options.out / "reports" / "benchmarks.md").write_text(page, encoding="utf-8")
    return 1 if any("**short**" in line for line in wanted(data)) else 0


if __name__ == "__main__":
    raise SystemExit(main())
