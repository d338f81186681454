"""The gallery has every built-in scenario: its sentence, its command and a small picture."""

import struct

import pytest

from docs.draw_gallery import PAGE, PICTURES, page, picture
from tests.support.paths import CONFIGS
from world.config import builtin

LARGEST, TOTAL = 150_000, 1_500_000
"""Bounds on the size of a picture, and of all pictures together [bytes]."""


def test_the_page_of_the_gallery_is_current() -> None:
    assert PAGE.read_text(encoding="utf-8") == page(), "python -m docs.draw_gallery"


@pytest.mark.parametrize("name", builtin.names())
def test_a_scenario_has_a_picture_and_its_command_in_the_gallery(name: str) -> None:
    assert f"`fes run {name}`" in PAGE.read_text(encoding="utf-8")
    content = picture(name).read_bytes()
    assert content.startswith(b"\x89PNG")
    width, _ = struct.unpack(">II", content[16:24])
    assert width == 800
    assert len(content) < LARGEST


def test_the_gallery_has_no_other_picture_and_is_small() -> None:
    names = [path.relative_to(CONFIGS).with_suffix("").as_posix() for path in CONFIGS.rglob("*.toml")]
    assert sorted(names) == sorted(builtin.names())
    assert sorted(PICTURES.iterdir()) == sorted(map(picture, names))
    assert sum(path.stat().st_size for path in PICTURES.iterdir()) < TOTAL
