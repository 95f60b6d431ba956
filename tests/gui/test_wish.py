from pathlib import Path

import pytest

from burnish.cli import Parser
from burnish.commands.options import add_polish
from burnish.errors import InputError
from burnish.gui.wish import ARMS, FEED_MM_S, OWN, PLAIN, SENSORS, SHOWN, Edits, Wish
from burnish.paths.patterns import Spiral
from burnish.polish.recipe import Pass, Recipe


def test_the_page_asks_for_what_a_bare_polish_does() -> None:
    assert Wish().recipe == Recipe()
    assert Wish().pattern == PLAIN


@pytest.mark.parametrize("shown", list(SHOWN))
def test_a_pattern_comes_back_as_it_was_chosen(shown: str) -> None:
    assert Wish().with_pattern(shown).pattern == shown


def test_a_recipe_of_several_passes_is_left_alone() -> None:
    wish = Wish(recipe=Recipe(passes=(Pass(pattern=Spiral(), force=5.0), Pass(pattern=Spiral()))))
    assert wish.pattern == OWN
    assert wish.with_pattern(OWN) == wish


@pytest.mark.parametrize("feed", FEED_MM_S)
def test_both_ends_of_the_range_of_feeds_can_be_asked_for(feed: float) -> None:
    assert Wish().with_feed(feed).recipe.feed == pytest.approx(1e-3 * feed)


def test_what_is_out_of_range_is_refused_with_the_range() -> None:
    with pytest.raises(InputError, match="2 to 20 N"):
        Wish().with_force(25.0)
    with pytest.raises(InputError, match="expected 1 to"):
        Wish().with_passes(0)
    with pytest.raises(InputError, match="no pattern"):
        Wish().with_pattern("zigzag")


def test_edits_are_undone_one_by_one_and_done_again() -> None:
    edits = Edits()
    first = edits.now
    assert edits.change(first.with_force(12.0))
    assert not edits.change(first.with_force(12.0))
    assert edits.change(edits.now.with_feed(30.0))
    assert edits.undo()
    assert edits.now == first.with_force(12.0)
    assert edits.undo()
    assert edits.now == first
    assert not edits.undo()
    assert edits.redo()
    assert edits.now == first.with_force(12.0)
    edits.change(edits.now.with_force(3.0))
    assert not edits.redo()


@pytest.mark.parametrize("arm", ARMS.values())
@pytest.mark.parametrize("sensor", SENSORS.values())
def test_the_words_are_what_the_command_line_takes(arm: str, sensor: str) -> None:
    line = Wish(arm=arm, sensor=sensor, seed=3, passes=2, pace=4.0).words("dome", "auto", Path("r.toml"), Path("out"))
    parser = Parser()
    add_polish(parser)
    options = parser.parse_args(line[1:])
    assert (options.arm, options.sensor, options.seed, options.passes) == (arm, sensor, 3, 2)
    assert options.pace == 4.0
    assert (options.mould, options.unit, options.recipe, options.out) == ("dome", "auto", "r.toml", "out")
