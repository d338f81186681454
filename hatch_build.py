"""Builds the compiled core on installation, where a C compiler is found; else it is left out, and numpy computes."""

import sys
import tempfile
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

sys.path.insert(0, str(Path(__file__).parent))

import build_core


class CoreHook(BuildHookInterface):  # type: ignore[type-arg]
    """Builds into the tree for an editable installation, and for a wheel into a folder that lasts until it is made.

    So a wheel for another platform leaves the libraries of the tree as they are.
    """

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build before the wheel is put together; raises NotBuilt only if FES_CORE demands the core."""
        if build_core.wanted() == "numpy":
            self.app.display_info("no compiled core, as FES_CORE says")
            return
        root = Path(self.root)
        self.folder = tempfile.TemporaryDirectory(prefix="fes-core-")
        into = None if version == "editable" else Path(self.folder.name)
        try:
            built = build_core.build(root, into)
        except build_core.NotBuilt as reason:
            if build_core.wanted() == "c":
                raise
            self.app.display_warning(f"no compiled core: {reason}")
            return
        if into is not None:
            build_data["force_include"] |= {str(library): str(library.relative_to(into)) for library in built}
            build_data["pure_python"] = False
            build_data["tag"] = f"py3-none-{build_core.platform_tag()}"

    def finalize(self, version: str, build_data: dict[str, Any], artifact_path: str) -> None:
        """Remove the folder."""
        if folder := getattr(self, "folder", None):
            folder.cleanup()
