"""The results of a campaign as one HTML file: which parameters fail, durations, the first run of each failure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

from canwire.campaigns.junit import Played
from canwire.campaigns.playing import CampaignRun
from canwire.campaigns.shares import Parameter, parameters_of
from canwire.campaigns.whole import whole

_WIDTH, _ROW, _LEFT = 640, 22, 180  # pixels
_MOST_FAILURES = 20
_BARS = 20
_HEAD = """<!doctype html><html lang="en"><meta charset="utf-8"><title>{title}</title><style>
body {{ font: 15px/1.4 system-ui, sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em }}
pre {{ background: #f4f4f4; padding: .6em; overflow-x: auto }} svg text {{ font: 12px system-ui, sans-serif }}
.passed {{ fill: #5a9e6f }} .failed {{ fill: #c0392b }} .none {{ fill: #eeeeee }}
</style><h1>{title}</h1>
"""


def write_page(path: Path, played: Played, runs: Iterable[CampaignRun]) -> None:
    """Write the page, completely or not at all."""
    ordered = sorted(runs, key=lambda run: run.number)
    parameters = parameters_of(ordered)
    parts = [_HEAD.format(title=escape(f"Campaign {played.name}")), _summary(played, ordered)]
    if any(not run.passed for run in ordered):
        parts += ["<h2>Failures</h2>", *_failures(played, ordered)]
        parts += [_picture(one) for one in parameters]
    if len(parameters) > 1:
        parts.append(_map(parameters[0], parameters[1], ordered))
    parts.append(_durations(ordered))
    with whole(path) as part:
        part.write_text("\n".join(parts), encoding="utf-8", errors="backslashreplace", newline="\n")


def _summary(played: Played, runs: Sequence[CampaignRun]) -> str:
    verdicts = ", ".join(
        f"{count} {verdict}" for verdict, count in Counter(run.verdict for run in runs).items()
    )
    return (
        f"<p>{len(runs)} runs of <code>{escape(played.path)}</code> with seed {played.seed}: {verdicts}.</p>"
    )


def _failures(played: Played, runs: Sequence[CampaignRun]) -> list[str]:
    """List the first run of each failure reason, with the command that repeats it."""
    reasons = Counter((run.verdict, run.reason) for run in runs if not run.passed)
    first = {(run.verdict, run.reason): run for run in reversed(runs)}
    found = []
    for (verdict, reason), count in reasons.most_common(_MOST_FAILURES):
        run = first[verdict, reason]
        given = ", ".join(f"{name}={value}" for name, value in run.parameters.items())
        found.append(
            f"<h3>{escape(verdict)}: {escape(reason)}</h3><p>{count} runs; the first is run {run.number}, "
            f"{escape(given)}.</p><pre>{escape(played.repetition(run.number))}</pre>"
            + (f"<p>Its smallest cause:</p><pre>{escape(run.smallest)}</pre>" if run.smallest else "")
            + (
                f"<details><summary>trace</summary><pre>{escape(run.trace)}</pre></details>"
                if run.trace
                else ""
            )
        )
    if len(reasons) > _MOST_FAILURES:
        found.append(f"<p>{len(reasons) - _MOST_FAILURES} other reasons are in the table.</p>")
    return found


def _picture(parameter: Parameter) -> str:
    """Draw a bar for each class of a parameter's values: its runs, divided into passed and failed."""
    rows = []
    for place, (label, runs, failed) in enumerate(parameter.shares):
        width, y = round((_WIDTH - _LEFT - 120) * failed / runs), place * _ROW
        rows.append(
            f'<text x="0" y="{y + 15}">{escape(label)}</text>'
            f'<rect class="passed" x="{_LEFT}" y="{y + 3}" width="{_WIDTH - _LEFT - 120}" height="16"/>'
            f'<rect class="failed" x="{_LEFT}" y="{y + 3}" width="{width}" height="16"/>'
            f'<text x="{_WIDTH - 112}" y="{y + 15}">{failed} of {runs}</text>'
        )
    return f"<h2>By {escape(parameter.name)}</h2>" + _svg(rows, len(rows) * _ROW)


def _map(across: Parameter, down: Parameter, runs: Sequence[CampaignRun]) -> str:
    """Failures over the two parameters with the greatest influence: the more runs of a field fail, the redder it is."""
    cells: Counter[tuple[int, int]] = Counter()
    failed: Counter[tuple[int, int]] = Counter()
    for place in zip(runs, across.places, down.places, strict=True):
        cells[place[1:]] += 1
        failed[place[1:]] += not place[0].passed
    step = (_WIDTH - _LEFT) / len(across.shares)
    rows = []
    for y, share in enumerate(down.shares):
        rows.append(f'<text x="0" y="{y * _ROW + 15}">{escape(share.label)}</text>')
        for x, other in enumerate(across.shares):
            count, bad = cells[x, y], failed[x, y]
            told = f"{across.name} {other.label}, {down.name} {share.label}: {bad} of {count} failed"
            box = f'x="{_LEFT + x * step:.1f}" y="{y * _ROW + 1}" width="{step - 2:.1f}" height="{_ROW - 2}"'
            rows.append(
                f"<g><title>{escape(told)}</title>"
                f'<rect class="{"passed" if count else "none"}" {box}/>'
                f'<rect class="failed" opacity="{bad / count if count else 0:.2f}" {box}/></g>'
            )
    title = f"<h2>{escape(down.name)} (down) and {escape(across.name)} (across)</h2>"
    names = ", ".join(escape(share.label) for share in across.shares)
    return title + _svg(rows, len(down.shares) * _ROW) + f"<p>Across: {names}.</p>"


def _durations(runs: Sequence[CampaignRun]) -> str:
    """Draw a histogram of the durations of the runs."""
    longest = max(run.wall_s for run in runs) or 1.0
    bars = Counter(min(_BARS - 1, int(run.wall_s / longest * _BARS)) for run in runs)
    step, most = _WIDTH / _BARS, max(bars.values())
    rows = [
        f'<rect class="passed" x="{bar * step:.1f}" y="{100 - 100 * count / most:.1f}" width="{step - 2:.1f}" '
        f'height="{100 * count / most:.1f}"><title>{count} runs</title></rect>'
        for bar, count in bars.items()
    ]
    rows.append(f'<text x="0" y="116">0 s</text><text x="{_WIDTH - 60}" y="116">{longest:.3g} s</text>')
    return "<h2>Durations</h2>" + _svg(rows, 120)


def _svg(rows: Sequence[str], height: int) -> str:
    return f'<svg width="{_WIDTH}" height="{height}" role="img">{"".join(rows)}</svg>'
