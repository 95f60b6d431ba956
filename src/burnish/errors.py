"""The errors that burnish raises on purpose: one root and a child for each kind of refusal."""


class BurnishError(Exception):
    """Something was refused; the message says what was found, what was expected, and what to do."""


class InputError(BurnishError):
    """A value, an option or a file that the user gave cannot be used."""


class DescriptionError(InputError):
    """A robot description that no arm can have, or that is not a fixed-base serial arm."""


class MouldError(InputError):
    """A mould that cannot be read, or that is no surface a tool can work on."""


class RecordingError(InputError):
    """A recording, or another file of data, that is damaged, is none, or belongs to something else."""


class PlanError(InputError):
    """A job that this arm cannot do: out of reach, in collision, or too fast for its joints."""


class SimulationError(BurnishError):
    """The simulator left the states that physics allows; its numbers cannot be used."""


class HardwareError(BurnishError):
    """The real arm, its connection or its vendor's library failed or refused."""
