"""A Dask cluster, if one is asked for."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from gcode.support.errors import UserError

CONNECT_S = 10


@contextlib.contextmanager
def cluster(address: str | None) -> Iterator[None]:
    """Within the block, joblib's ``dask`` backend works on the cluster at `address`; without one, do nothing.

    Raises
    ------
    UserError
        If Dask is not installed or the scheduler does not answer.
    """
    if address is None:
        yield
        return
    try:
        from distributed import Client
    except ImportError:
        raise UserError("a Dask cluster needs the extra: pip install 'knitbench[dask]'") from None
    try:
        client = Client(address, timeout=CONNECT_S)
    except (OSError, ValueError, TimeoutError) as error:
        raise UserError(
            f"{address}: no Dask scheduler answers there ({type(error).__name__}); check `scheduler`"
        ) from None
    with client:
        yield
