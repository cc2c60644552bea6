"""A Dask cluster that exists, as the workers of a campaign."""

from __future__ import annotations

import ipaddress
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Final
from urllib.parse import urlsplit

from distributed import Client, Security
from distributed.scheduler import KilledWorker

from sim_scenarios.errors import InputError

WORKERS_DIED: Final = KilledWorker
"""Raised of a task that Dask has given out again and again."""

CONNECTING: Final = 10.0
"""How long a scheduler may take to answer, and a worker to come [s]."""

_CERTIFICATES: Final = ("tls_ca_file", "tls_client_cert", "tls_client_key")
"""What a client needs for TLS, as Dask's `Security` calls it."""
_VARIABLES: Final = tuple(
    f"DASK_DISTRIBUTED__COMM__TLS__{n}" for n in ("CA_FILE", "CLIENT__CERT", "CLIENT__KEY")
)
"""Where Dask looks for it, if not in its configuration files."""


@contextmanager
def connected(scheduler: str, insecure: bool) -> Iterator[Client]:
    """Client of a scheduler that has workers.

    Raises
    ------
    InputError
        It does not answer, has no workers, or is not to be trusted: see `insecure` of `campaign`.
    """
    _check_security(scheduler, insecure)
    try:
        client = Client(scheduler, timeout=CONNECTING)
    except (OSError, ValueError) as error:
        raise InputError(f"--scheduler {scheduler}: there is no answer ({error})") from None
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECTING)
        except TimeoutError:
            raise InputError(f"--scheduler {scheduler}: it has no workers") from None
        yield client


def _check_security(scheduler: str, insecure: bool) -> None:
    """Refuse a connection on which others may listen, or speak: whoever does, runs code at both its ends."""
    protocol, _, address = scheduler.rpartition("://")
    if protocol not in ("", "tcp", "tls", "ws", "wss"):
        raise InputError(f"--scheduler {scheduler}: must begin with tls://, tcp:// or ws://")
    if protocol == "tls":
        security = Security()
        missing = [v for v, n in zip(_VARIABLES, _CERTIFICATES, strict=True) if getattr(security, n) is None]
        if missing:
            raise InputError(f"--scheduler {scheduler}: TLS needs certificates; set {', '.join(missing)}")
    elif not insecure and not _is_loopback(address):
        raise InputError(
            f"--scheduler {scheduler}: whoever reaches a scheduler without TLS can run code here and on its "
            "workers; start it with certificates and say tls://, or say --insecure where nobody else can"
        )


def _is_loopback(address: str) -> bool:
    try:
        host = urlsplit(f"//{address}").hostname or ""
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False
