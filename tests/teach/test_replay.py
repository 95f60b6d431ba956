"""The reference along a track: by place, not by time; pause, leash, and the same force however fast."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from teach.cells import TOOL, dome, shown

from burnish.core import Array, ToolReference
from burnish.errors import InputError
from burnish.polish.process import SETTLE
from burnish.record.poses_file import Poses
from burnish.rotation import exp, log, quaternions
from burnish.teach.cleanup import Piece, cleaned
from burnish.teach.replay import LEASH, PAUSE, Along, Track
from burnish.trajectory.path import START_ACCELERATION

DT = 0.01


def track(factor: float = 1.0) -> Track:
    taught = cleaned(shown(), dome()[1], TOOL)
    return Track.of(contact(), taught.placement, factor)


def contact() -> Piece:
    (piece,) = cleaned(shown(), dome()[1], TOOL).contacts
    return piece


def run(
    along: Along, held: Callable[[int], bool] = lambda k: False, change: Callable[[int], None] = lambda k: None
) -> tuple[list[ToolReference], list[float]]:
    """References of a tool that follows exactly, but for the cycles in which it is held where it is."""
    p = along.track.p[0]
    references, places = [], []
    for k in range(20_000):
        arm: Any = SimpleNamespace(t=k * DT, p=p)
        if k == 0:
            along.reset(arm)
        change(k)
        references.append(along.at(arm))
        places.append(along.s)
        if not held(k):
            p = references[-1].p
        if along.arrived(arm):
            return references, places
    raise AssertionError("the track never ends")


def test_the_track_is_gone_from_its_first_node_to_its_last() -> None:
    along = Along(track=track())
    references, places = run(along)
    assert references[0].p == pytest.approx(along.track.p[0], abs=1e-9)
    assert references[-1].p == pytest.approx(along.track.p[-1], abs=1e-9)
    assert (np.diff(places) >= 0.0).all()


def test_the_twist_is_the_change_of_the_pose() -> None:
    references, _ = run(Along(track=track()))
    p = np.array([r.p for r in references])
    v = np.array([r.v for r in references])
    # A reference says what is to come: it moves on by ṡ dt before the next one.
    assert np.abs(np.diff(p, axis=0) / DT - v[1:, :3])[5:-2].max() < 2e-3
    turn = np.array([log(b.R @ a.R.T) for a, b in pairwise(references)])
    assert np.abs(turn / DT - v[1:, 3:])[5:-2].max() < 2e-2


def test_the_force_rises_where_the_tool_stands_and_then_belongs_to_the_place() -> None:
    for factor in (0.5, 1.0, 2.0):
        along = Along(track=track(factor))
        references, places = run(along)
        standing = sum(s == 0.0 for s in places)
        assert standing * DT == pytest.approx(SETTLE, abs=3 * DT)
        assert references[0].force < 0.2
        s = along.track.ds * np.arange(len(along.track.force))
        found = np.interp(s, places[standing:], [r.force for r in references[standing:]])
        assert np.abs(found - along.track.force)[2:-2].max() < 0.02


def test_half_as_fast_takes_longer() -> None:
    assert len(run(Along(track=track(0.5)))[0]) > 1.3 * len(run(Along(track=track(1.0)))[0])


def test_it_starts_and_ends_gently() -> None:
    speed, ds = track().speed, track().ds
    gained = np.diff(speed**2) / (2.0 * ds)
    assert gained[:3].max() <= 1.6 * START_ACCELERATION
    assert speed[0] <= 1.1e-3
    assert speed[-1] <= 1.1e-3


def test_a_paused_track_stands_with_its_force_and_goes_on_from_there() -> None:
    along = Along(track=track())

    def change(k: int) -> None:
        along.paused = 200 <= k < 400

    references, places = run(along, change=change)
    stood = 200 + round(PAUSE / DT) + 1
    assert places[399] == places[stood] > 0.0
    assert references[399].force == references[stood].force > 5.0
    assert np.abs(references[399].v).max() == 0.0
    assert places[-1] == along.track.length
    # No leap when it goes on.
    assert np.diff(places).max() <= along.track.speed.max() * DT * 1.01


def test_the_path_waits_for_a_tool_that_is_held_back() -> None:
    along = Along(track=track())
    references, _ = run(along, held=lambda k: 250 <= k < 600)
    p = np.array([r.p for r in references])
    lag = np.linalg.norm(p[599] - p[249])
    assert LEASH[0] < lag < LEASH[1] + 1e-3


def test_poses_by_time_come_when_they_were_asked_for() -> None:
    demonstration = shown()
    along = Along(track=Track.by_time(demonstration, demonstration.placement, 2.0))
    references, _ = run(along, held=lambda k: True)
    asked = demonstration.placement.points(demonstration.p_d)
    assert references[100].p == pytest.approx(asked[200 + 2], abs=5e-4)
    assert references[100].normal is None
    assert len(references) == pytest.approx(len(asked) / 2, abs=3)


def test_poses_without_times_are_passed_at_one_feed() -> None:
    n = 200
    R = np.array([exp(np.array([0.0, 0.0, 0.2 * k / n])) for k in range(n)])
    p = np.column_stack([np.linspace(0.0, 0.1, n), np.zeros(n), np.zeros(n)])
    made = Track.by_poses(Poses(p=p, Q=quaternions(R)), 1.0)
    assert made.speed.max() == pytest.approx(0.02)
    assert made.p[-1] == pytest.approx(p[-1])
    along = Along(track=made)
    references, _ = run(along)
    assert references[-1].p == pytest.approx(p[-1])


def test_poses_that_do_not_move_are_refused() -> None:
    still = Poses(p=np.zeros((50, 3)), Q=np.tile([1.0, 0.0, 0.0, 0.0], (50, 1)))
    with pytest.raises(InputError, match="expected a path"):
        Track.by_poses(still)


def test_the_path_that_is_checked_ahead_is_the_one_that_is_run() -> None:
    made = track()
    timed = made.timed()
    along = Along(track=made)
    references, places = run(along)
    moving: Array = np.array([r.p for r, s in zip(references, places, strict=True) if s > 0.0])
    t = DT * np.arange(len(moving))
    planned = np.column_stack([np.interp(t, timed.dt * np.arange(len(timed.p)), x) for x in timed.p.T])
    assert np.abs(planned - moving).max() < 2e-3
