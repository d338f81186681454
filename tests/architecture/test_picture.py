"""The picture of the layers is drawn from the code."""

from docs.draw_layers import PICTURE, direct_arrows, draw
from tests.support.source import arrows


def test_the_picture_of_the_layers_is_current() -> None:
    assert PICTURE.read_text(encoding="utf-8") == draw(), "python -m docs.draw_layers"


def test_the_arrows_drawn_imply_every_import() -> None:
    drawn, imported = direct_arrows(), arrows()

    def reached(name: str) -> set[str]:
        return set(drawn[name]).union(*(reached(target) for target in drawn[name]))

    for name in drawn:
        assert set(drawn[name]) <= imported[name] <= reached(name)
