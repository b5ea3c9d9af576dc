"""Answers that are kept while a model does not change."""

from dineros.metamodel.times.once import once, unchanged


def test_answers_are_kept_only_while_nothing_changes() -> None:
    asked: list[int] = []

    @once
    def twice(number: int) -> int:
        asked.append(number)
        return 2 * number

    assert (twice(1), twice(1), asked) == (2, 2, [1, 1])
    with unchanged():
        assert (twice(1), twice(2), twice(1), asked) == (2, 4, 2, [1, 1, 1, 2])
        with unchanged():
            assert (twice(2), asked) == (4, [1, 1, 1, 2])
        assert (twice(2), asked) == (4, [1, 1, 1, 2])
    assert (twice(2), asked) == (4, [1, 1, 1, 2, 2])


def test_an_error_is_not_kept_and_ends_the_keeping() -> None:
    answers = iter((0, 1))

    @once
    def inverse() -> float:
        return 1 / next(answers)

    try:
        with unchanged():
            inverse()
    except ZeroDivisionError:
        pass
    with unchanged():
        assert inverse() == 1
