"""The signals.toml that reads a simulated recording back."""

from __future__ import annotations

import os
from pathlib import Path

from swaywatch.drive import Drive
from swaywatch.ecu.bus import DBC_PATH, MESSAGES
from swaywatch.roles import WHEEL_ROLES, WHEELS


def write_signals(path: Path, drive: Drive) -> None:
    """Write the mapping of ``swaywatch.dbc`` signals to the roles that a drive has."""
    signal = {entry[0]: entry[1] for entries in MESSAGES.values() for entry in entries}
    folder = path.resolve().parent
    lines = [f'dbc = "{Path(os.path.relpath(DBC_PATH, folder)).as_posix()}"', "", "[signals]"]
    done: set[str] = set()
    for name, channel in drive.channels.items():
        role = next((role for role in WHEEL_ROLES if name.startswith(f"{role}_")), None)
        if role is not None:
            if role not in done:
                parts = [
                    f'"{signal[f"{role}_{w}"]}"' if f"{role}_{w}" in drive.channels else '""'
                    for w in WHEELS
                ]
                lines.append(f"{role} = [{', '.join(parts)}]")
            done.add(role)
        elif name.endswith("lateral_acceleration"):
            lines.append(
                f'{name} = {{ signal = "{signal[name]}", position = {channel.position_m:g} }}'
            )
        else:
            lines.append(f'{name} = "{signal[name]}"')
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
