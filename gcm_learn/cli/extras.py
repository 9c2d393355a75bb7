"""Parts of the package that need libraries which not everybody has."""

from __future__ import annotations

import importlib
from types import ModuleType

from gcm_learn.cli.failures import CommandFailure


def dataset_package() -> ModuleType:
    """The package of datasets; says what to install if it cannot be loaded."""
    try:
        return importlib.import_module("gcm_learn.dataset")
    except ImportError as error:
        raise CommandFailure(str(error)) from None
