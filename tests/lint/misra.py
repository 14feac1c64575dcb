"""MISRA C:2012, required rules, of what runs in an ECU: every finding is one of the deviations.

`misra.py DEVIATIONS FILE...` runs cppcheck's addon over the files and compares its findings in them
with the list: `D-NN RULE FILE COUNT REASON`, a line each. A finding more, or a line that has none
any more, fails. The texts of the rules are MISRA's and not here: their numbers are.
"""

from __future__ import annotations

import json
import re
import subprocess
import sys
import tempfile
from collections import Counter
from pathlib import Path

REQUIRED = re.findall(
    r"[\d.]+",
    """
2.1 3.1 3.2 4.1 5.1 5.2 5.3 5.4 5.5 5.6 5.7 5.8 6.1 6.2 7.1 7.2 7.3 7.4 8.1 8.2 8.3 8.4 8.5 8.6
8.8 8.10 8.12 8.14 9.1 9.2 9.3 9.4 9.5 10.1 10.2 10.3 10.4 10.6 10.7 10.8 11.1 11.2 11.3 11.6
11.7 11.8 11.9 12.2 13.1 13.2 13.5 13.6 14.1 14.2 14.3 14.4 15.2 15.3 15.6 15.7 16.1 16.2 16.3
16.4 16.5 16.6 16.7 17.1 17.2 17.3 17.4 17.6 17.7 18.1 18.2 18.3 18.6 18.7 18.8 19.1 20.2 20.3
20.4 20.6 20.7 20.8 20.9 20.11 20.12 20.13 20.14 21.1 21.2 21.3 21.4 21.5 21.6 21.7 21.8 21.9
21.10 21.11 22.1 22.2 22.3 22.4 22.5 22.6
""",
)
"""Required and mandatory; advisory ones are not asked for."""


def findings(files: list[str], include: list[str]) -> dict[tuple[str, str], list[int]]:
    """Lines of each rule and file."""
    with tempfile.TemporaryDirectory() as folder:
        rules = Path(folder) / "rules.txt"
        texts = [f"Rule {rule} Required\nR{rule}\n" for rule in REQUIRED]
        rules.write_text("Appendix A Summary of guidelines\n" + "".join(texts))
        addon = Path(folder) / "misra.json"
        addon.write_text(json.dumps({"script": "misra.py", "args": [f"--rule-texts={rules}"]}))
        done = subprocess.run(
            ["cppcheck", "--quiet", "--std=c99", f"--addon={addon}", *include, *files],
            capture_output=True,
            text=True,
            check=False,
        )
    found: dict[tuple[str, str], list[int]] = {}
    for name, line, rule in re.findall(
        r"^([^\s:]+):(\d+):\d+: .*\[misra-c2012-([\d.]+)\]$", done.stderr, re.MULTILINE
    ):
        if name in files and rule in REQUIRED:
            found.setdefault((rule, name), []).append(int(line))
    return found


def main(deviations: Path, files: list[str], include: list[str]) -> int:
    """Compare; say what does not agree."""
    allowed: Counter[tuple[str, str]] = Counter()
    for line in deviations.read_text().splitlines():
        if line.startswith("D-"):
            _, rule, name, count, _ = line.split(maxsplit=4)
            allowed[rule, name] += int(count)
    found = findings(files, include)
    wrong = 0
    for key in sorted(set(found) | set(allowed)):
        lines = found.get(key, [])
        if len(lines) != allowed[key]:
            wrong += 1
            rule, name = key
            print(
                f"misra: rule {rule}: {name}, lines {lines}: {len(lines)} findings, "
                f"{allowed[key]} deviations in {deviations}"
            )
    total = sum(len(lines) for lines in found.values())
    print(f"misra: {len(files)} files, {total} findings, all deviations" if not wrong else "")
    return 1 if wrong else 0


if __name__ == "__main__":
    options = [argument for argument in sys.argv[2:] if argument.startswith("-")]
    names = [argument for argument in sys.argv[2:] if not argument.startswith("-")]
    sys.exit(main(Path(sys.argv[1]), names, options))
