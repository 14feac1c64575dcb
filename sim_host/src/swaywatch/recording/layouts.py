"""What a viewer shows first of a merged recording: layout files for Foxglove and PlotJuggler.

Both name curves by topic and field, so a layout is made for its MCAP file and stands beside it.
Sources: Foxglove's layout export and message path syntax (a field with a dot in its name is
quoted); PlotJuggler's saved layouts (a curve is ``topic/field``).
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from swaywatch.recording.frames import Series
from swaywatch.recording.guard import whole_file
from swaywatch.recording.mcap import topics

PANELS: tuple[tuple[str, tuple[str, ...]], ...] = (
    ("Speed and critical speed [m/s]", ("speed", "swaywatch.v_crit_m_s")),
    ("Yaw rate [rad/s]", ("car_yaw_rate", "trailer_yaw_rate")),
    ("Steering wheel angle [rad]", ("steering_wheel_angle",)),
    ("Damping ratio", ("swaywatch.damping_ratio", "swaywatch.model_damping_ratio")),
    ("Cornering stiffness [N/rad]", tuple(
        f"swaywatch.{axle}.cornering_stiffness_n_per_rad"
        for axle in ("car_front", "car_rear", "trailer_front", "trailer_rear")
    )),
    ("Alarm", ("swaywatch.alarm",)),
)  # fmt: skip
"""Title and signals of each plot, from top to bottom; what a recording lacks is left out."""
COLOURS = ("#1f77b4", "#d62728", "#2ca02c", "#ff7f0e")


def write_layouts(path: Path, signals: dict[str, Series]) -> list[Path]:
    """Write ``NAME.foxglove.json`` and ``NAME.plotjuggler.xml`` beside an MCAP file.

    Parameters
    ----------
    path
        Of the MCAP file.
    signals
        Written to it.

    Returns
    -------
    list of Path
        The files written; none where no plot has a signal.
    """
    where = topics(signals)
    panels = [
        (title, found) for title, names in PANELS if (found := [n for n in names if n in where])
    ]
    if not panels:
        return []
    texts = {
        ".foxglove.json": json.dumps(_foxglove(panels, where), indent=1),
        ".plotjuggler.xml": _plotjuggler(panels, where, signals),
    }
    for suffix, text in texts.items():
        with whole_file(path.with_suffix(suffix)) as temporary:
            temporary.write_text(text + "\n", encoding="utf-8")
    return [path.with_suffix(suffix) for suffix in texts]


def _foxglove(panels: list[tuple[str, list[str]]], where: dict[str, str]) -> dict[str, Any]:
    plots = {
        f"Plot!swaywatch{number}": {
            "title": title, "foxglovePanelTitle": title, "isSynced": True, "xAxisVal": "timestamp",
            "showLegend": True, "legendDisplay": "floating",
            "showXAxisLabels": True, "showYAxisLabels": True,
            "paths": [
                {"value": f'{where[name]}."{name}"', "label": name, "color": colour,
                 "enabled": True, "timestampMethod": "receiveTime"}
                for name, colour in zip(names, COLOURS, strict=False)
            ],
        }
        for number, (title, names) in enumerate(panels)
    }  # fmt: skip
    *above, layout = plots  # the last plot; each one above takes its share of what is left
    tree: Any = layout
    for below, name in enumerate(reversed(above), start=1):
        share = 100.0 / (below + 1)
        tree = {"direction": "column", "first": name, "second": tree, "splitPercentage": share}
    return {
        "configById": plots, "globalVariables": {}, "userNodes": {},
        "playbackConfig": {"speed": 1}, "layout": tree,
    }  # fmt: skip


def _plotjuggler(
    panels: list[tuple[str, list[str]]], where: dict[str, str], signals: dict[str, Series]
) -> str:
    stamps = [series.time_ns for series in signals.values() if len(series.time_ns)]
    length_s = (max(int(t[-1]) for t in stamps) - min(int(t[0]) for t in stamps)) * 1e-9
    root = ElementTree.Element("root")
    window = ElementTree.SubElement(
        root, "tabbed_widget", {"name": "Main Window", "parent": "main_window"}
    )
    tab = ElementTree.SubElement(window, "Tab", tab_name="swaywatch", containers="1")
    docks = ElementTree.SubElement(
        ElementTree.SubElement(tab, "Container"), "DockSplitter", orientation="-",
        count=str(len(panels)), sizes=";".join(f"{1 / len(panels):.6f}" for _ in panels),
    )  # fmt: skip
    for title, names in panels:
        dock = ElementTree.SubElement(docks, "DockArea", name=title)
        plot = ElementTree.SubElement(dock, "plot", mode="TimeSeries", style="Lines")
        low, high = _range([signals[name] for name in names])
        ElementTree.SubElement(
            plot, "range", left="0", right=f"{length_s:.6f}", bottom=f"{low:.9g}", top=f"{high:.9g}"
        )
        ElementTree.SubElement(plot, "limitY")
        for name, colour in zip(names, COLOURS, strict=False):
            ElementTree.SubElement(plot, "curve", name=f"{where[name]}/{name}", color=colour)
    ElementTree.SubElement(window, "currentTabIndex", index="0")
    ElementTree.SubElement(root, "use_relative_time_offset", enabled="1")
    ElementTree.indent(root, " ")
    return "<?xml version='1.0' encoding='UTF-8'?>\n" + ElementTree.tostring(root, "unicode")


def _range(shown: list[Series]) -> tuple[float, float]:
    """Least and largest finite value, a tenth more to either side."""
    values = np.concatenate([series.value for series in shown])
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    room = 0.1 * (high - low) or 1.0
    return low - room, high + room
