"""The daemon on two emulated CAN controllers under Linux's own driver (kvaser_pci, SJA1000).

vcan has no controller: no bit timing, no transmit-complete interrupt, no driver queue. Here a
Debian kernel runs under QEMU with two Kvaser PCI cards on one bus; swaywatchd listens on can0,
bus_load sends on can1. Usage: controllers.py KERNEL_DIRECTORY (an unpacked linux-image package).
Exits with 1 where a count is not what was sent.
"""

from __future__ import annotations

import gzip
import json
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
VEHICLE = ROOT / "tests" / "data" / "practice" / "p01" / "vehicle.toml"
MODULES = ("can-dev", "can", "can-raw", "sja1000", "kvaser_pci")
RATE, SECONDS = 2000, 4
INIT = f"""#!/bin/busybox sh
export PATH=/bin:/sbin
busybox mount -t proc proc /proc
echo
busybox mount -t sysfs sys /sys
busybox mount -t devtmpfs dev /dev
for module in {" ".join(MODULES)}; do
    busybox insmod /lib/$module.ko || echo "insmod $module failed"
done
for bus in can0 can1; do
    /bin/ip link set $bus txqueuelen 500 type can bitrate 500000 restart-ms 100
    /bin/ip link set $bus up
done
swaywatchd --vehicle /vehicle.toml can0 2>/daemon &
busybox sleep 1
for turn in 1 2; do
    echo "LOAD $(bus_load can1 {RATE} {SECONDS} /status)"
    echo "STATUS $(busybox wc -l </status)"
    busybox sleep 1
    busybox kill -USR1 $(busybox pidof swaywatchd)
    busybox sleep 1
    echo "COUNTS $(busybox grep counts /daemon | busybox tail -n 1 | busybox sed 's/.*counts //')"
    if [ $turn = 1 ]; then
        /bin/ip link set can0 down
        busybox sleep 1
        /bin/ip link set can0 up
        busybox sleep 1
    fi
done
busybox kill -TERM $(busybox pidof swaywatchd)
busybox sleep 1
/bin/ip -details link show can0 | busybox sed 's/^/LINK /'
busybox sed 's/^/DAEMON /' /daemon
busybox poweroff -f
"""


def with_libraries(target: Path, program: Path) -> None:
    """Copy a program to /bin of the guest, and the libraries it is linked with."""
    shutil.copy(program, target / "bin" / program.name)
    listed = subprocess.run(["ldd", str(program)], capture_output=True, text=True, check=False)
    for library in re.findall(r"(/\S+)", listed.stdout.replace("(", " (")):
        place = target / library.lstrip("/")
        place.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(library, place)


def initramfs(kernel: Path, folder: Path) -> Path:
    """The guest's whole file system, as the kernel wants it."""
    root = folder / "root"
    for name in ("bin", "lib", "proc", "sys", "dev"):
        (root / name).mkdir(parents=True)
    shutil.copy("/bin/busybox", root / "bin" / "busybox")
    shutil.copy(VEHICLE, root / "vehicle.toml")
    ip = shutil.which("ip", path="/usr/sbin:/sbin:/usr/bin:/bin")
    if ip is None:
        sys.exit("controllers: no ip here; install iproute2")
    for program in (Path(ip), ROOT / "build" / "swaywatchd", ROOT / "build" / "bus_load"):
        with_libraries(root, program)
    for name in MODULES:
        found = sorted(kernel.rglob(f"{name}.ko*"))
        if not found:
            sys.exit(f"controllers: {kernel} has no module {name}")
        if found[0].suffix == ".ko":
            shutil.copy(found[0], root / "lib" / f"{name}.ko")
        else:
            packed = subprocess.run(["xz", "-dc", str(found[0])], capture_output=True, check=True)
            (root / "lib" / f"{name}.ko").write_bytes(packed.stdout)
    init = root / "init"
    init.write_text(INIT)
    init.chmod(0o755)
    names = "\n".join(str(path.relative_to(root)) for path in sorted(root.rglob("*")))
    archive = subprocess.run(
        ["cpio", "-o", "-H", "newc", "--quiet"], input=names.encode(), cwd=root,
        capture_output=True, check=True,
    )  # fmt: skip
    image = folder / "initramfs"
    image.write_bytes(gzip.compress(archive.stdout, 1))
    return image


def run_guest(kernel: Path) -> list[str]:
    """What the guest prints."""
    image = next(iter(sorted(kernel.rglob("vmlinuz*"))), None)
    if image is None:
        sys.exit(f"controllers: no kernel in {kernel}")
    with tempfile.TemporaryDirectory() as scratch:
        command = [
            "qemu-system-x86_64", "-m", "256M", "-nographic", "-no-reboot", "-nodefaults",
            "-serial", "stdio", "-object", "can-bus,id=bus",
            "-device", "kvaser_pci,canbus=bus", "-device", "kvaser_pci,canbus=bus",
            "-kernel", str(image), "-initrd", str(initramfs(kernel, Path(scratch))),
            "-append", "console=ttyS0 quiet panic=-1",
        ]  # fmt: skip
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=300, check=False,
            stdin=subprocess.DEVNULL,
        )  # fmt: skip
    return done.stdout.replace("\r", "").splitlines()


def after(lines: list[str], word: str) -> list[str]:
    """The lines that begin with a word, without it."""
    return [line[len(word) + 1 :] for line in lines if line.startswith(word + " ")]


def main() -> int:
    """Run, check, report."""
    lines = run_guest(Path(sys.argv[1]))
    loads = [json.loads(text) for text in after(lines, "LOAD") if text]
    counts = [json.loads(text) for text in after(lines, "COUNTS") if text]
    status = [int(text) for text in after(lines, "STATUS")]
    daemon = after(lines, "DAEMON")
    if len(loads) != 2 or len(counts) != 2:
        print("\n".join(lines))
        print("controllers: the guest did not come to its end")
        return 1
    link = " ".join(" ".join(after(lines, "LINK")).split())
    second = {key: counts[1][key] - counts[0][key] for key in counts[0]}
    print("hil: two emulated Kvaser PCI cards (SJA1000), Linux driver kvaser_pci, 500 kbit/s")
    for word, sent, seen, returned in (
        ("first", loads[0], counts[0], status[0]),
        ("after down and up", loads[1], second, status[1]),
    ):
        print(
            f"{word}: sent {sent['sent']}, received {seen['received']}, accepted "
            f"{seen['accepted']}, kernel_lost {seen['kernel_lost']}, crc {seen['crc']}, lost "
            f"{seen['lost']}; {returned} status frames seen by the sender"
        )
    print(f"daemon: {'; '.join(line for line in daemon if 'counts' not in line)}")
    wrong = [
        name
        for name, bad in {
            "received": counts[0]["received"] != loads[0]["sent"]
            or second["received"] != loads[1]["sent"],
            "accepted": counts[0]["accepted"] != loads[0]["sent"],
            "kernel_lost": counts[1]["kernel_lost"] != 0,
            "crc": counts[1]["crc"] != 0,
            "status": min(status) < 100,
            "downs": counts[1]["downs"] != 1,
            "driver": "sja1000" not in link and "kvaser" not in link,
        }.items()
        if bad
    ]
    if wrong:
        print(f"controllers: not as it must be: {', '.join(wrong)}\n{link}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
