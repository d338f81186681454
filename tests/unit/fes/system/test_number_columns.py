"""Columns of numbers: what a file may look like, and one line for each that is broken."""

import pytest

from fes.errors import FesError
from fes.system import number_columns
from fes.system.number_columns import Column

WANTED = (
    (Column("separation", 0, 1000),),
    (Column("rssi", -200, 50), Column("decoded", 0, 1, is_whole=True)),
)

NAMES = ", line 1: must name the columns separation, rssi or decoded, got "


def columns(text: str) -> dict[str, list[float]]:
    read = number_columns.read("links.csv", text.encode(), WANTED)
    return {name: values.tolist() for name, values in read.items()}


@pytest.mark.parametrize(
    "text",
    [
        "separation,decoded\n10,1\n20.5,0\n",
        "\ufeffseparation,decoded\r\n10,1\r\n\r\n20.5,0",  # as a spreadsheet writes it
        " decoded , note, separation\n1, near, 1e1\n0, far, 20.5\n",
        'separation,decoded\n"10","True"\n20.5,false\n',  # as pandas writes booleans
        "separation,decoded\n10,1.0\n , \n20.5,0.0\n",
    ],
)
def test_a_file_has_its_columns_in_any_order_beside_others(text: str) -> None:
    assert columns(text) == {"separation": [10.0, 20.5], "decoded": [1.0, 0.0]}


def test_of_two_alternatives_the_first_that_the_file_has_counts() -> None:
    assert columns("decoded,rssi,separation\n1,-60,10\n") == {"separation": [10.0], "rssi": [-60.0]}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", f"{NAMES}''"),
        ("separation,lost\n1,0\n", f"{NAMES}'separation,lost'"),
        ("separation;decoded\n1;0\n", f"{NAMES}'separation;decoded'"),
        ("separation,decoded,decoded\n1,0,1\n", ", line 1: names the column decoded twice"),
        ("separation,decoded\n", " has no row after its line of names"),
        ("separation,decoded\n\n , \n", " has no row after its line of names"),
        ("separation,decoded\n10,1\n\n12,5,1\n", ", line 4: must have 2 fields, got 3: '12,5,1'"),  # a decimal comma
        ("separation,decoded\n10,1\n12\n", ", line 3: must have 2 fields, got 1: '12'"),
        ("separation,decoded\n10,1\nfar,0\n", ", line 3: separation must be a number from 0 to 1000, got 'far'"),
        ("separation,decoded\n10,\n", ", line 2: decoded must be 0 or 1, got ''"),
        ("separation,decoded\n10,1\n20,0.5\n", ", line 3: decoded must be 0 or 1, got 0.5"),
        ("separation,decoded\n10,1\n20,2\n", ", line 3: decoded must be 0 or 1, got 2"),
        ("separation,decoded\n-1,1\n", ", line 2: separation must be a number from 0 to 1000, got -1"),
        ("separation,decoded\nnan,1\n", ", line 2: separation must be a number from 0 to 1000, got nan"),
        ("separation,rssi\n10,-inf\n", ", line 2: rssi must be a number from -200 to 50, got -inf"),
        (f"separation,decoded\n10,{'9' * 200_000}\n", ", line 2: field larger than field limit (131072)"),
        (f"separation,decoded\n10,{'x' * 1000}\n", f", line 2: decoded must be 0 or 1, got '{'x' * 40}'"),
    ],
)  # fmt: skip
def test_a_broken_file_is_one_line_that_names_file_line_rule_and_value(text: str, message: str) -> None:
    with pytest.raises(FesError) as caught:
        columns(text)
    assert str(caught.value).startswith(f"links.csv{message}")
    assert "\n" not in str(caught.value)


def test_bytes_that_are_not_text_are_one_line() -> None:
    with pytest.raises(FesError, match=r"^links\.csv is not text in UTF-8$"):
        number_columns.read("links.csv", b"\xff\xfe\x00", WANTED)
