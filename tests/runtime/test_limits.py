from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.testing import assert_allclose

from burnish.errors import InputError
from burnish.model.model import Model
from burnish.runtime.limits import JACO2_LIMITS, Limits

MODEL = Model.jaco2()
LIMITS = Limits.of(MODEL)


def written(tmp_path: Path, **changes: Any) -> Path:
    """The file of the model's limits with some values changed; Ellipsis removes one."""
    content = json.loads(LIMITS.to_json()) | changes
    path = tmp_path / "limits.json"
    path.write_text(json.dumps({k: v for k, v in content.items() if v is not ...}))
    return path


def test_what_is_written_is_read_again_bit_by_bit(tmp_path: Path) -> None:
    path = tmp_path / "limits.json"
    path.write_text(LIMITS.to_json())
    read = Limits.load(path)
    for name, value in vars(LIMITS).items():
        assert_allclose(getattr(read, name), value, atol=0.0)
    assert read.hash == LIMITS.hash


def test_hash_tells_limits_apart() -> None:
    assert replace(LIMITS, tool_force=24.9).hash != LIMITS.hash


def test_limits_of_the_jaco2_are_no_more_than_the_arm_can() -> None:
    at_work = Limits.jaco2()
    assert (at_work.torque <= MODEL.effort_limit).all()
    assert (at_work.speed <= MODEL.velocity_limit).all()
    assert (at_work.lower >= MODEL.lower).all()
    assert (at_work.upper <= MODEL.upper).all()
    assert at_work.energy <= 0.5
    assert at_work.tool_speed <= 0.25
    assert at_work.free_speed <= 0.15
    # What a face bears; the rest is for the model's errors.
    assert at_work.impact_force <= 65.0
    assert_allclose(at_work.deviation, [20.0, 20.0, 20.0, 5.0, 5.0, 5.0])


BAD: dict[str, dict[str, Any]] = {
    "no version": {"version": ...},
    "another version": {"version": 1},
    "a value is missing": {"speed": ...},
    "an unknown value": {"colour": 1.0},
    "a word for a number": {"energy": "much"},
    "a number beyond all": {"energy": 10**400},
    "true for a number": {"energy": True},
    "a list of words": {"speed": ["fast"] * 6},
    "too few joints": {"speed": [1.0] * 5},
    "a negative speed": {"speed": [1.0] * 5 + [-1.0]},
    "no torque limit": {"torque": [None] * 6},
    "limits the wrong way round": {"lower": [3.0] * 6, "upper": [-3.0] * 6},
    "margins the wrong way round": {"hard_margin": 0.5},
    "rows of different lengths": {"pairs": [[1.0], [1.0, 2.0]]},
    "a list without end": {"speed": [1.0] * 1000},
}


@pytest.mark.parametrize("case", BAD)
def test_file_that_makes_no_sense_is_refused_in_one_line(case: str, tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        Limits.load(written(tmp_path, **BAD[case]))
    assert "\n" not in str(refused.value)


def test_infinity_in_disguise_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "limits.json"
    path.write_text(LIMITS.to_json().replace('"energy": null', '"energy": 1e999'))
    with pytest.raises(InputError, match="energy"):
        Limits.load(path)


@pytest.mark.parametrize("text", ["", "{", "[]", '{"version": NaN}', "[" * 100_000, '{"a": 1e999}', "\0", "x" * 70_000])
def test_file_that_is_none_is_refused(text: str, tmp_path: Path) -> None:
    path = tmp_path / "limits.json"
    path.write_text(text)
    with pytest.raises(InputError):
        Limits.load(path)


def test_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot read limits"):
        Limits.load(tmp_path / "none.json")


def test_margin_of_a_joint_with_little_room_is_a_share_of_it() -> None:
    narrow = replace(LIMITS, lower=np.full(6, -0.1), upper=np.full(6, 0.1))
    low, high = narrow.within(narrow.soft_margin, 0.1)
    assert_allclose(low, -0.08)
    assert_allclose(high, 0.08)


def test_continuous_joint_has_no_margin() -> None:
    low, high = LIMITS.within(0.3, 0.1)
    assert np.isinf(low[[0, 3, 4, 5]]).all()
    assert np.isinf(high[[0, 3, 4, 5]]).all()


def test_hold_of_the_jaco2_is_stiff_at_the_shoulder_and_soft_at_the_wrist() -> None:
    assert_allclose(LIMITS.stiffness, [135.0] * 3 + [28.0] * 3)
    assert_allclose(LIMITS.damping, [12.0] * 3 + [3.0] * 3)


def test_packaged_file_is_as_it_would_be_written() -> None:
    assert Limits.jaco2().to_json() == JACO2_LIMITS.read_text()


@pytest.mark.parametrize(
    ("changes", "match"),
    [
        ({"lower": [1.0] * 6, "upper": [1.0] * 6}, "^limits: a lower limit is not below its upper one"),
        ({"box_low": [1.0] * 3, "box_high": [1.0] * 3}, "^limits: a lower limit is not below its upper one"),
        ({"soft_margin": 0.1, "hard_margin": 0.1}, r"^limits: hard_margin 0\.1 rad is not below soft_margin 0\.1 rad"),
        ({"speed": [1.0] * 5}, r"^limits: speed has shape \(5,\); expected \(6,\)"),
        ({"energy": 1e300}, r"limits\.json: energy = 1e\+300; expected a number"),
        ({"speed": [1.0] * 5 + ["fast"]}, r"limits\.json: speed = 'fast'; expected a number"),
        ({"pairs": [[1.0], [1.0, 2.0]]}, r"limits\.json: pairs has rows of different lengths"),
        ({"version": 1}, r"limits\.json is no limits file of version 2; expected exactly: axes, box_high, box_low, "),
    ],
)
def test_refusal_says_what_was_found(changes: dict[str, Any], match: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=match):
        Limits.load(written(tmp_path, **changes))


def test_refusal_of_a_large_file_says_how_large_it_may_be(tmp_path: Path) -> None:
    path = tmp_path / "limits.json"
    path.write_text(" " * (64 * 1024 + 1))
    with pytest.raises(InputError, match=r"limits\.json is larger than 64 KiB; expected a limits file"):
        Limits.load(path)


def test_word_that_is_no_number_in_json_is_named(tmp_path: Path) -> None:
    path = tmp_path / "limits.json"
    path.write_text(LIMITS.to_json().replace('"energy": null', '"energy": NaN'))
    with pytest.raises(InputError, match="NaN is no number"):
        Limits.load(path)
