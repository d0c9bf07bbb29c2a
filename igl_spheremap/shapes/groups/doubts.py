"""Reasons to doubt a group: members that may be registered wrongly, and means that may mix kinds of bodies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...mesh.arrays import HALF_DIGITS, FloatArray
from .member_registration import MemberRegistration


def member_doubts(
    found: MemberRegistration,
    distance: float,
    distances: FloatArray,
    correlations: FloatArray,
    alike: bool = False,
    mirrored: float = 2 / 3,
) -> tuple[str, ...]:
    """Doubts of a member in sentences, given the figures of all; `alike` if most members fit in two ways.

    If the distance of its mirror image is less than the share `mirrored` of the member's own, this is named: .4 for a
    hippocampus among those of the other side, .9 for bodies that are nearly their own mirror images.
    """
    said = []
    if found.mirrored < mirrored:
        said.append(
            f"its mirror image lies at {found.mirrored:.2f} times its distance from the mean: if it is of the "
            "other side of a body, mirror it (x to -x, and its faces reversed)"
        )
    elif found.has_rival and not alike:
        said.append(
            f"turned by {found.angle:.0f} degrees it fits the mean nearly as well: look whether its parts are "
            "where those of the others are"
        )
    if distance > 0 and _beyond(np.log(distance), np.log(distances[distances > 0])):
        said.append(
            f"it lies {distance / np.median(distances):.1f} times as far from the mean as half of the members: "
            "look at its picture, it may lie wrong or be of another kind"
        )
    known = correlations[np.isfinite(correlations)]
    if not np.isfinite(found.correlation):
        said.append(
            "its depth is the same everywhere: nothing tells which of its points belong to the mean's"
        )
    elif _beyond(_unlike(found.correlation), _unlike(known)):
        said.append(
            f"its depth correlates with the mean's by {found.correlation:.2f}, that of half of the members by "
            f"{np.median(known):.2f} or more: look at its picture"
        )
    return tuple(said)


def symmetric(registrations: Sequence[MemberRegistration]) -> bool:
    """Whether at least half of the members fit the mean nearly as well after another rotation."""
    return float(np.mean([each.has_rival for each in registrations])) >= 0.5


def _unlike(correlations: float | FloatArray) -> FloatArray:
    """Minus Fisher's transform of correlations, whose standard deviation is the same for all of them."""
    return -np.arctanh(np.clip(correlations, -1 + HALF_DIGITS, 1 - HALF_DIGITS))


def _beyond(
    value: float | FloatArray, values: FloatArray, deviations: float = 4.0, usual: float = 0.15
) -> bool:
    """Whether a value lies some standard deviations above the median of others, which counts as `usual` at least."""
    off = values - np.median(values)
    deviation = 1.4826 * np.median(np.abs(off))  # the standard deviation of a normal distribution
    return bool(value - np.median(values) > deviations * max(deviation, usual))


def copy_doubts(names: Sequence[str], contents: Sequence[bytes]) -> list[str]:
    """Sentences on members that are the same surface, whose contents are equal."""
    by_content: dict[bytes, list[str]] = {}
    for name, content in zip(names, contents, strict=True):
        by_content.setdefault(content, []).append(name)
    return [
        f"{' and '.join(sorted(same))} are the same surface, which counts {len(same)} times: leave copies out"
        for same in by_content.values()
        if len(same) > 1
    ]


def group_doubts(
    changes: Sequence[float],
    settled: bool,
    axis: FloatArray | None,
    registrations: Sequence[MemberRegistration],
    scores: FloatArray,
    moved: float = 0.03,
) -> Iterator[str]:
    """Doubts of the mean in sentences; unless it has not settled, its last move does not count."""
    if changes[-1] > moved and not settled:
        yield (
            f"the mean still moved by {100 * changes[-1]:.2g} percent of its radius in round {len(changes)}, the "
            "last: points still slide; look at the farthest members, or take a finer icosphere"
        )
    if axis is not None:
        x, y, z = axis / np.linalg.norm(axis)
        yield (
            f"turned about the axis ({x:.2f}, {y:.2f}, {z:.2f}) by any angle, the mean moves less than half of the "
            "members differ from it: the bodies are round; each is turned to the least distance from "
            "the mean, and modes along such turns are chance"
        )
    elif symmetric(registrations):
        angle = np.median([each.angle for each in registrations if each.has_rival])
        yield (
            f"most members fit the mean nearly as well when they are turned, by {angle:.0f} degrees for instance: "
            "the bodies are symmetric, and modes along such turns are chance"
        )
    if (sizes := two_kinds(scores[:, 0])) is not None:
        yield (
            f"the first mode parts the members into {sizes[0]} and {sizes[1]} with nothing between: they may be two "
            "kinds, each with a mean of its own"
        )


def drift_doubts(found: MemberRegistration, axis: FloatArray | None) -> Iterator[str]:
    """A doubt of a series' drift in a sentence, by the registration of its last frame to the first one."""
    if axis is not None or found.has_rival:
        turn = f"by {found.angle:.0f} degrees"
        if axis is not None:
            turn = "about its axis"
        yield (
            f"the last frame fits the first one nearly as well when it is turned {turn}: shape does not tell how "
            "points moved along the surface, and drift counts that turn, too"
        )


def two_kinds(scores: FloatArray, share: float = 0.98, fewest: int = 3) -> tuple[int, int] | None:
    """If that share of the scores' variance lies between two values, their numbers on either side; else None.

    >>> two_kinds(np.array([-1.0, -1.1, -0.9, 1.0, 1.1, 0.9])), two_kinds(np.arange(6.0))
    ((3, 3), None)
    """
    ordered = np.sort(scores - scores.mean())
    total = (ordered**2).sum()
    for k in range(fewest, len(ordered) - fewest + 1):
        low, high = ordered[:k], ordered[k:]
        if (k * low.mean() ** 2 + len(high) * high.mean() ** 2) > share * total:
            return k, len(high)
    return None
