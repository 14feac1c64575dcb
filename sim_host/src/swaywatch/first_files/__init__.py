"""``swaywatch init``: the first ``signals.toml`` and ``vehicle.toml`` of a recording.

The data flow inventory -> propose -> write.
"""
