"""`canwire campaign`: play a function with a Lab thousands of times, with seeds and parameters, on all processors.

canwire campaign flips.py                              once for each value of its lists
canwire campaign flips.py --runs 10000 --workers 8     so many runs, so many processes
canwire campaign flips.py --results flips.parquet      one row a run: parameters, verdict, figures
canwire campaign flips.py --report flips.xml           the same as JUnit XML, for a build server
canwire campaign flips.py --report flips.html          a page: which parameters fail, durations, the first failures
canwire campaign flips.py --time-limit 60              a run that takes longer is ended, the others go on
canwire campaign flips.py --repeat 4711 --log run.log  one run again, byte for byte
canwire campaign flips.py --cluster dask://lab:8786    the same on a Dask cluster

FILE.py has a function under @canwire.campaign(...), which says what is varied. Runs that are done are kept in a journal
beside --results until all are: after Ctrl-C or a kill the same command plays only those that are missing. Exit status 1
if any run did not pass.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from canwire import CampaignRun, repeat_run, run_campaign
from canwire.commands.campaign.progress import Progress

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
    parser.add_argument("--quiet", action="store_true", help="show nothing of how far it is")
    parser.add_argument("--log", metavar="FILE", help="with --repeat: its frames, as a candump log")


def run(arguments: argparse.Namespace) -> int:
    """Play, and print the account."""
    if arguments.repeat is not None:
        return _again(arguments)
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
    return 1 if bad else 0


def _again(arguments: argparse.Namespace) -> int:
    one, log = repeat_run(
        arguments.file, arguments.repeat, seed=arguments.seed, time_limit=arguments.time_limit
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


def _line(one: CampaignRun) -> str:
    parameters = " ".join(f"{name}={value}" for name, value in one.parameters.items())
    return " ".join(filter(None, [f"run {one.number}", f"({parameters})", one.verdict])) + (
        f": {one.reason}" if one.reason else ""
    )
