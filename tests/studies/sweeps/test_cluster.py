"""Nobody is let into a local cluster: its processes talk to who has their key."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator
from urllib.error import HTTPError
from urllib.request import urlopen

import psutil
import pytest
from distributed import Client, LocalCluster

from bladewhirl.studies.sweeps.cluster import local_cluster

INTRUDER = """
import sys
from distributed import Client, Security

address, keyed = sys.argv[1:]
security = Security.temporary() if keyed == "own" else None
try:
    with Client(address, timeout="3s", security=security) as client:
        print(client.submit(sum, (1, 2)).result(timeout=3))
except Exception as error:
    print("refused", type(error).__name__)
"""
"""Another process, without a key or with one of its own, has code run at an address."""


@pytest.fixture(scope="module")
def cluster() -> Iterator[LocalCluster]:
    """A cluster of one worker."""
    with local_cluster(1) as cluster:
        yield cluster


def told_to_intruder(address: str, key: str) -> str:
    told = subprocess.run(
        [sys.executable, "-c", INTRUDER, address, key], capture_output=True, text=True, check=True
    )
    return told.stdout


@pytest.mark.parametrize(
    ("scheme", "key"), [("tcp", "none"), pytest.param("tls", "own", marks=pytest.mark.slow)]
)
def test_another_process_gets_no_code_run(cluster: LocalCluster, scheme: str, key: str) -> None:
    address = cluster.scheduler_address.replace("tls:", f"{scheme}:")
    assert told_to_intruder(address, key).startswith("refused")


def test_this_process_is_let_in_by_address(cluster: LocalCluster) -> None:
    """As a search does, whose client is not the cluster's own."""
    with Client(cluster.scheduler_address, set_as_default=False) as client:
        assert client.submit(sum, (1, 2)).result() == 3


def test_all_ports_are_of_this_machine_only(cluster: LocalCluster) -> None:
    own = psutil.Process()
    listening = {
        connection.laddr.ip
        for process in (own, *own.children(recursive=True))
        for connection in process.net_connections("inet")
        if connection.status == psutil.CONN_LISTEN
    }
    assert listening == {"127.0.0.1"}


def test_there_is_no_page_unless_asked_for(cluster: LocalCluster) -> None:
    for page in ("status", "info/main/workers.html", "json/counts.json"):
        with pytest.raises(HTTPError, match="404"):
            urlopen(cluster.dashboard_link.replace("status", page))
