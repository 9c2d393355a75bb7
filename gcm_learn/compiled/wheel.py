"""Wheel of kernels compiled ahead, for one Python, one numba and one kind of processor."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import platform
import subprocess
import sys
import tempfile
import zipfile
from email import message_from_string
from importlib import metadata
from pathlib import Path

from llvmlite import binding as llvm

from gcm_learn import __version__
from gcm_learn.compiled.cache import KERNELS, MADE_FOR

PROCESSORS = {
    "x86-64-v3": (
        "+avx,+avx2,+bmi,+bmi2,+cx16,+f16c,+fma,+lzcnt,+movbe,+popcnt,+sahf,+sse3,+sse4.1,"
        "+sse4.2,+ssse3,+xsave"
    ),
    "apple-m1": "",
    "generic": "",
}
"""Features that kernels may use, by the processor's name in LLVM."""


def usual_processor() -> str:
    """Return the default processor, of `PROCESSORS`, for machines like this one."""
    machine = platform.machine().lower()
    if sys.platform == "darwin" and machine == "arm64":
        return "apple-m1"
    return "x86-64-v3" if machine in ("x86_64", "amd64") else "generic"


def build_wheel(command: list[str], out: Path, processor: str) -> Path:
    """Run a command that compiles kernels, for a processor; pack these kernels into a wheel.

    Parameters
    ----------
    command : list of str
    out : Path
        Folder of the wheel.
    processor : str
        One of `PROCESSORS`.

    Returns
    -------
    Path
        The wheel.
    """
    with tempfile.TemporaryDirectory() as folder:
        target = {"NUMBA_CPU_NAME": processor, "NUMBA_CPU_FEATURES": PROCESSORS[processor]}
        own = {"NUMBA_CACHE_DIR": folder, "GCM_LEARN_NATIVE": "1"}
        subprocess.run(command, env=os.environ | target | own, check=True)
        machine = llvm.get_process_triple(), processor, PROCESSORS[processor]
        return _packed(Path(folder), out, json.dumps(machine))


def _packed(folder: Path, out: Path, made_for: str) -> Path:
    """Write the wheel with the kernels in a folder; numba's own wheel says for which systems."""
    numba, info = metadata.distribution("numba"), f"{KERNELS}-{__version__}.dist-info"
    tag = message_from_string(numba.read_text("WHEEL") or "")["Tag"]
    python = ".".join(map(str, sys.version_info[:2]))
    texts = {
        f"{KERNELS}/__init__.py": '"""Kernels of gcm_learn, compiled ahead."""\n',
        f"{KERNELS}/kernels/{MADE_FOR}": made_for,
        f"{info}/METADATA": (
            f"Metadata-Version: 2.1\nName: {KERNELS}\nVersion: {__version__}\n"
            f"Summary: Kernels of gcm_learn, compiled ahead\nLicense: MIT\n"
            f"Requires-Python: =={python}.*\nRequires-Dist: gcm_learn=={__version__}\n"
            f"Requires-Dist: numba=={numba.version}\n"
        ),
        f"{info}/WHEEL": (
            f"Wheel-Version: 1.0\nGenerator: gcm_learn\nRoot-Is-Purelib: false\nTag: {tag}\n"
        ),
    }
    files = {name: text.encode() for name, text in texts.items()}
    for path in sorted(folder.rglob("*.nbc")):
        name = path.relative_to(folder).as_posix()
        files[f"{KERNELS}/kernels/{name}"] = path.read_bytes()
    rows = [f"{name},sha256={_digest(data)},{len(data)}" for name, data in files.items()]
    files[f"{info}/RECORD"] = "\n".join([*rows, f"{info}/RECORD,,", ""]).encode()
    out.mkdir(parents=True, exist_ok=True)
    wheel = out / f"{KERNELS}-{__version__}-{tag}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return wheel


def _digest(data: bytes) -> str:
    """Return the SHA-256 of data in the format of a wheel's RECORD."""
    return base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
