import numpy as np
import numpy.typing as npt

from intellwheels_server.world.kernels.episodes import merge_episodes

HOLD = 5


def table(*rows: tuple[int, int, int]) -> npt.NDArray[np.int64]:
    return np.array(rows, dtype=np.int64).reshape(-1, 3)


def test_pair_that_begins_is_told_once_by_its_first_row() -> None:
    episodes, began, ended = merge_episodes(table(), table((1, 2, 7), (1, 2, 8), (3, -1, 9)), 10, HOLD)
    assert episodes.tolist() == [[1, 2, 10], [3, -1, 10]]
    assert began.tolist() == [7, 9]
    assert ended.tolist() == []


def test_pair_that_goes_on_is_not_told_again() -> None:
    episodes, began, ended = merge_episodes(table((1, 2, 9)), table((1, 2, 0)), 10, HOLD)
    assert (episodes.tolist(), began.tolist(), ended.tolist()) == ([[1, 2, 10]], [], [])


def test_pair_without_touch_is_kept_until_the_hold_time_is_over() -> None:
    episodes, _, ended = merge_episodes(table((1, 2, 10)), table(), 14, HOLD)
    assert (episodes.tolist(), ended.tolist()) == ([[1, 2, 10]], [])
    episodes, _, ended = merge_episodes(table((1, 2, 10)), table(), 15, HOLD)
    assert (episodes.tolist(), ended.tolist()) == ([], [[1, 2]])


def test_merge_agrees_with_sets_on_random_histories() -> None:
    random = np.random.default_rng(1)
    episodes = table()
    last: dict[tuple[int, int], int] = {}
    for tick in range(400):
        touching = {(int(a), int(a) + int(b)) for a, b in random.integers(1, 5, size=(random.integers(0, 4), 2))}
        pairs = table(*[(a, b, k) for k, (a, b) in enumerate(sorted(touching))])
        episodes, began, ended = merge_episodes(episodes, pairs, tick, HOLD)
        assert {tuple(pairs[k, :2].tolist()) for k in began} == touching - last.keys()
        gone = {pair for pair, when in last.items() if pair not in touching and tick - when >= HOLD}
        assert {tuple(pair) for pair in ended.tolist()} == gone
        last = {pair: when for pair, when in last.items() if pair not in gone} | dict.fromkeys(touching, tick)
        assert {(a, b): when for a, b, when in episodes.tolist()} == last
        assert episodes[:, :2].tolist() == sorted(episodes[:, :2].tolist())
