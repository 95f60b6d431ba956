"""The recipe of a job: what a user chooses, with its ranges."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from typing_extensions import Self

from burnish.errors import InputError
from burnish.model.tool import PolishingTool
from burnish.paths.patterns import Pattern, Raster
from burnish.paths.tilt import STEEPEST_LEAN, Tilt
from burnish.polish.ranges import Range
from burnish.polish.wanted import Even, Smoothing

MARGIN = 3e-3
"""The path's inset from the border of the part [m]: the mould may have slid 2 mm, and the tip must not fall."""
EDGE_BAND = 6e-3
"""Band along the border that is not judged [m]: the inset, 2 mm for a mould that slid, and the end of a track."""
PRESTON = 1e-11
"""Removal per pressure and distance [1/Pa]. A placeholder to be calibrated on the real felt, paste and steel: no
trustworthy figure is published. All percentages are free of it."""
LONGEST_TEXT = 200
"""Characters of a text in a recipe."""
MOST_PASSES = 20
"""Passes of a recipe."""
LEAST_FORCE = 1.0
"""Least force of a stroke [N]: where lines lie closer, or along an end, a pattern presses with half of it."""
SLOWEST_FEED = 1e-3
"""Least feed of a stroke [m/s]: a feed profile may ask for a longer stay than the feed of a pass."""


FORCE = Range(unit="N", low=2.0, high=20.0)
FEED = Range(unit="m/s", low=0.005, high=0.08)
STEP = Range(unit="m", low=1e-4, high=20e-3)
LEAN = Range(unit="rad", low=0.0, high=STEEPEST_LEAN)
ANGLE = Range(unit="rad", low=-2.0 * float(np.pi), high=2.0 * float(np.pi))
PRESTONS = Range(unit="1/Pa", low=1e-16, high=1e-6)
SPINDLE = Range(unit="rad/s", low=-3000.0, high=3000.0)
BOUNDS: Mapping[str, Range] = {
    "joint_speed": Range(unit="", low=0.1, high=0.9),
    "joint_torque": Range(unit="", low=0.1, high=0.9),
    "joint_margin": Range(unit="rad", low=float(np.deg2rad(5.0)), high=0.8),
    "singularity": Range(unit="m", low=0.01, high=0.2),
    "clearance": Range(unit="m", low=2e-3, high=0.1),
    "least_feed": Range(unit="", low=0.05, high=1.0),
}
"""Of the fields of `Bounds`."""
TOOL: Mapping[str, Range] = {
    "body_mass": Range(unit="kg", low=0.01, high=2.0),
    "body_com": Range(unit="m", low=1e-3, high=0.3),
    "body_radius": Range(unit="m", low=2e-3, high=0.1),
    "tip_mass": Range(unit="kg", low=1e-3, high=1.0),
    "tip_radius": Range(unit="m", low=2e-3, high=0.05),
    "length": Range(unit="m", low=0.02, high=0.5),
    "stiffness": Range(unit="N/m", low=1e3, high=1e5),
    "damping_ratio": Range(unit="", low=0.01, high=2.0),
    "modulus": Range(unit="Pa", low=1e4, high=1e12),
    "friction": Range(unit="", low=0.01, high=1.5),
}
"""Of the fields of `PolishingTool` in a recipe, but for its spindle, whose unit stands in its name there."""


@dataclass(frozen=True, kw_only=True)
class Pass:
    """Once over the mould. What is left open is the recipe's."""

    pattern: Pattern
    """How the surface is covered."""
    force: float | None = None
    """Contact force [N], 2 to 20; None: the recipe's."""
    feed: float | None = None
    """Speed along the path [m/s], 0.005 to 0.08; None: the recipe's."""
    step: float | None = None
    """Distance of neighbouring lines on the surface [m]; None: 0.3 of the width of the contact there."""
    tilt: Tilt = field(default_factory=Tilt)
    """How the tool leans; upright unless told otherwise."""

    def __post_init__(self) -> None:
        for name, value, allowed in (
            ("force", self.force, FORCE),
            ("feed", self.feed, FEED),
            ("step", self.step, STEP),
        ):
            if value is not None:
                allowed.check(f"pass: {name}", value)


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """What a plan may use of the arm."""

    joint_speed: float = 0.9
    """Share of a joint's speed limit."""
    joint_torque: float = 0.8
    """Share of a joint's torque limit; the rest is for friction in the joints, which nobody knows well."""
    joint_margin: float = float(np.deg2rad(10.0))
    """Distance from a joint limit [rad]."""
    singularity: float = 0.02
    """Least motion of the tool for a turn of the joints by 1 rad [m]; turns count with a lever of 0.2 m."""
    clearance: float = 5e-3
    """Distance of the arm and the tool's body from the mould, its stand and the floor [m]."""
    least_feed: float = 0.6
    """Share of the wanted feed below which a stroke is refused rather than slowed down; of a pass that covers the mould
    it is the share for all its strokes together."""

    def __post_init__(self) -> None:
        for name, allowed in BOUNDS.items():
            allowed.check(f"limits: {name}", getattr(self, name))


@dataclass(frozen=True, kw_only=True)
class Recipe:
    """What to do on the mould, with what, and how near the arm may come to what it can."""

    force: float = 10.0
    """Contact force [N], 2 to 20."""
    feed: float = 0.02
    """Speed along the path [m/s], 0.005 to 0.08."""
    grit: str = ""
    """The abrasive, in the words of who uses it."""
    preston: float = PRESTON
    """Removal per pressure and distance [1/Pa]."""
    passes: tuple[Pass, ...] = ()
    """The passes in order; none stands for one raster with this force and feed."""
    tool: PolishingTool = field(default_factory=PolishingTool)
    """The tool in the arm's hand."""
    limits: Bounds = field(default_factory=Bounds)
    """What the plan may use of the arm."""
    even: Even | None = None
    """The depth that the passes are to remove together; None: what their force, feed and step remove."""
    roughness: Smoothing | None = None
    """How the grit smoothes; None: not known, so no roughness is estimated."""

    def __post_init__(self) -> None:
        FORCE.check("force", self.force)
        FEED.check("feed", self.feed)
        PRESTONS.check("preston", self.preston)
        if not isinstance(self.grit, str) or len(self.grit) > LONGEST_TEXT or not self.grit.isprintable():
            raise InputError(
                f"grit {str(self.grit)[:40]!r} is no plain text; expected at most {LONGEST_TEXT} characters in one line"
            )
        if len(self.passes) > MOST_PASSES:
            raise InputError(f"the recipe has {len(self.passes)} passes; expected at most {MOST_PASSES}")
        for name, allowed in TOOL.items():
            allowed.check(f"tool: {name}", getattr(self.tool, name))
        SPINDLE.check("tool: spindle", self.tool.spindle)
        if self.even is not None and self.tool.spindle == 0.0:
            raise InputError(
                "even: a tool that does not spin removes by distance, so no feed makes its removal even; state its "
                "spindle_rpm or spindle_rad_s under [tool]"
            )
        if not self.tool.tip_radius < self.tool.length:
            raise InputError(
                f"tool: tip_radius {self.tool.tip_radius:g} m is not less than its length {self.tool.length:g} m"
            )

    def of_pass(self, one: Pass) -> Self:
        """The recipe with the force and feed of one of its passes."""
        force, feed = one.force, one.feed
        return replace(self, force=self.force if force is None else force, feed=self.feed if feed is None else feed)

    @property
    def worked(self) -> tuple[Pass, ...]:
        """The passes; one raster where there is none."""
        return self.passes or (Pass(pattern=Raster()),)
