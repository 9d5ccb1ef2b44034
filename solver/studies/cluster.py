"""Dask distributed as an executor: an existing cluster, or workers on this machine for trials."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import AbstractContextManager
from importlib import import_module
from tempfile import TemporaryDirectory
from typing import Any

from ..common.errors import InputError, check_type, check_whole, needing, shortened

LOCAL = "local"
# Monitoring by the scheduler, nannies and workers that are started here. With Dask's defaults, sampling the stack every
# 10 ms takes 4 % of a worker's time; monitoring event loop, memory and processor takes 10 % of a core with two workers,
# and 1.5 % with these settings.
OF_OURS = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "1s",
    "distributed.worker.memory.monitor-interval": "1s",
    "distributed.admin.system-monitor.interval": "5s",
}
CONNECT = "20s"  # timeout of the connection to the scheduler


def _same(thing: Any) -> Any:
    return thing


class Cluster(AbstractContextManager["Cluster"]):
    """An executor for `run_study`, to be used as a context.

    Data that every chunk needs are sent once to each worker (`carry`). A chunk whose worker dies is repeated by
    another. Needs the extra `dask`.

    Parameters
    ----------
    address : str
        tcp://HOST:PORT of a scheduler, or "local" for workers on this machine.
    workers : int, optional
        Number of local workers, by default that of Dask.

    Raises
    ------
    InputError
        If an argument is not valid, Dask is not installed or no scheduler answers.
    """

    def __init__(self, address: str = LOCAL, workers: int | None = None) -> None:
        check_type("address", address, str)
        if workers is not None:
            check_whole("workers", workers, 1, math.inf, "a number of workers, 1 or more")
        with needing("dask", "distributed", "dask"):
            dask, distributed = (import_module(name) for name in ("dask", "distributed"))
        self._scratch = TemporaryDirectory(prefix="multiblock-dask-", ignore_cleanup_errors=True)
        try:
            if address == LOCAL:
                with dask.config.set(OF_OURS | {"temporary-directory": self._scratch.name}):
                    self._client: Any = distributed.Client(
                        n_workers=workers, threads_per_worker=1, dashboard_address=None, set_as_default=False
                    )
            else:
                self._client = distributed.Client(address, timeout=CONNECT, set_as_default=False)
        except (OSError, ValueError, TimeoutError) as error:
            self._scratch.cleanup()
            raise InputError(f"--dask {address}: no scheduler answers: {shortened(error)}") from error
        self.address = address

    @property
    def workers(self) -> int:
        """The number of chunks that are processed at once."""
        return max(1, int(sum(self._client.nthreads().values())))

    def carry(self, thing: Any) -> Any:
        """Send data that every chunk needs, and return a handle for them in `submit`.

        They are the result of a task: unlike scattered data they are restored when the worker that held them dies.
        """
        return self._client.submit(_same, thing, pure=False)

    def submit(self, function: Callable[..., Any], *arguments: Any) -> Any:
        """Send a call to the cluster, and return its future."""
        return self._client.submit(function, *arguments, pure=False)

    def lost(self) -> str:
        """Return the reason why no more results will come, or ""."""
        if self._client.status == "running":
            return ""
        return f"the scheduler at {self.address} has gone ({self._client.status})"

    def close(self) -> None:
        """Leave the cluster; workers that were started here end."""
        self._client.close(timeout=5)
        self._scratch.cleanup()

    def __exit__(self, *_: object) -> None:
        self.close()
