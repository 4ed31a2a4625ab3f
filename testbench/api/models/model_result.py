"""What the results of `fit`, `diagnose` and `propose` have in common: each holds a model."""

from __future__ import annotations

from pathlib import Path

from testbench.api.arguments import WithModel
from testbench.api.models.ladder import Ladder
from testbench.knit.model import KnitModel


class ModelResult:
    """A result with a model in its ``file``."""

    @property
    def model(self: WithModel) -> KnitModel:
        """The model, refitted; ``result.model + effect`` is another one, with an effect put in."""
        return self.file.model

    @property
    def ladder(self: WithModel) -> Ladder:
        """The errors of this model, and of those that it was made from."""
        return Ladder(self.file)

    def save(self: WithModel, path: str | Path) -> None:
        """Write the model as ``model.json``."""
        self.file.save(path)
