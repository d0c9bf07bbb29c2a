"""The numbers of the paper's Tables 1 to 3."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class PaperRow:
    """One row of a table of Lai et al.; None where the text has no number.

    In Table 3, `iterations` are those of each step of Algorithm 2. "Their" algorithm is that of [1], Gu and Yau.
    """

    surface: str
    vertices: int
    iterations: tuple[int, ...]
    seconds: float | None
    their_iterations: int | None = None
    their_seconds: float | None = None

    @property
    def ratio(self) -> float | None:
        """Seconds of the algorithm in [1] over those of the proposed one."""
        if self.seconds is None or self.their_seconds is None:
            return None
        return self.their_seconds / self.seconds


TABLE_1 = (
    PaperRow("Putamen", 10_000, (1414,), 4.80),
    PaperRow("Brain", 15_002, (1329,), 9.36),
    PaperRow("Maxplanck", 12_556, (892,), 5.19),
)

TABLE_2 = (
    PaperRow("Hippocampus 1", 2_000, (210,), 0.19, 790, 16.91),
    PaperRow("Hippocampus 2", 2_562, (4225,), 5.83, 1594, 108.36),
    PaperRow("Putamen", 10_002, (1414,), 4.80, 2684, 760.33),
    PaperRow("Gray matter", 10_000, (1598,), 5.79, 2794, 822.90),
    PaperRow("Brain", 15_002, (1329,), 9.36, 1560, 664.97),
    PaperRow("Maxplanck", 12_556, (892,), 5.19, 1990, 704.01),
    PaperRow("Bimba", 15_002, (1432,), 17.40, 3197, 1358.72),
)

TABLE_3 = (
    PaperRow("Dino", 5_524, (4480, 1518, 3652), None),
    PaperRow("Dilo", 9_731, (3610, 5000, 4184), 73.94, 3106, 513.56),
    PaperRow("Bird 1", 950, (1054, 4444, 1038), 2.64, 716, 19.29),
    PaperRow("Bird 2", 926, (592, 1674, 5000), 14.44, 599, 14.09),
    PaperRow("Armadillo", 16_519, (4164, 294, 496), 70.68, 3355, 1648.30),
)
