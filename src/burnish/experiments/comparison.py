"""Every law that follows a pose, side by side: one operator, the ideal arm, and three honest ones."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from typing import Any

from burnish.core import Controller, Source
from burnish.experiments.contenders import BETTER, CONTENDERS, HYBRIDS, PLAIN, Contender
from burnish.experiments.joint_motion import JointMotion
from burnish.experiments.operator import DURATION, Following, following, operator_motion
from burnish.experiments.simulated import TOOL_MOTION, text
from burnish.model.model import Model
from burnish.sim.arms import Arm, honest, ideal
from burnish.trials.experiment import Experiment, Finding, Trial, links_only, nominal
from burnish.trials.record import Record

SEEDS = (1, 2, 3)
"""Of the honest arm; every figure is that of the worst."""
THESIS, ROTORS, OURS = "thesis", "thesis, rotors in M", "ours"
"""Gains and model: the thesis's; its gains with the rotors that it did not know of; our gains, with them."""


def trials() -> Sequence[Trial]:
    """Ours on the ideal arm; ours and the theses' on the honest ones."""
    arm, links = ideal(0), links_only()
    made = [_trial(f"{c.name}, {OURS}, ideal", c, c.ours(arm), arm, links) for c in CONTENDERS if c.ours]
    for seed in SEEDS:
        arm, known = honest(seed), nominal(honest(seed))
        for c in CONTENDERS:
            if c.theirs is not None:
                made.append(_trial(f"{c.name}, {THESIS}, honest {seed}", c, c.theirs(), arm, c.model()))
            if c.theirs is not None and c.name in HYBRIDS + PLAIN:
                made.append(_trial(f"{c.name}, {ROTORS}, honest {seed}", c, c.theirs(), arm, known))
            if c.ours is not None:
                made.append(_trial(f"{c.name}, {OURS}, honest {seed}", c, c.ours(arm), arm, known))
    return made


def worst(records: Mapping[str, Record], law: str, gains: str, arm: str) -> Following | None:
    """Each figure at its worst over the seeds; None where a trial was stopped, or there is none."""
    of = [record for name, record in records.items() if name.startswith(f"{law}, {gains}, {arm}")]
    if not of or any(record.stopped is not None for record in of):
        return None
    every = [following(record) for record in of]
    return Following(**{each.name: max(getattr(f, each.name) for f in every) for each in fields(Following)})


def judge(records: Mapping[str, Record]) -> Sequence[Finding]:
    """A line a law, thesis B's finding, and whether ours is better than all."""
    lines = [
        Finding(claim=f"{c.name}, {gains}, {arm} arm.", measured=_text(records, c.name, gains, arm), holds=None)
        for gains, arm in ((OURS, "ideal"), (THESIS, "honest"), (OURS, "honest"))
        for c in CONTENDERS
        if (c.ours if gains == OURS else c.theirs) is not None
    ]
    return [*lines, *(_hybrids_couple_less(records, gains) for gains in (THESIS, ROTORS)), *_better(records)]


def _hybrids_couple_less(records: Mapping[str, Record], gains: str) -> Finding:
    """Thesis B, 5.2.6 and 5.2.7, of the position: its orientation gains differ too much to compare."""
    couplings = [[worst(records, law, gains, "honest") for law in laws] for laws in (HYBRIDS, PLAIN)]
    hybrids, plain = ([f.moved_mm if f else float("inf") for f in each] for each in couplings)
    turned = [[f.turned_deg if f else float("inf") for f in each] for each in couplings]
    return Finding(
        claim=f"Thesis B ({gains}): on the honest arm the hybrid laws couple less than the plain impedances.",
        measured=f"Turning moves the position by {_list(hybrids)} mm ({', '.join(HYBRIDS)}) against {_list(plain)} mm "
        f"({', '.join(PLAIN)}); moving turns the orientation by {_list(turned[0])}° against {_list(turned[1])}°.",
        holds=max(hybrids) < min(plain),
    )


def _better(records: Mapping[str, Record]) -> list[Finding]:
    """Position RMSE and both couplings, against the best of the theses in each."""
    ours = worst(records, BETTER, OURS, "honest")
    found = [(c.name, worst(records, c.name, THESIS, "honest")) for c in CONTENDERS]
    theses = [(name, f) for name, f in found if f is not None]
    findings = []
    for figure, what in (
        ("position_mm", "position RMSE [mm]"),
        ("moved_mm", "coupling into the position [mm]"),
        ("turned_deg", "coupling into the orientation [°]"),
    ):
        best, name = min((getattr(f, figure), name) for name, f in theses)
        mine = float("inf") if ours is None else getattr(ours, figure)
        findings.append(
            Finding(
                claim=f"{BETTER} with rotors in Λ, friction compensation and an integral, honest arm: {what} at most a "
                "third of the best thesis law's.",
                measured=f"{mine:.2f} against {best:.2f} ({name}): {mine / best:.2f} of it.",
                holds=mine <= best / 3.0,
            )
        )
    return findings


def _trial(name: str, c: Contender, law: Controller[Any], arm: Arm, model: Model) -> Trial:
    source: Source[Any] = operator_motion()
    if c.joints:
        source = JointMotion(source=operator_motion(), model=model)
    ours = f", {OURS}, " in name
    return Trial(name=name, law=law, source=source, duration=DURATION, arm=arm, model=model, ours=ours)


def _text(records: Mapping[str, Record], law: str, gains: str, arm: str) -> str:
    f = worst(records, law, gains, arm)
    if f is not None:
        cost = f"settles in {f.settling_s:.2f} s, effort {f.effort_Nm:.2g} N·m, roughness {f.roughness_Nm_s:.3g} N·m/s"
        return f"{text(f)} It {cost}, {f.step_us:.0f} µs a step."
    stopped = [r for name, r in records.items() if name.startswith(f"{law}, {gains}, {arm}") and r.stopped]
    return f"Stopped in {len(stopped)} of its trials, first after {stopped[0].time[-1]:.2f} s: {stopped[0].stopped}."


def _list(values: Sequence[float]) -> str:
    return ", ".join(f"{value:.1f}" for value in values)


EXPERIMENT = Experiment(
    title="All laws compared",
    source="Thesis B, 5.2, whose figures have no numbers; laws of both theses and the blog",
    about=f"""Every law that follows a pose does what the same operator asks, on the ideal arm at 1 kHz and on three
    honest arms at 100 Hz, of which the worst counts. Laws of the joints get the joint motion of the same poses. The
    theses' gains are those of their robots, with their models. Coupling into the position is how far the point moves,
    RMS, while only turns are asked for, from where it stood when they began; that into the orientation likewise.
    GravityCompensation follows nothing, ForceMotion without contact is OperationalSpace, and Adaptive is that of the
    law inside it: the three are left out. {TOOL_MOTION}""",
    trials=trials,
    judge=judge,
)
