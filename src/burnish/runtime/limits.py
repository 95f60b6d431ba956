"""`Limits`: what no command and no state may exceed, as one file whose hash is kept with every run."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, field, fields
from importlib.resources import files
from math import inf, radians
from pathlib import Path
from typing import Any

import numpy as np
from typing_extensions import Self

from burnish.core import Array, read_only
from burnish.errors import InputError
from burnish.model.model import Model

JACO2_LIMITS = Path(str(files("burnish") / "assets" / "jaco2_limits.json"))
VERSION = 1
"""Of the file's layout."""
LARGEST_FILE = 64 * 1024
"""Size beyond which a file is not a limits file [B]."""
JOINT_FIELDS = ("torque", "speed", "stiffness", "damping", "deviation", "lower", "upper")
"""Fields with one number a joint."""
MAY_BE_ABSENT = ("deviation", "lower", "upper", "tool_speed", "energy", "box_low", "box_high")
"""Fields that may be ±inf: no limit."""


@dataclass(frozen=True, kw_only=True)
class Limits:
    """What no command and no state may exceed; a limit that is ±inf is none."""

    torque: Array
    """Largest joint torque [N·m], (n,)."""
    torque_rate: float = 300.0
    """Largest change of a joint torque [N·m/s]."""
    deviation: Array = field(default_factory=lambda: np.zeros(0))
    """Largest difference of a torque from gravity [N·m], (n,); none when it is not given."""
    speed: Array
    """Joint speed at which the arm is stopped [rad/s], (n,)."""
    lower: Array = field(default_factory=lambda: np.zeros(0))
    """Lowest joint positions [rad], (n,); −inf for a continuous joint, and where it is not given."""
    upper: Array = field(default_factory=lambda: np.zeros(0))
    """Highest joint positions [rad], (n,)."""
    soft_margin: float = radians(15.0)
    """Distance from a joint limit at which the joint begins to be pushed back [rad]; at most a tenth of its range."""
    hard_margin: float = radians(5.0)
    """Distance from a joint limit at which the arm is stopped [rad]; at most a thirtieth of its range."""
    tool_speed: float = inf
    """Speed of the tool point at which the arm is stopped [m/s]."""
    tool_force: float = 25.0
    """Contact force at which the tool retreats [N]."""
    energy: float = inf
    """Kinetic energy ½ q̇ᵀ M q̇ at which the arm is stopped [J]."""
    box_low: Array = field(default_factory=lambda: np.full(3, -inf))
    """Least coordinates of the tool point, base frame [m], (3,)."""
    box_high: Array = field(default_factory=lambda: np.full(3, inf))
    """Largest coordinates of the tool point, base frame [m], (3,)."""
    stiffness: Array
    """Of the hold after a trip [N·m/rad], (n,)."""
    damping: Array
    """Of the hold after a trip [N·m·s/rad], (n,)."""
    retreat: float = 0.02
    """Distance by which the tool retreats along the contact force after too much of it [m]."""

    def __post_init__(self) -> None:
        n = len(np.atleast_1d(self.torque))
        for name, blank in (("deviation", inf), ("lower", -inf), ("upper", inf)):
            if np.size(getattr(self, name)) == 0:
                object.__setattr__(self, name, np.full(n, blank))
        for name in (*JOINT_FIELDS, "box_low", "box_high"):
            values = read_only(getattr(self, name))
            object.__setattr__(self, name, values)
            size = n if name in JOINT_FIELDS else 3
            if values.shape != (size,):
                raise InputError(f"limits: {name} has shape {values.shape}; expected ({size},)")
        for name, value in vars(self).items():
            signed = name in ("lower", "upper", "box_low", "box_high")
            values = np.asarray(value)
            good = not np.isnan(values).any() and (signed or (values > 0.0).all())
            if not good or not (name in MAY_BE_ABSENT or np.isfinite(values).all()):
                raise InputError(f"limits: {name} = {value}; expected finite numbers more than 0")
        if not (self.lower < self.upper).all() or not (self.box_low < self.box_high).all():
            raise InputError(
                "limits: a lower limit is not below its upper one; expected lower < upper, box_low < box_high"
            )
        if not self.hard_margin < self.soft_margin:
            raise InputError(
                f"limits: hard_margin {self.hard_margin} rad is not below soft_margin {self.soft_margin} rad"
            )

    @classmethod
    def of(cls, model: Model) -> Limits:
        """The description's torque, speed and position limits, and a soft hold scaled to the joints' torque.

        The hold is 120/25 N·m/rad and 12/3 N·m·s/rad on the JACO2: stiff enough to carry an unknown kilogram
        within 50 mm, soft enough to give way to a hand.
        """
        strong = model.effort_limit > 0.5 * model.effort_limit.max()
        return cls(
            torque=model.effort_limit,
            speed=model.velocity_limit,
            lower=model.lower,
            upper=model.upper,
            stiffness=np.where(strong, 120.0, 25.0),
            damping=np.where(strong, 12.0, 3.0),
        )

    @classmethod
    def jaco2(cls) -> Self:
        """Those of the packaged file for the JACO2: what it may do at work, with people about, not what it can."""
        return cls.load(JACO2_LIMITS)

    def within(self, margin: float, most: float) -> tuple[Array, Array]:
        """The joint limits less a margin [rad], or less this share of a joint's range if that is less."""
        inner = np.minimum(margin, most * (self.upper - self.lower))
        return self.lower + inner, self.upper - inner

    def to_json(self) -> str:
        """The file's text; a limit that is none is null."""
        values = {name: _plain(value) for name, value in vars(self).items()}
        return json.dumps({"version": VERSION} | values, indent=2, allow_nan=False) + "\n"

    @classmethod
    def load(cls, path: str | Path) -> Self:
        """Read a limits file.

        Raises:
            InputError: if the file is missing, too large, no limits file, or a value is none that a limit can have.
        """
        try:
            if Path(path).stat().st_size > LARGEST_FILE:
                raise InputError(f"{path} is larger than {LARGEST_FILE // 1024} KiB; expected a limits file")
            text = Path(path).read_text(encoding="utf-8")
            found = json.loads(text, parse_constant=_refuse_constant)
        except OSError as error:
            raise InputError(f"cannot read limits from {path}: {error.strerror}") from error
        except (ValueError, RecursionError) as error:
            raise InputError(f"{path} is no limits file: {error}; expected JSON as Limits.to_json writes it") from error
        names = {f.name for f in fields(cls)}
        if not isinstance(found, dict) or found.pop("version", None) != VERSION or set(found) != names:
            raise InputError(
                f"{path} is no limits file of version {VERSION}; expected exactly: {', '.join(sorted(names))}"
            )
        return cls(**{name: _number(path, name, value) for name, value in found.items()})

    @property
    def hash(self) -> str:
        """SHA-256 of the file's text."""
        return hashlib.sha256(self.to_json().encode()).hexdigest()


def _plain(value: Any) -> Any:
    """Numbers for JSON, null for ±inf."""
    if isinstance(value, np.ndarray):
        return [_plain(float(v)) for v in value]
    return float(value) if np.isfinite(value) else None


def _number(path: str | Path, name: str, value: Any) -> Any:
    """Back from `_plain`; the sign of what is absent is told by the name."""
    none = -inf if name in ("lower", "box_low") else inf
    if isinstance(value, list) and len(value) <= 64:
        return np.array([_number(path, name, v) for v in value], dtype=float)
    if value is None:
        return none
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
        raise InputError(f"{path}: {name} = {value!r}; expected a number, a list of numbers, or null for no limit")
    return float(value)


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is no number")
