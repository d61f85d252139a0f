"""`canwire campaign`: play a function with a Lab thousands of times, with seeds and parameters, on all processors.

canwire campaign flips.py                              once for each value of its lists
canwire campaign flips.py --runs 10000 --workers 8     so many runs, so many processes
canwire campaign flips.py --results flips.parquet      one row a run: parameters, verdict, figures
canwire campaign flips.py --report flips.xml           the same as JUnit XML, for a build server
canwire campaign flips.py --report flips.html          a page: which parameters fail, durations, the first failures
canwire campaign flips.py --time-limit 60              a run that takes longer is ended, the others go on
canwire campaign flips.py --repeat 4711 --log run.log  one run again, byte for byte
canwire campaign flips.py --shrink                     of each failure the smallest cause: faults, frames, values
canwire campaign flips.py --repeat 4711 --shrink       the same of one run
canwire campaign flips.py --cluster dask://lab:8786    the same on a Dask cluster

FILE.py has a function under @canwire.campaign(...), which says what is varied. Runs that are done are kept in a journal
beside --results until all are: after Ctrl-C or a kill the same command plays only those that are missing. Exit status 1
if any run did not pass.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from canwire import BadValue, CampaignRun, repeat_run, run_campaign, shrink_run
from canwire.commands.campaign.progress import Progress

_TRIALS = 500
_SHOWN = 10  # runs that did not pass, in words


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """The verb's arguments."""
    parser.add_argument("file", metavar="FILE.py", help="the campaign")
    parser.add_argument("--runs", type=int, metavar="N", help="default: each value of its lists once")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the whole campaign (default: 1)")
    where = parser.add_mutually_exclusive_group()
    where.add_argument("--workers", type=int, metavar="N", help="processes (default: one a processor)")
    where.add_argument("--cluster", metavar="ADDRESS", help="a Dask scheduler instead, as dask://host:8786")
    where.add_argument("--repeat", type=int, metavar="RUN", help="play this one run again, here")
    parser.add_argument(
        "--time-limit", type=float, metavar="SECONDS", help="of each run: one that takes longer is ended"
    )
    parser.add_argument("--results", metavar="FILE", help="write the table, as .parquet or .csv")
    parser.add_argument("--report", metavar="FILE", help="write JUnit XML, as .xml, or a page, as .html")
    parser.add_argument(
        "--shrink", type=int, nargs="?", const=_TRIALS, metavar="RUNS",
        help=f"look for the smallest cause of a failure, with at most so many runs (default: {_TRIALS})",
    )  # fmt: skip
    parser.add_argument(
        "--set", action="append", default=[], metavar="NAME=VALUE", help="with --repeat: another parameter"
    )
    parser.add_argument(
        "--only", action="append", default=[], metavar="KIND=NUMBERS",
        help="with --repeat: of its frames, faults or bits of noise only these take place, as frames=3,7-9 or none",
    )  # fmt: skip
    parser.add_argument(
        "--flip", action="append", default=[], metavar="BUS:ID:BIT",
        help="with --repeat: invert this bit of the first frame with this identifier",
    )  # fmt: skip
    parser.add_argument("--quiet", action="store_true", help="show nothing of how far it is")
    parser.add_argument("--log", metavar="FILE", help="with --repeat: its frames, as a candump log")


def run(arguments: argparse.Namespace) -> int:
    """Play, and print the account."""
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
