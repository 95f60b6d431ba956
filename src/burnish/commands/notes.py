"""What is noted of a job while it runs: how far it is, and when each pass was under way."""

from __future__ import annotations

from dataclasses import dataclass, field

from burnish.core import Sample, ToolReference
from burnish.polish.journal import ENDS, EVERY, Journal, Mark
from burnish.polish.process import Job


@dataclass(kw_only=True)
class Notes:
    """Tells the journal how far a job is, and keeps when each pass was under way."""

    job: Job
    """The job."""
    spans: list[tuple[int, float, float]]
    """Pass, start and end of each piece of work [s]; grows as the job is run."""
    journal: Journal | None
    """Where it is written, if there is one."""
    _last: tuple[int, str, float] = field(default=(-1, "", 0.0), init=False, repr=False)
    _force: list[float] = field(default_factory=list, init=False, repr=False)

    def add(self, sample: Sample) -> None:
        """One cycle."""
        job = self.job
        leg, phase, s = self._last
        reference = sample.reference
        if isinstance(reference, ToolReference) and reference.normal is not None and sample.arm.F is not None:
            self._force.append(float(reference.normal @ sample.arm.F[:3]))
        if job.phase in ENDS:
            # How the run ends is for `end` to say, once.
            return
        if (job.stroke, job.phase) != (leg, phase):
            if job.phase == "pass":
                self.spans.append((job.leg.number, sample.arm.t, sample.arm.t))
            self._mark(job.phase, sample.arm.t)
        elif job.phase == "pass":
            number, start, _ = self.spans[-1]
            self.spans[-1] = (number, start, sample.arm.t)
            if job.worked - s >= EVERY:
                self._mark(job.phase, sample.arm.t)

    def end(self) -> None:
        """The run is over."""
        job = self.job
        unfinished = job.interrupted or job.failure is not None or job.rig.supervisor.tripped
        self._mark("stopped" if unfinished else "change" if job.pause is not None else "done", job.arm().t)

    def _mark(self, phase: str, t: float) -> None:
        job = self.job
        self._last = (job.stroke, phase, job.worked)
        force = sum(self._force) / len(self._force) if self._force else 0.0
        self._force.clear()
        if self.journal is not None and job.located:
            self.journal.add(
                Mark(
                    number=job.leg.number,
                    stroke=job.leg.stroke,
                    s=job.worked,
                    phase=phase,
                    force=force,
                    t=t,
                    metres=job.abrasive.metres,
                    joules=job.abrasive.joules,
                )
            )
