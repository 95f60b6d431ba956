"""A campaign's file: what is done is kept, a line that was cut off is not, and another campaign is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from burnish.campaign.judge import Verdict
from burnish.campaign.parallel import run_all
from burnish.campaign.results import Result, Settings, Store
from burnish.campaign.summary import summary, worst, wrong
from burnish.errors import InputError

SETTINGS = Settings(seed=4, nominal=False, limits="l", judge="j", source="s", versions={"burnish": "0"})
GOOD = Verdict(
    not_finite=0,
    over_cap=0,
    over_rate=0,
    not_held=0,
    stopped_at=None,
    reaction=None,
    late=False,
    peak_speed=0.5,
    still_after=None,
    moving=False,
    slow_stop=False,
    drift=None,
    watched=None,
    peak_force=3.0,
    energy_stop=None,
    energy_end=None,
)


def result(episode: int, fault: str = "none", rate: float = 100.0, **verdict: object) -> Result:
    return Result(
        episode=episode,
        task="hold",
        fault=fault,
        text=fault,
        rate=rate,
        seconds=1.8,
        urgency=None,
        mode="torque",
        cause=None,
        trouble=None,
        verdict=replace(GOOD, **verdict),
    )


def test_results_come_back_as_they_were_kept(tmp_path: Path) -> None:
    kept = [result(0), result(7, "runaway", peak_speed=0.123456789012345)]
    Store(tmp_path, SETTINGS).add(kept)
    assert list(Store(tmp_path, SETTINGS).results.values()) == kept


def test_what_an_interrupted_call_had_written_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = Store(tmp_path, SETTINGS)

    def interrupted(file: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("burnish.campaign.results.os.fsync", interrupted)
    with pytest.raises(KeyboardInterrupt):
        store.add([result(0), result(1)])
    store.read()
    assert list(store.results) == [0, 1]


def test_line_that_was_cut_off_is_done_again(tmp_path: Path) -> None:
    Store(tmp_path, SETTINGS).add([result(0), result(1)])
    path = tmp_path / "episodes.jsonl"
    path.write_bytes(path.read_bytes()[:-20])
    store = Store(tmp_path, SETTINGS)
    assert set(store.results) == {0}
    store.add([result(1)])
    assert set(Store(tmp_path, SETTINGS).results) == {0, 1}


@pytest.mark.parametrize("other", [{"seed": 5}, {"nominal": True}, {"limits": "x"}, {"judge": "x"}, {"source": "x"}])
def test_folder_of_another_campaign_is_refused_and_stays_as_it_is(tmp_path: Path, other: dict[str, object]) -> None:
    Store(tmp_path, SETTINGS).add([result(0)])
    with pytest.raises(InputError, match=next(iter(other))):
        Store(tmp_path, replace(SETTINGS, **other))
    assert set(Store(tmp_path, SETTINGS).results) == {0}


def test_damaged_line_is_refused_with_its_number(tmp_path: Path) -> None:
    Store(tmp_path, SETTINGS).add([result(0), result(1)])
    path = tmp_path / "episodes.jsonl"
    first, second = path.read_text().splitlines()
    path.write_text(f"{first}\n{second[:50]}\n")
    with pytest.raises(InputError, match="line 2"):
        Store(tmp_path, SETTINGS)


def test_summary_counts_an_episode_with_two_faults_for_both() -> None:
    found = summary([result(0), result(1, "hang + runaway", over_rate=2), result(2, "runaway")], SETTINGS)
    assert (found["episodes"], found["unsafe_samples"], found["pairs"]) == (3, 2, 1)
    assert {name: row["episodes"] for name, row in found["by_fault"].items()} == {"hang": 1, "none": 1, "runaway": 2}
    assert found["by_fault"]["runaway"]["unsafe_samples"] == 2
    assert found["virtual_hours"] == pytest.approx(3 * 1.8 / 3600.0)
    assert found["faultless_hours"] == pytest.approx(1.8 / 3600.0, rel=0.01, abs=1e-4)


def test_stop_without_a_fault_is_a_false_trip_and_with_one_it_is_none() -> None:
    stopped = [result(0, stopped_at=0.4), result(1, "hang", stopped_at=0.4), result(2)]
    assert summary(stopped, SETTINGS)["false_trips"] == 1


def test_runaway_joints_are_told_apart_by_their_rate() -> None:
    some = [
        result(k, "runaway", rate, peak_speed=speed) for k, (rate, speed) in enumerate([(100.0, 0.6), (1000.0, 1.2)])
    ]
    peaks = summary(some, SETTINGS)["runaway_peak_speed"]
    assert (peaks["100 Hz"]["max"], peaks["1000 Hz"]["max"]) == (0.6, 1.2)


def test_worst_episode_is_the_one_with_unsafe_samples() -> None:
    some = [result(0, peak_speed=3.0), result(1, not_held=1), result(2, late=True), result(3)]
    assert [each.episode for each in worst(some)] == [1, 2, 0, 3]
    assert wrong(some[0]) == "joint at 3.00 × its speed limit"
    assert wrong(some[3]) == ""


def test_summary_of_nothing_is_a_summary() -> None:
    assert summary([], SETTINGS)["episodes"] == 0


def test_results_are_the_same_in_one_process_and_in_two() -> None:
    alone = [each for batch in run_all(6, [0, 1], nominal=False, jobs=1) for each in batch]
    beside = [each for batch in run_all(6, [1], nominal=False, jobs=2) for each in batch]
    assert [each for each in alone if each.episode == 1] == beside


@pytest.mark.slow
def test_a_thousand_episodes_have_no_unsafe_torque_sample_and_no_false_trip() -> None:
    results = [each for batch in run_all(0, range(1000), nominal=False, jobs=2) for each in batch]
    assert len(results) == 1000
    assert [f"{each.episode}: {wrong(each)}" for each in results if each.verdict.unsafe or each.false_trip] == []
    runaway = [each.verdict.peak_speed for each in results if each.kinds == ["runaway"]]
    assert max(runaway) <= 1.0
