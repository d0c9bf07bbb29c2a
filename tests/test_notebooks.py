"""The notebooks of docs/notebooks run, and print their own texts, but for the digits."""

import json
import re

import pytest
from corpus import ROOT

NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))


def words(text):
    return re.sub(r"[-\d.,e+ ]+", " ", text).split()


def test_there_are_notebooks():
    assert len(NOTEBOOKS) == 3


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_prints_what_it_shows(path, capsys):
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("agg")
    names, pictures = {}, 0
    for cell in json.loads(path.read_text("utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
            outputs = cell["outputs"]
            printed = "".join(
                "".join(each["text"]) for each in outputs if each["output_type"] == "stream"
            )
            assert words(capsys.readouterr().out) == words(printed)
            pictures += sum("image/png" in each.get("data", {}) for each in outputs)
    pyplot.close("all")
    assert pictures
