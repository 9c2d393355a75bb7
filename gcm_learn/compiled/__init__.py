"""Compiled kernels; only this folder uses private parts of numba."""

from typing import TYPE_CHECKING

from gcm_learn import late
from gcm_learn.compiled.dispatch import by_type as by_type, register as register
from gcm_learn.compiled.kernels import (
    INSIDE as INSIDE,
    TESTED as TESTED,
    is_compiling as is_compiling,
    njit as njit,
)
from gcm_learn.compiled.notice import (
    folder as folder,
    on_compile as on_compile,
    on_first_compiling as on_first_compiling,
    say_compiling as say_compiling,
)
from gcm_learn.compiled.sources import (
    PACKAGE as PACKAGE,
    source_hash as source_hash,
    sources_hash as sources_hash,
)

if TYPE_CHECKING:
    from gcm_learn.compiled.wheel import (
        PROCESSORS as PROCESSORS,
        build_wheel as build_wheel,
        usual_processor as usual_processor,
    )

__getattr__ = late.late_names(__name__, {"wheel": ("PROCESSORS", "build_wheel", "usual_processor")})
