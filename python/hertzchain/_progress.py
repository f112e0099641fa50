"""Progress of long work: tqdm if it is installed, else a line on a terminal."""

from __future__ import annotations

import contextlib
import sys
import threading
import warnings
from collections.abc import Callable, Iterator
from typing import Any

Progress = bool | Callable[[float], Any]
"""Whether to show progress, or a function that is called with the share done, from 0 to 1."""


_thread = threading.local()


@contextlib.contextmanager
def stopped_by(stop: threading.Event) -> Iterator[None]:
    """Work that this thread begins inside the context ends as by Ctrl-C once the event is set."""
    _thread.stop = stop
    try:
        yield
    finally:
        _thread.stop = None


@contextlib.contextmanager
def shown(progress: Progress, what: str) -> Iterator[Callable[[float], Any] | None]:
    """The function to call with the share that is done, from 0 to 1, or None."""
    stop: threading.Event | None = getattr(_thread, "stop", None)
    with _shown(progress, what) as show:

        def tell(share: float) -> None:
            if stop is not None and stop.is_set():
                raise KeyboardInterrupt
            if show is not None:
                show(share)

        yield show if stop is None else tell


@contextlib.contextmanager
def _shown(progress: Progress, what: str) -> Iterator[Callable[[float], Any] | None]:
    if callable(progress):
        yield progress
        return
    if not progress:
        yield None
        return
    try:
        with warnings.catch_warnings():
            # In a notebook without widgets tqdm warns, and shows a line of text instead.
            warnings.simplefilter("ignore")
            from tqdm.auto import tqdm
    except ImportError:
        line = _line(what) if sys.stderr.isatty() or _notebook() else None
        try:
            yield line
        finally:
            if line:
                sys.stderr.write("\r" + " " * (len(what) + 7) + "\r")
        return
    with tqdm(total=1000, desc=what, bar_format="{desc}: {percentage:3.0f} %|{bar}| {elapsed}") as bar:

        def tell(share: float) -> None:
            bar.update(int(1000 * min(share, 1.0)) - bar.n)

        yield tell
        tell(1.0)


def _notebook() -> bool:
    """Whether a notebook shows what is written to standard error, where carriage returns work."""
    ipython = sys.modules.get("IPython")
    return ipython is not None and hasattr(ipython.get_ipython(), "kernel")


def _line(what: str) -> Callable[[float], None]:
    def tell(share: float) -> None:
        sys.stderr.write(f"\r{what}: {100 * min(share, 1.0):3.0f} %")
        sys.stderr.flush()

    return tell
