"""Builds the compiled core on installation, where a C compiler is found; else it is left out, and numpy computes."""

import subprocess
import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).parent))

import build_core


class CoreHook(BuildHookInterface):  # type: ignore[type-arg]
    """Builds into the tree: an editable installation finds the libraries there, and a wheel takes them from there."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build before the wheel is put together; a failure leaves the core out."""
        compiler = build_core.compiler()
        if compiler is None or not build_core.is_supported():
            self.app.display_info("no compiled core: there is no C compiler")
            return
        try:
            built = build_core.build(compiler.split(), Path(self.root))
        except (OSError, subprocess.CalledProcessError) as error:
            self.app.display_warning(f"no compiled core: {error}")
            return
        if version == "standard":
            build_data["artifacts"] += [str(library.relative_to(self.root)) for library in built]
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{build_core.platform_tag()}"
