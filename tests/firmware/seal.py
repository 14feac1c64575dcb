"""Write the CRC-32 of an image into its .crc section: `seal.py OBJCOPY IMAGE.elf START`.

START is the symbol from which the image is counted; the section's own symbol is `image_crc`.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import zlib
from pathlib import Path


def symbol(nm: str, image: str, name: str) -> int:
    """Return the address of a symbol."""
    table = subprocess.run([nm, image], capture_output=True, text=True, check=True).stdout
    return next(
        int(line.split()[0], 16) for line in table.splitlines() if line.endswith(f" {name}")
    )


def main(objcopy: str, image: str, start: str) -> int:
    """Seal one image."""
    nm = objcopy.replace("objcopy", "nm")
    first, end = symbol(nm, image, start), symbol(nm, image, "image_crc")
    with tempfile.TemporaryDirectory() as folder:
        binary, crc = Path(folder, "image"), Path(folder, "crc")
        wanted = ["-j", ".text", "-j", ".ARM.exidx", "-j", ".data"]
        subprocess.run([objcopy, "-O", "binary", *wanted, image, str(binary)], check=True)
        content = binary.read_bytes()
        lowest = symbol(nm, image, "image_lowest")
        content = content[first - lowest : end - lowest].ljust(end - first, b"\0")
        crc.write_bytes(zlib.crc32(content).to_bytes(4, "little"))
        subprocess.run([objcopy, "--update-section", f".crc={crc}", image], check=True)
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:4]))
