"""What swaywatch raises when its input is at fault.

Exception
└── SwaywatchError           a sentence for the user: file, signal, value, and what would be right
    ├── RecordingError       a recording that cannot be read, or not whole
    ├── SignalError          a signals.toml, a DBC or a signal that does not fit the recording
    ├── VehicleError         a vehicle.toml with a value missing or out of range
    ├── ModelError           a linear model that cannot be read, or lacks something
    ├── FmuError             an FMU that cannot be run, or whose variables do not fit the roles
    └── ScenarioError        a scenario for the simulator that does not make sense
"""


class SwaywatchError(Exception):
    """The user's input is at fault; the text says which, and what would be right."""


class RecordingError(SwaywatchError):
    """A recording cannot be read, or not to its end."""


class SignalError(SwaywatchError):
    """Roles, DBC and recording do not fit together."""


class VehicleError(SwaywatchError):
    """A vehicle parameter is missing or outside its range."""


class ScenarioError(SwaywatchError):
    """A scenario for the simulator has an unknown key or a value out of range."""


class ModelError(SwaywatchError):
    """A linear model of the user cannot be read, or lacks something."""


class FmuError(SwaywatchError):
    """An FMU cannot be opened or run, or its variables do not fit the roles."""
