"""The tests of environments act in the situations of those of execution."""

from tests.execution.conftest import arms, chains, rng, scenes  # noqa: F401
