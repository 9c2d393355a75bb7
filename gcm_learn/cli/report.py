"""``gcm-learn report``: sheets of answers as one page."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import made_folder
from gcm_learn.cli.options import given


@dataclass(frozen=True)
class Report:
    """Judge the answers of sheets again; write one page that needs no other file."""

    sheets: Annotated[Positional[tuple[Path, ...]], arg(metavar="SHEET")] = ()
    """files of gcm-learn compare, or folders of them"""

    out: Annotated[Path, arg(metavar="DIR")] = Path("report")
    """folder for index.html"""

    ours: bool = False
    """add the answers of this package's methods to the same suites; a checkout has them"""

    reference: Annotated[str, given("NAME", "who catches most")] = ""
    """entrant with which the others are compared"""

    def run(self) -> int:
        """Judge and write."""
        if not self.sheets and not self.ours:
            raise CommandFailure("SHEET is missing: a file of gcm-learn compare")
        for path in self.sheets:
            if not path.exists():
                raise CommandFailure(f"{path}: is not there")
        from gcm_learn.evaluation import page, read_sheets

        sheet = read_sheets(self.sheets, ours=self.ours)
        names = sheet.each("entrant")
        if self.reference and self.reference not in names:
            raise CommandFailure(f"--reference {self.reference}: is not among {', '.join(names)}")
        folder = made_folder(self.out, option="--out")
        marked = sheet.each("entrant") if not self.ours else []
        shown = page(sheet, folder, reference=self.reference, marked=marked)
        print(f"Open {shown.resolve().as_uri()} in a browser.")
        return 0
