"""Without the daemon its tests are skipped with a word; where every change is checked they fail."""

from __future__ import annotations

import shutil

import pytest
from _pytest.outcomes import Failed, Skipped
from teleop.magellan import executable


@pytest.mark.parametrize(("variable", "outcome"), [("", Skipped), ("1", Failed)])
def test_a_missing_daemon_skips_here_and_fails_there(
    monkeypatch: pytest.MonkeyPatch, variable: str, outcome: type[BaseException]
) -> None:
    monkeypatch.setattr(shutil, "which", lambda *_, **__: None)
    monkeypatch.setenv("CI", variable)
    with pytest.raises(outcome, match="apt install spacenavd"):
        executable()
