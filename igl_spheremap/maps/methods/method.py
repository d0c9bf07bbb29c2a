"""What the methods of `spherical_conformal_map` have in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import Any, ClassVar

from ...descent.iterate import Listener
from ...mesh.check import Mesh
from ...untangle.candidate import Candidate


@dataclass(frozen=True)
class Method(ABC):
    """A frozen record of a method's options, which runs the method."""

    #: What users call it.
    name: ClassVar[str]

    @abstractmethod
    def run(self, mesh: Mesh, listener: Listener | None = None) -> Candidate:
        """Map a mesh."""

    def settings(self) -> dict[str, Any]:
        """The options that are not at their defaults."""
        values = {option.name: (getattr(self, option.name), option.default) for option in fields(self)}
        return {name: value for name, (value, default) in values.items() if value != default}
