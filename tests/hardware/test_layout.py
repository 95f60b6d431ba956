"""The structs of the binding: as large, and with their fields where, as in the vendor's library.

The numbers of layouts.json are facts about the vendor's binaries: sizes for seven actuators from their debug
information, the others by natural alignment. The compiler says the same of the stand-in's structs, which are written
in C.
"""

from __future__ import annotations

import ctypes
import json
from pathlib import Path
from typing import Any

import pytest
from hardware.memory import Memory

from burnish.hardware import kinova_types
from burnish.hardware.kinova_types import Layout

LAYOUTS = json.loads((Path(__file__).parent / "layouts.json").read_text())
ABIS = [(7, "seven"), (6, "six")]


def struct(layout: Layout, name: str) -> Any:
    return getattr(layout, name, None) or getattr(kinova_types, name.replace("FIFO", "Fifo"))


@pytest.mark.parametrize(("actuators", "name"), ABIS)
def test_structs_of_the_binding_are_laid_out_like_the_vendors(actuators: int, name: str) -> None:
    layout, known = Layout.of(actuators), LAYOUTS[name]
    assert {key: ctypes.sizeof(struct(layout, key)) for key in known["sizes"]} == known["sizes"]
    offsets = {key: getattr(struct(layout, key.split(".")[0]), key.split(".")[1]).offset for key in known["offsets"]}
    assert offsets == known["offsets"]


@pytest.mark.parametrize(("actuators", "name"), ABIS)
@pytest.mark.parametrize("ethernet", [False, True])
def test_the_compiler_lays_out_the_stand_in_like_the_vendors(
    libraries: dict[tuple[int, bool], Path], actuators: int, name: str, ethernet: bool
) -> None:
    answer = (ctypes.c_int * 64)()
    count = ctypes.CDLL(str(libraries[actuators, ethernet])).standin_layout(answer)
    known = LAYOUTS[name]
    assert list(answer[: count - 1]) == [*known["sizes"].values(), *known["offsets"].values()]
    # And the memory between library, arm and tests is the same in both languages.
    assert answer[count - 1] == ctypes.sizeof(Memory)
