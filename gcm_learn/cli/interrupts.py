"""Ctrl-C that is not lost."""

from __future__ import annotations

import _thread
import contextlib
import os
import sys
import threading
from types import TracebackType
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

AGAIN_AFTER = 0.05  # [s]


class Interrupts:
    """Makes a Ctrl-C count that falls into a place where Python drops exceptions.

    The compiler of the kernels and the loading of libraries run callbacks in which a
    KeyboardInterrupt is reported and then ignored. Within this context it is neither: `lost`
    becomes true, and the interrupt comes again a moment later.
    """

    def __init__(self) -> None:
        self.lost = self.ended = False
        self._timer: threading.Timer | None = None

    def __enter__(self) -> Self:
        self._outer = sys.unraisablehook, sys.excepthook
        sys.unraisablehook, sys.excepthook = self._dropped, self._printed
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        sys.unraisablehook, sys.excepthook = self._outer
        if self._timer is not None:
            self._timer.cancel()

    def caused(self, error: BaseException) -> bool:
        """Return whether an error is an interrupt or a consequence of an interrupt.

        Compiled code that was interrupted while it returned says ``SystemError: returned a result
        with an exception set``, and a library that was being loaded may say anything.
        """
        link: BaseException | None = error
        while link is not None and not self.ended:
            self.ended = self.lost or isinstance(link, KeyboardInterrupt)
            link = link.__cause__ or link.__context__
        return self.ended

    def leave(self, code: int) -> None:
        """End this process with an exit code if it was interrupted; to be called last.

        Otherwise the interpreter would end itself by a signal if any code that it ran from a
        string, e.g. in the making of a named tuple, was interrupted.
        """
        if self.ended:
            for stream in (sys.stdout, sys.stderr):
                with contextlib.suppress(OSError, ValueError, AttributeError):
                    stream.flush()
            os._exit(code)

    def _dropped(self, dropped: UnraisableHookArgs) -> None:
        if issubclass(dropped.exc_type, KeyboardInterrupt):
            self._come_again()
        else:
            self._outer[0](dropped)

    def _printed(
        self, kind: type[BaseException], error: BaseException, trace: TracebackType | None
    ) -> None:
        if issubclass(kind, KeyboardInterrupt):
            self._come_again()
        else:
            self._outer[1](kind, error, trace)

    def _come_again(self) -> None:
        self.lost = True
        self._timer = threading.Timer(AGAIN_AFTER, _thread.interrupt_main)
        self._timer.daemon = True
        self._timer.start()
