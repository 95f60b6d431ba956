"""Which experiments there are: every module of this package that has an ``EXPERIMENT``."""

from __future__ import annotations

import pkgutil
from importlib import import_module

import burnish.experiments
from burnish.trials.experiment import Experiment


def experiments() -> dict[str, Experiment]:
    """Name of the module to its experiment, sorted by name."""
    names = sorted(module.name for module in pkgutil.iter_modules(burnish.experiments.__path__))
    modules = {name: import_module(f"burnish.experiments.{name}") for name in names}
    return {name: module.EXPERIMENT for name, module in modules.items() if hasattr(module, "EXPERIMENT")}


def experiment(name: str) -> Experiment:
    """The experiment of that name, which has to exist."""
    found = import_module(f"burnish.experiments.{name}").EXPERIMENT
    assert isinstance(found, Experiment)
    return found
