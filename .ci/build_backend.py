"""Build backend: setuptools, which also compiles the C sources of the time integration.

Without a C compiler, the `ziglang` package is used. The result is optimised for this machine;
with `BLADEWHIRL_PORTABLE=1`, it runs on all processors of the same architecture.
"""

import os
import platform
import shlex
import shutil
import sys
import sysconfig
from collections.abc import Callable
from pathlib import Path
from typing import Any

from setuptools import build_meta
from setuptools.build_meta import build_sdist as setuptools_sdist
from setuptools.build_meta import prepare_metadata_for_build_wheel  # noqa: F401

KERNEL = Path("solvers/kernel")
MODULE = "bladewhirl.solvers.kernel._kernel"


def compiler() -> str | None:
    """Return the C compiler named by `CC` or by Python's configuration, or one on the path."""
    names = [os.environ.get("CC"), sysconfig.get_config_var("CC"), "cc", "gcc", "clang"]
    return next((name for name in names if name and shutil.which(shlex.split(name)[0])), None)


def requirements() -> list[str]:
    """Return the packages that the build needs in addition to those in pyproject.toml."""
    return [] if compiler() else ["ziglang>=0.13"]


def write_source() -> None:
    """Write the C source of the extension module: the march, and the wrappers for Python."""
    from cffi import FFI

    header = (KERNEL / "kernel.h").read_text()
    ffi = FFI()
    ffi.cdef("\n".join(line for line in header.splitlines() if not line.startswith("#")))
    ffi.set_source(MODULE, '#include "variants.c"', py_limited_api=True)
    (KERNEL / "_kernel.c").unlink(missing_ok=True)  # a new file is always compiled
    ffi.emit_c_code(str(KERNEL / "_kernel.c"))


def build(step: Callable[..., str], *arguments: Any) -> str:
    """Write the C source, set compiler and flags in the environment, call a setuptools step."""
    write_source()
    command = compiler() or f"{shlex.quote(sys.executable)} -m ziglang cc"
    os.environ["CC"], os.environ["LDSHARED"] = command, f"{command} -shared"
    if sys.platform == "darwin":
        os.environ["LDSHARED"] = f"{command} -bundle -undefined dynamic_lookup"
    x86 = platform.machine().lower() in ("x86_64", "amd64")
    flag = "-march=native" if x86 else "-mcpu=native"
    if os.environ.get("BLADEWHIRL_PORTABLE", "0") not in ("", "0"):
        flag = "-DPORTABLE"
    os.environ["CFLAGS"] = f"-O3 {os.environ.get('CFLAGS', '')} {flag}"
    try:
        return step(*arguments)
    except (Exception, SystemExit):
        raise SystemExit(
            f"bladewhirl: {command!r} failed to compile the C sources, see above; install a C "
            "compiler and the headers of Python and the C library (on Debian: apt-get install gcc "
            "libc6-dev python3-dev)"
        ) from None


def get_requires_for_build_wheel(config_settings: Any = None) -> list[str]:
    """Return the requirements of a wheel."""
    return [*build_meta.get_requires_for_build_wheel(config_settings), *requirements()]


def get_requires_for_build_editable(config_settings: Any = None) -> list[str]:
    """Return the requirements of an editable installation."""
    return [*build_meta.get_requires_for_build_editable(config_settings), *requirements()]


def build_wheel(directory: str, config_settings: Any = None, metadata: str | None = None) -> str:
    """Build a wheel."""
    return build(build_meta.build_wheel, directory, config_settings, metadata)


def build_editable(directory: str, config_settings: Any = None, metadata: str | None = None) -> str:
    """Build an editable installation, with the compiled extension in the source folder."""
    return build(build_meta.build_editable, directory, config_settings, metadata)


def build_sdist(directory: str, config_settings: Any = None) -> str:
    """Build the source distribution."""
    write_source()
    return setuptools_sdist(directory, config_settings)
