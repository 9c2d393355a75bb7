"""``gcm-learn figure``: one figure of the paper."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import staged
from gcm_learn.errors import UnknownNameError

FORMATS = (".png", ".pdf", ".svg")


@dataclass(frozen=True)
class Figure:
    """Draw one figure of the paper, computed now."""

    name: Annotated[Positional[str], arg(metavar="NAME")]
    """which figure; an unknown name lists all of them"""

    out: Annotated[Path | None, arg(metavar="FILE", help_behavior_hint="(default: NAME.png)")] = (
        None
    )
    """a .png, .pdf or .svg file"""

    def run(self) -> int:
        """Draw and save the figure."""
        from gcm_learn.plots import FIGURES, draw_figure

        if self.name not in FIGURES:
            raise UnknownNameError.among("figure", self.name, FIGURES)
        target = Path(f"{self.name}.png") if self.out is None else self.out
        require_suffix(target, FORMATS)
        with staged(target) as place:
            draw_figure(self.name).savefig(place)
        print(target)
        return 0


def require_suffix(target: Path, known: tuple[str, ...], option: str = "--out") -> None:
    """Refuse a file name that does not end in one of the `known` formats."""
    if target.suffix.lower() not in known:
        raise CommandFailure(f"{option} {target}: the name must end in {' or '.join(known)}")
