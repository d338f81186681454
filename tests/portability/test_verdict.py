"""Outputs of two settings: equal ones, and each way to differ."""

from pathlib import Path

from tests.portability.verdict import Output

ABOUT = "# machine: x\n# numpy: 2\n# features: AVX2 FMA3\n# loops: 1\n# libm: 2\n# blas: 3\n"
PAPER = "paper 0a messages=0b reports=0c summary=0d\n"
PAIR = "pair 1a messages=1b reports=1c summary=1d\n"


def output(tmp_path: Path, text: str) -> Output:
    path = tmp_path / "output.txt"
    path.write_text(text)
    return Output.read(path)


def test_every_case_and_part_that_differs_is_named(tmp_path: Path) -> None:
    base = output(tmp_path, ABOUT + PAPER + PAIR)
    assert output(tmp_path, ABOUT + PAIR + PAPER).differences(base) == []
    assert output(tmp_path, ABOUT + PAPER).differences(base) == []  # fewer cases, for an emulated processor
    changed = PAPER.replace("0a", "9a").replace("0d", "9d")
    assert output(tmp_path, ABOUT + changed + PAIR).differences(base) == ["paper (digest, summary)"]
    assert output(tmp_path, ABOUT + "pear" + PAIR[4:]).differences(base) == ["pear (not in the first setting)"]
    assert output(tmp_path, ABOUT).differences(base) == ["no case at all"]


def test_a_case_without_its_golden_digest_is_named(tmp_path: Path) -> None:
    base = output(tmp_path, ABOUT + PAPER + PAIR)
    assert base.unlike({"paper": "0a", "pair": "1a"}) == []
    assert base.unlike({"paper": "9a", "pair": "1a", "hundred": "2a"}) == ["hundred", "paper"]


def test_the_effect_of_a_setting_is_what_it_takes_away_and_the_controls_that_it_changes(tmp_path: Path) -> None:
    base = output(tmp_path, ABOUT)
    assert base.effect(base) == "changes no bits of the controls"
    other = output(tmp_path, ABOUT.replace("AVX2 ", "").replace("loops: 1", "loops: 9"))
    assert other.effect(base) == "takes away AVX2, changes the bits of loops"
    older = output(tmp_path, ABOUT.replace("numpy: 2", "numpy: 1").replace("AVX2 ", "").replace("blas: 3", "blas: 9"))
    assert older.effect(base) == "changes the bits of blas"
