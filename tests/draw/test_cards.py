"""Cards of pages: whatever a figure or a name is, the page can read it."""

from __future__ import annotations

import json
import math

import numpy as np

from igl_spheremap.draw.cards import Card, card_section, card_sheet, histogram


def test_what_is_not_finite_is_null_and_no_name_ends_the_script():
    row = {"source": "</script>\udc80", "status": "member", "size": math.nan}
    html = card_sheet(
        [Card("a", row, "</script>", "", "", (), reasons="abcde")], {"size": "size"}, []
    )
    data = html.partition('class="cards">')[2].partition("</script>")[0]
    (card,) = json.loads(data, parse_constant=lambda word: 1 / 0)["cards"]
    assert card["row"] == row | {"size": None}
    assert card["name"] == "</script>"
    assert card["badges"] == ["a", "b", "c", "and 2 more"]


def test_histograms_stand_above_ten_cards_and_more():
    for count in (9, 10):
        cards = [Card(str(k), {"source": "", "status": ""}, "", "", "", ()) for k in range(count)]
        assert ("<b>bars</b>" in card_section(cards, "maps", "", ["<b>bars</b>"], {}, [])) == (
            count == 10
        )


def test_bars_hold_what_is_finite():
    assert histogram("size", "size", np.array([np.nan, np.inf]), "members", 1.0) == ""
    assert "size: 2<" in histogram("size", "size", np.array([np.nan, 2.0]), "members", 3.0)
    assert "2, the same for all 3 members" in histogram(
        "size", "size", np.full(3, 2.0), "members", 3.0
    )
    assert "<small>1 member<" in histogram("size", "size", np.arange(4.0), "members", 9.0)
