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
VERSION = 2
"""Of the file's layout."""
LARGEST_FILE = 64 * 1024
"""Size beyond which a file is not a limits file [B]."""
JOINT_FIELDS = ("torque", "speed", "stiffness", "damping", "deviation", "lower", "upper")
"""Fields with one number a joint."""
MAY_BE_ABSENT = (
    "deviation",
    "lower",
    "upper",
    "tool_speed",
    "free_speed",
    "impact_force",
    "energy",
    "box_low",
    "box_high",
)
"""Fields that may be ±inf: no limit."""
SIGNED = ("lower", "upper", "box_low", "box_high", "axes", "capsules")
"""Fields whose numbers may be of either sign."""


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
    free_speed: float = inf
    """Speed of the tool point that is allowed where it may meet somebody [m/s]; it is braked below, stopped above."""
    impact_force: float = inf
    """Force that such a meeting may peak at [N]: with the mass μ that is felt it allows F/√(k μ)."""
    impact_stiffness: float = 75e3
    """Stiffness k of what it meets [N/m]: of a face (ISO/TS 15066, table A.3)."""
    impact_mass: float = 4.4
    """Mass of what it meets, free to move [kg]: of a head; μ is reduced by it."""
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

    axes: Array = field(default_factory=lambda: np.zeros((0, 6)))
    """Joint axes at q = 0, base frame: direction, and a point on it [m], (n, 6); none without capsules."""
    capsules: Array = field(default_factory=lambda: np.zeros((0, 8)))
    """What the arm must not hit of itself, at q = 0: the joint that moves it (0: none), both ends of its axis in the
    base frame and its radius [m], (m, 8). The last one belongs to the last joint and goes on to the tool point."""
    pairs: Array = field(default_factory=lambda: np.zeros((0, 2)))
    """Which capsules can meet, by their numbers, (k, 2)."""
    self_slow: float = 0.02
    """Distance of two capsules below which the arm is braked [m]."""
    self_stop: float = 0.01
    """Distance of two capsules at which the arm is stopped [m]."""

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
        self._check_capsules(n)
        for name, value in vars(self).items():
            values = np.asarray(value)
            good = not np.isnan(values).any() and (name in SIGNED or name == "pairs" or (values > 0.0).all())
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
        if not self.self_stop < self.self_slow:
            raise InputError(f"limits: self_stop {self.self_stop} m is not below self_slow {self.self_slow} m")

    def _check_capsules(self, n: int) -> None:
        """Tables of the right width, with joints and capsules that there are."""
        for name, width in (("axes", 6), ("capsules", 8), ("pairs", 2)):
            table = read_only(getattr(self, name))
            table = table.reshape(0, width) if table.size == 0 else table
            object.__setattr__(self, name, table)
            if table.ndim != 2 or table.shape[1] != width:
                raise InputError(f"limits: {name} has shape {table.shape}; expected (…, {width})")
        carriers, count = self.capsules[:, 0], len(self.capsules)
        if count and not (len(self.axes) == n == carriers[-1] and np.isin(carriers, np.arange(n + 1)).all()):
            raise InputError(
                f"limits: capsules of joints {carriers}; expected 0 to {n}, the last one {n}, and {n} axes"
            )
        if count and not (self.capsules[:, 7] > 0.0).all():
            raise InputError(f"limits: capsules with radii {self.capsules[:, 7]} m; expected more than 0")
        if not np.isin(self.pairs, np.arange(count)).all():
            raise InputError(f"limits: pairs = {self.pairs.tolist()}; expected numbers of {count} capsules")

    @classmethod
    def of(cls, model: Model) -> Limits:
        """The description's torque, speed and position limits, and a soft hold scaled to the joints' torque.

        The hold is 135/28 N·m/rad and 12/3 N·m·s/rad on the JACO2: stiff enough to carry an unknown kilogram
        within 50 mm, soft enough to give way to a hand.
        """
        strong = model.effort_limit > 0.5 * model.effort_limit.max()
        return cls(
            torque=model.effort_limit,
            speed=model.velocity_limit,
            lower=model.lower,
            upper=model.upper,
            stiffness=np.where(strong, 135.0, 28.0),
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
        return [_plain(v if np.ndim(v) else float(v)) for v in value]
    return float(value) if np.isfinite(value) else None


def _number(path: str | Path, name: str, value: Any) -> Any:
    """Back from `_plain`; the sign of what is absent is told by the name."""
    none = -inf if name in ("lower", "box_low") else inf
    if isinstance(value, list) and len(value) <= 64:
        try:
            return np.array([_number(path, name, v) for v in value], dtype=float)
        except ValueError as error:
            raise InputError(f"{path}: {name} has rows of different lengths") from error
    if value is None:
        return none
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
        raise InputError(f"{path}: {name} = {value!r}; expected a number, a list of numbers, or null for no limit")
    return float(value)


def _refuse_constant(name: str) -> float:
    raise ValueError(f"{name} is no number")
