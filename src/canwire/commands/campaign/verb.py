"""`canwire campaign`: run a function with a Lab thousands of times, with seeds and parameters, on all processors.

canwire campaign flips.py                              one run for each combination of its lists
canwire campaign flips.py --runs 10000 --workers 8     10,000 runs in 8 processes
canwire campaign flips.py --results flips.parquet      a table: parameters, verdict and figures of each run
canwire campaign flips.py --report flips.xml           the same as JUnit XML, for a build server
canwire campaign flips.py --report flips.html          a page: which parameters fail, durations, the first failures
canwire campaign flips.py --time-limit 60              end each run that takes longer than 60 s
canwire campaign flips.py --repeat 4711 --log run.log  repeat run 4711, byte for byte
canwire campaign flips.py --shrink                     find the smallest cause of each failure: faults, frames, values
canwire campaign flips.py --repeat 4711 --shrink       find it for run 4711 only
canwire campaign flips.py --cluster dask://lab:8786    run on a Dask cluster

FILE.py contains a function decorated with @canwire.campaign(...), which lists the parameters. With --results, finished
runs are kept in a journal next to that file until the campaign is complete: after Ctrl-C or a kill, the same command
runs only the missing ones. The exit status is 1 if any run did not pass.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from canwire import BadValue, CampaignRun, repeat_run, run_campaign, shrink_run
from canwire.commands.campaign.progress import Progress

_TRIALS = 500
_SHOWN = 10  # runs that did not pass, in words


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("file", metavar="FILE.py", help="the campaign")
    parser.add_argument(
        "--runs", type=int, metavar="N", help="number of runs (default: each combination of its lists once)"
    )
    parser.add_argument(
        "--seed", type=int, default=1, metavar="N", help="seed of the whole campaign (default: 1)"
    )
    where = parser.add_mutually_exclusive_group()
    where.add_argument(
        "--workers", type=int, metavar="N", help="number of processes (default: one for each processor)"
    )
    where.add_argument("--cluster", metavar="ADDRESS", help="use this Dask scheduler: dask://host:8786")
    where.add_argument("--repeat", type=int, metavar="RUN", help="repeat this run in this process")
    parser.add_argument("--time-limit", type=float, metavar="SECONDS", help="end each run that takes longer")
    parser.add_argument("--results", metavar="FILE", help="write a table of the runs: .parquet or .csv")
    parser.add_argument(
        "--report", metavar="FILE", help="write a report: .xml for JUnit XML, .html for a page"
    )
    parser.add_argument(
        "--shrink", type=int, nargs="?", const=_TRIALS, metavar="RUNS",
        help=f"find the smallest cause of each failure in at most RUNS runs (default: {_TRIALS})",
    )  # fmt: skip
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="with --repeat: change this parameter",
    )
    parser.add_argument(
        "--only", action="append", default=[], metavar="KIND=NUMBERS",
        help="with --repeat: keep only these frames, faults or bits of noise: frames=3,7-9, or frames=none",
    )  # fmt: skip
    parser.add_argument(
        "--flip", action="append", default=[], metavar="BUS:ID:BIT",
        help="with --repeat: invert this bit of the first frame with this identifier",
    )  # fmt: skip
    parser.add_argument("--quiet", action="store_true", help="do not show the progress")
    parser.add_argument(
        "--log", metavar="FILE", help="with --repeat: write the frames of the run as a candump log"
    )


def run(arguments: argparse.Namespace) -> int:
    """Run the campaign and print a summary; 1 if any run did not pass."""
    if arguments.repeat is not None:
        return _again(arguments) if arguments.shrink is None else _shrunk(arguments)
    if arguments.set or arguments.only or arguments.flip:
        raise BadValue("--set, --only and --flip change one run: give its number with --repeat")
    progress = Progress(arguments.runs, quiet=arguments.quiet)
    try:
        runs = run_campaign(
            arguments.file,
            runs=arguments.runs,
            seed=arguments.seed,
            workers=arguments.workers,
            cluster=arguments.cluster,
            results=arguments.results,
            time_limit=arguments.time_limit,
            report=arguments.report,
            shrink=arguments.shrink or 0,
            told=progress.count,
        )
    finally:
        progress.end()
    if kept := len(runs) - progress.done:
        print(f"{kept} runs were done before, {progress.done} were played now")
    bad = [one for one in runs if not one.passed]
    for one in bad[:_SHOWN]:
        print(_line(one))
    if len(bad) > _SHOWN:
        print(f"... and {len(bad) - _SHOWN} more")
    print(f"{len(runs)} runs: {len(runs) - len(bad)} passed, {len(bad)} did not")
    if bad:
        print(f"again: canwire campaign {arguments.file} --seed {arguments.seed} --repeat {bad[0].number}")
    for one in bad:
        if one.smallest:
            print(f"run {one.number} {one.smallest}")
    return 1 if bad else 0


def _shrunk(arguments: argparse.Namespace) -> int:
    if arguments.set or arguments.only or arguments.flip or arguments.log:
        raise BadValue("--shrink begins with the run as it was: without --set, --only, --flip and --log")
    smallest = shrink_run(
        arguments.file,
        arguments.repeat,
        seed=arguments.seed,
        most_runs=arguments.shrink,
        time_limit=arguments.time_limit,
    )
    print(_line(smallest.run))
    print(f"run {arguments.repeat} {smallest}")
    return 1


def _again(arguments: argparse.Namespace) -> int:
    one, log = repeat_run(
        arguments.file,
        arguments.repeat,
        seed=arguments.seed,
        time_limit=arguments.time_limit,
        given=dict(_pair(text, "--set") for text in arguments.set),
        only=dict(_pair(text, "--only") for text in arguments.only),
        flips=arguments.flip,
    )
    if arguments.log is not None:
        Path(arguments.log).write_text("".join(line + "\n" for line in log), encoding="utf-8", newline="\n")
    print(one.trace, end="")
    print(_line(one))
    for name, value in one.figures.items():
        print(f"  {name}: {value}")
    print(
        f"  {one.frames} frames, {one.error_frames} error frames in {one.bus_time_ns / 1e9:.6f} s; digest {one.digest}"
    )
    return 0 if one.passed else 1


def _pair(text: str, option: str) -> tuple[str, str]:
    name, equals, value = text.partition("=")
    if not equals:
        raise BadValue(f"{option} {text}: NAME=VALUE")
    return name, value


def _line(one: CampaignRun) -> str:
    parameters = " ".join(f"{name}={value}" for name, value in one.parameters.items())
    return " ".join(filter(None, [f"run {one.number}", f"({parameters})", one.verdict])) + (
        f": {one.reason}" if one.reason else ""
    )
