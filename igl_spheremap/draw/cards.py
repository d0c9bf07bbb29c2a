"""Cards of many results, which a page draws on view: sorted, filtered, rated; and distributions."""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from html import escape
from importlib.resources import files
from typing import Any

import numpy as np

from ..mesh.arrays import FloatArray
from .markup import legend
from .palette import Colour, Ramp


@dataclass(frozen=True, slots=True)
class Card:
    """A result on a page.

    Attributes
    ----------
    key : str
        Its address on the page.
    row : mapping
        Its figures by name, `source`, by which it is rated, and `status` among them. Non-finite ones are null on the
        page.
    name, text : str
        The texts on the card.
    caption : str
        Caption of the picture.
    words : sequence of str
        The command by which a person looks closer, without the program's name.
    picture : str
        The picture's address; empty if there is none.
    reasons : sequence of str
        Why it stands out.
    good : bool
        Whether it is a success.
    """

    key: str
    row: Mapping[str, Any]
    name: str
    text: str
    caption: str
    words: Sequence[str]
    picture: str = ""
    reasons: Sequence[str] = ()
    good: bool = True


def card_section(
    cards: Sequence[Card],
    nouns: str,
    said: str,
    plots: Iterable[str],
    figures: Mapping[str, str],
    legends: Iterable[Ramp | tuple[str, Colour]],
) -> str:
    """A section of cards: a heading, histograms of their figures, remarks, and the cards.

    Below ten, histograms would only push the cards down.
    """
    shown = ""
    if len(cards) >= 10:
        shown = f'<div class="plots">{"".join(plots)}</div>\n'
    return (
        f"<h2>{nouns.capitalize()}</h2>\n{shown}<p>{said}</p>\n"
        f"{card_sheet(cards, figures, legends)}"
    )


def card_sheet(
    cards: Sequence[Card],
    figures: Mapping[str, str],
    legends: Iterable[Ramp | tuple[str, Colour]],
    badges: int = 3,
) -> str:
    """Cards in their order, with controls that sort by the labelled figures, filter and export.

    A card has at most `badges` badges, each a reason; its page has all.
    """
    entries = []
    for rank, card in enumerate(cards):
        row = dict(card.row)
        for name, value in row.items():
            if isinstance(value, float) and not math.isfinite(value):
                row[name] = None
        reasons = list(card.reasons[:badges])
        if len(card.reasons) > badges:
            reasons.append(f"and {len(card.reasons) - badges} more")
        entry = asdict(card) | {"rank": rank, "row": row, "badges": reasons}
        entry["command"] = shlex.join(("igl-spheremap", *entry.pop("words")))
        entries.append(entry)
    sorts = "".join(
        f'<option value="{key}">{escape(label)}</option>'
        for key, label in {"rank": "worst first", "source": "name", **figures}.items()
    )
    shown = [
        "all",
        *sorted({card.row["status"] for card in cards}),
        "outliers",
        "passed",
        "failed by you",
        "not rated",
    ]
    statuses = "".join(f"<option>{escape(one)}</option>" for one in shown)
    code = files(__package__).joinpath("cards.js").read_text(encoding="utf-8")
    known = {"cards": entries, "labels": figures}
    data = json.dumps(known).replace("<", "\\u003c")  # no text ends the element that holds it
    return (
        f'<div class="legends">{"".join(map(legend, legends))}</div>'
        f'<form class="toolbar"><label>sort by <select name="sort">{sorts}</select></label> '
        f'<label>show <select name="status">{statuses}</select></label> '
        '<label>name has <input name="text" type="search"></label> '
        '<button type="button" name="bars" hidden></button> '
        '<button type="button" name="export">Save ratings as TSV</button> '
        '<label>load ratings <input name="load" type="file" accept=".tsv"></label> <output></output></form>'
        '<div class="sheet"></div><dialog></dialog>'
        f'<script type="application/json" class="cards">{data}</script><script>{code}</script>'
    )


def histogram(
    name: str,
    label: str,
    values: FloatArray,
    nouns: str,
    limit: float = math.inf,
    axis: str = "",
    bins: int = 30,
) -> str:
    """Bars of cards by a figure, those above the limit in a bar of their own; if all are equal, a sentence.

    Each is a button that filters the cards. Without finite values it is empty.
    """
    values = values[np.isfinite(values)]
    if not len(values):
        return ""
    if np.ptp(values) == 0:
        same = ""
        if len(values) > 1:
            same = f", the same for all {len(values):,} {nouns}"
        return f"<figure><figcaption>{label}: {values[0]:.3g}{same}</figcaption></figure>"
    ends = float(values.min()), min(limit, float(values.max()))
    if ends[0] == ends[1]:
        ends = ends[0] - 0.5, ends[1] + 0.5
    counts, edges = np.histogram(values, bins=bins, range=ends)
    edges[-1] = np.nextafter(edges[-1], math.inf)  # the last bar has its upper end
    bars = [
        *zip(counts.tolist(), edges[:-1].tolist(), edges[1:].tolist(), strict=True),
        (int((values > limit).sum()), limit, math.inf),
    ]
    most, drawn = max(count for count, _, _ in bars), []
    for count, low, high in bars:
        kind, end, said = "bar", repr(high), f"{count} from {low:.3g} to {high:.3g}"
        if high == math.inf:
            kind, end, said = "bar outliers", "", f"{count} above {low:.3g}"
        disabled = ""
        if not count:
            disabled = " disabled"
        drawn.append(
            f'<button type="button" class="{kind}" data-figure="{name}" data-low="{low!r}" data-high="{end}" '
            f'data-said="{label} {said}" title="{said}" style="--share: {count / most:.1%}"{disabled}></button>'
        )
    caption = f"{label}: median {np.median(values):.3g}, largest {values.max():.3g}"
    counted = f"{most} {nouns}"
    if most == 1:
        counted = f"1 {nouns.removesuffix('s')}"
    return (
        f'<figure class="histogram"><small>{escape(counted)}</small><div class="bars">{"".join(drawn)}</div>'
        f"<small><span>{edges[0]:.3g}</span><span>{escape(axis)}</span><span>{edges[-1]:.3g}</span></small>"
        f"<figcaption>{caption}</figcaption></figure>"
    )
