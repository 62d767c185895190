"""Option ``--scheduler``: runs go to the workers of a Dask cluster instead of the cores of this machine."""

from collections.abc import Iterator
from concurrent.futures import Executor
from contextlib import contextmanager
from typing import Any

from adaptive_ff.errors import InputError, library

PATIENCE = 20  # time after which a scheduler that does not answer is given up, s


@contextmanager
def workers(scheduler: str | None) -> Iterator[Executor | None]:
    """Yield the executor of the cluster at an address; None, which stands for processes here, without one."""
    if scheduler is None:
        yield None
        return
    import asyncio

    distributed = library("distributed", f"--scheduler = {scheduler}")
    try:
        asyncio.run(_call(distributed, scheduler))
        client = distributed.Client(scheduler, timeout=PATIENCE)
    except (OSError, ValueError, TypeError, AssertionError) as error:  # the last where its own loop does not begin
        reason = " ".join(str(error).split()) or type(error).__name__
        raise InputError(
            f"--scheduler = {scheduler} is not allowed: it must be the address of a running Dask scheduler ({reason})"
        ) from error
    with client:
        yield client.get_executor()


async def _call(distributed: Any, scheduler: str) -> None:
    """Connect to a scheduler and hang up.

    A client that finds nobody is left to the garbage collector, which closes it when it likes. Where that is while
    the next client begins, both wait for one lock for ever (distributed 2026.8). So none is made before somebody
    answers.
    """
    secrets = distributed.Security().get_connection_args("client")
    connection = await distributed.core.connect(scheduler, timeout=PATIENCE, **secrets)
    connection.abort()
