"""The same campaign on a Dask cluster of two workers in processes gives the same table."""

from __future__ import annotations

import contextlib
import os
import warnings
from collections.abc import Iterator
from pathlib import Path
from unittest import mock

import pytest

from canwire import HubError, HubLost, run_campaign
from canwire.campaigns.loading import script_of
from canwire.campaigns.playing import CampaignRun, Order, play
from tests.campaigns.scripts import ENDS, FLIPS, LASTS, written
from tests.hubs import LONG_S

distributed = pytest.importorskip("distributed")
dask = pytest.importorskip("dask")
pytestmark = pytest.mark.filterwarnings("ignore")  # Dask's own


@pytest.fixture(scope="module")
def cluster() -> Iterator[str]:
    """Its scheduler blames at a worker's first death, and all that this worker had."""
    # Dask sets PYTHONHASHSEED while it starts a worker, also one that is started again as all ends. It gives
    # up a worker that needs more than 15 s for that, with all that the worker has by then.
    # Workers are forks of a process that has all modules already: each would load Dask, for a second.
    patient = dask.config.set(
        {
            "distributed.deploy.lost-worker-timeout": f"{LONG_S}s",
            "distributed.worker.multiprocessing-method": "forkserver",
        }
    )
    with mock.patch.dict(os.environ), warnings.catch_warnings(), patient:
        warnings.simplefilter("ignore")
        with distributed.LocalCluster(
            n_workers=2,
            threads_per_worker=1,
            processes=True,
            dashboard_address=None,
            host="127.0.0.1",
            scheduler_kwargs={"allowed_failures": 0},
        ) as cluster:
            yield cluster.scheduler_address.replace("tcp://", "dask://")
            with distributed.Client(
                cluster
            ) as client:  # else a start is still under way as the variables are put back
                client.wait_for_workers(2, timeout=LONG_S)


@pytest.mark.conforms("N-38")
def test_the_same_table(cluster: str, tmp_path: Path) -> None:
    flips = written(tmp_path, "flips.py", FLIPS)
    here = run_campaign(flips, runs=24, seed=3, workers=2, results=tmp_path / "here.csv")
    assert run_campaign(flips, runs=24, seed=3, cluster=cluster, results=tmp_path / "there.csv") == here
    assert (tmp_path / "there.csv").read_bytes() == (tmp_path / "here.csv").read_bytes()


@pytest.mark.conforms("N-38")
def test_a_run_that_takes_too_long_there(cluster: str, tmp_path: Path) -> None:
    lasts = written(tmp_path, "lasts.py", LASTS.replace("while number == 4", "while number > 5"))
    runs = run_campaign(lasts, time_limit=0.3, cluster=cluster)
    verdicts = {run.number: run.verdict for run in runs}
    assert verdicts == dict.fromkeys(range(6), "passed") | {2: "timeout"}


def test_a_run_that_takes_its_worker_down_is_named_and_the_others_are_played(
    cluster: str, tmp_path: Path
) -> None:
    """Also those that waited on that worker for their turn."""
    runs = run_campaign(written(tmp_path, "ends.py", ENDS), cluster=cluster)
    verdicts = {run.number: run.verdict for run in runs}
    assert verdicts == dict.fromkeys(range(12), "passed") | {5: "crashed", 7: "error"}


@pytest.mark.finding("machines 14")
def test_a_scheduler_that_is_gone_is_a_sentence_and_the_runs_are_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def dying(client: object, *words: object) -> Iterator[list[CampaignRun]]:
        yield [play(script_of(flips).load(), Order(0), 1)]
        raise distributed.client.FutureCancelledError("play_batch-7", "scheduler-connection-lost", "Lost it.")

    flips = written(tmp_path, "flips.py", FLIPS)
    monkeypatch.setattr("distributed.Client", lambda *_, **options: contextlib.nullcontext())
    monkeypatch.setattr("canwire.campaigns.cluster._played", dying)
    with pytest.raises(HubLost, match=r"cluster dask://there:1: its scheduler is gone; .*Lost it\."):
        run_campaign(flips, runs=3, cluster="dask://there:1", results=tmp_path / "a.csv")
    assert (tmp_path / "a.csv.journal").read_bytes().count(b"\n") == 2  # the heading, and a run


def test_no_cluster_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("canwire.campaigns.cluster._PATIENCE_S", 0.5)
    with pytest.raises(HubError, match=r"cluster dask://127\.0\.0\.1:9"):
        run_campaign(written(tmp_path, "flips.py", FLIPS), cluster="dask://127.0.0.1:9")
