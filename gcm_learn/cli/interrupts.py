"""Ctrl-C that is not lost."""

from __future__ import annotations

import _thread
import sys
import threading
from types import TracebackType
from typing import TYPE_CHECKING, Self

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

AGAIN_AFTER = 0.05  # [s]


class Interrupts:
    """Makes a Ctrl-C count that falls into a place where Python drops exceptions.

    The compiler of the kernels runs callbacks in which a KeyboardInterrupt is reported and
    then ignored. Within this context it is neither: `lost` becomes true, and the interrupt
    comes again a moment later.
    """

    def __init__(self) -> None:
        self.lost = False
        self._timer: threading.Timer | None = None

    def __enter__(self) -> Self:
        self._outer_hook = sys.unraisablehook
        sys.unraisablehook = self._notice
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        sys.unraisablehook = self._outer_hook
        if self._timer is not None:
            self._timer.cancel()

    def _notice(self, dropped: UnraisableHookArgs) -> None:
        if not issubclass(dropped.exc_type, KeyboardInterrupt):
            self._outer_hook(dropped)
            return
        self.lost = True
        self._timer = threading.Timer(AGAIN_AFTER, _thread.interrupt_main)
        self._timer.daemon = True
        self._timer.start()
