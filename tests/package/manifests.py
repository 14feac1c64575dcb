"""manifests.py TREE: the manifests of the tarball by the tools that will read them."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import kconfiglib
from platformio.package.manifest.schema import ManifestSchema


def platformio(tree: Path) -> None:
    """library.json by PlatformIO's schema; every pattern of its sources finds files."""
    # the list of licences would be fetched from the network
    ManifestSchema.load_spdx_licenses = staticmethod(
        lambda *_: {"licenses": [{"licenseId": "MIT"}]}
    )
    manifest = json.loads((tree / "library.json").read_text())
    ManifestSchema().load_manifest(manifest)
    for pattern in manifest["build"]["srcFilter"]:
        found = list(tree.glob(pattern.removeprefix("+<").removesuffix(">")))
        assert found, f"library.json: {pattern} finds nothing"
    print("PlatformIO: library.json is valid, its source patterns find files")


def esp_idf(tree: Path) -> None:
    """The component packed by Espressif's component manager."""
    with tempfile.TemporaryDirectory() as out:
        subprocess.run(
            [Path(sys.executable).with_name("compote"), "component", "pack", "--name", "swaywatch",
             "--project-dir", str(tree), "--dest-dir", out],
            check=True, capture_output=True,
        )  # fmt: skip
        assert list(Path(out).glob("swaywatch_*.tgz"))
    print("ESP-IDF: packed by compote")


def zephyr(tree: Path) -> None:
    """Kconfig as Zephyr's own parser reads it."""
    config = kconfiglib.Kconfig(str(tree / "zephyr" / "Kconfig"), warn_to_stderr=False)
    config.syms["SWAYWATCH"].set_value("y")
    assert config.syms["SWAYWATCH_CHANNELS"].str_value == "16"
    assert not config.warnings, config.warnings
    print("Zephyr: Kconfig parsed, no warning")


if __name__ == "__main__":
    root = Path(sys.argv[1]).resolve()
    platformio(root)
    esp_idf(root)
    zephyr(root)
