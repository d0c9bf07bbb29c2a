"""A run as a sequence of slides, its stops, and which slides are kept when they take too much memory."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...descent.iterate import Iterate, Step
from ...mesh.arrays import FloatArray, IntArray
from ...verify.signs import folded_faces

#: The start of the paper's algorithms; shown first in every run, for comparison.
GAUSS_MAP = Step("gauss map", 0, 0, float("nan"), float("nan"), 0.0)
_NAMES = {"harmonic": "Algorithm 1", "sobolev": "preconditioned Cayley steps", "tutte": "Tutte energy"}


@dataclass(frozen=True, eq=False)
class Slide:
    """A map of a run: its place among all iterates, its numbers, positions and folded faces, eight to a byte."""

    index: int
    step: Step
    title: str
    x: FloatArray
    foldings: int
    packed: NDArray[np.uint8]

    @classmethod
    def of(cls, index: int, step: Step, x: FloatArray, f: IntArray, title: str = "") -> Slide:
        folded = folded_faces(x, f)
        return cls(index, step, title or title_of(step), x, int(folded.sum()), np.packbits(folded))

    @property
    def folded(self) -> IntArray:
        """Indices of the faces that are flipped or degenerate."""
        return np.flatnonzero(np.unpackbits(self.packed))

    def facts(self) -> dict[str, str | int]:
        """What a picture of it shows, for JSON."""
        return {
            "title": self.title,
            "stage": self.step.stage,
            "round": self.step.round,
            "iteration": self.step.iteration,
            "foldings": self.foldings,
        }


def stops(slides: Sequence[Slide]) -> list[tuple[str, int]]:
    """Names and indices of the start, of the slides at star maps and repairs, and of the end."""
    marks = [(slides[0].title, 0)]
    for k, slide in enumerate(slides[:-1]):
        again = f" {slide.step.round}" if slide.step.round > 1 else ""
        if slide.step.stage == "star map":
            marks += [(f"before the star map{again}", k - 1), (f"after the star map{again}", k)]
        elif slide.step.stage == "repair":
            marks.append((f"repair{again}", k))
    return [*marks, ("end", len(slides) - 1)]


def thin(slides: Sequence[Slide], room: int) -> list[Slide]:
    """The first and last slide of each stage, and about `room` others: most where the foldings change most."""
    stages = [stage_of(slide.step) for slide in slides]
    neighbours = zip([None, *stages], stages, [*stages[1:], None], strict=False)
    ends = [k for k, (before, own, after) in enumerate(neighbours) if not before == own == after]
    foldings = np.log1p([slide.foldings for slide in slides])
    change = np.abs(np.diff(foldings, prepend=foldings[:1]))
    # half of the room for even coverage, half for changes
    place = np.cumsum(change / max(change.sum(), 1e-300) + 1 / len(slides))
    chosen = np.searchsorted(place, np.linspace(0, place[-1], room)).clip(0, len(slides) - 1)
    return [slides[k] for k in np.union1d(chosen, ends)]


def stage_of(step: Step | Iterate) -> tuple[str, int]:
    """What stays the same until a stage ends."""
    return step.stage, step.round


def title_of(step: Step | Iterate) -> str:
    """What an iterate is, in words.

    >>> title_of(GAUSS_MAP), title_of(Step("harmonic", 1, 20, 12.6, 0.1, 0.5))
    ('Gauss map', 'Algorithm 1, round 1, iteration 20')
    """
    name = _NAMES.get(step.stage, step.stage)
    name = name[0].upper() + name[1:]
    if step.stage == "repair" and not step.round:
        return "Harmonic map"
    if step.stage in ("star map", "repair"):
        return f"{name} {step.round}"
    if step.stage == "gauss map":
        return name
    where = f", round {step.round}" if step.round else ""
    return f"{name}{where}, iteration {step.iteration}"
