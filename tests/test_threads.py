"""Blocks of rows and what runs on them."""

import threading

import pytest

from ipcli import threads


@pytest.mark.parametrize("number", [1, 2, 3, 5])
@pytest.mark.parametrize(("height", "least"), [(1, 1), (4, 1), (97, 1), (97, 32), (31, 32), (480, 32)])
def test_blocks_cover_the_rows_once_in_order_and_keep_to_the_least_height(monkeypatch, number, height, least):
    monkeypatch.setenv("NUMBA_NUM_THREADS", str(number))
    blocks = threads.blocks(height, least)
    assert [row for top, bottom in blocks for row in range(top, bottom)] == list(range(height))
    assert len(blocks) <= number
    assert len(blocks) == 1 or min(b - t for t, b in blocks) >= least


def test_items_run_side_by_side_and_come_back_in_their_order(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "3")
    together = threading.Barrier(3, timeout=10)  # opens only if three wait at once

    def wait(item):
        together.wait()
        return item * item

    assert threads.each(wait, [3, 1, 2]) == [9, 1, 4]


def test_a_failure_in_a_block_reaches_the_caller(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")
    with pytest.raises(ZeroDivisionError):
        threads.each(lambda item: 1 // item, [1, 0])


def test_each_within_each_does_not_wait_for_itself(monkeypatch):
    monkeypatch.setattr(threads, "count", lambda: 2)
    outer = threads.each(lambda i: sum(threads.each(lambda j: 10 * i + j, range(5))), range(6))
    assert outer == [50 * i + 10 for i in range(6)]


@pytest.mark.parametrize("number", [1, 2])
def test_ahead_keeps_the_order_and_is_one_item_ahead_at_most(monkeypatch, number):
    monkeypatch.setenv("NUMBA_NUM_THREADS", str(number))
    begun = []

    def one(item):
        begun.append(item)
        return 2 * item

    seen = []
    for done in threads.ahead(one, range(5)):
        seen.append(done)
        assert len(begun) <= len(seen) + number - 1
    assert seen == [0, 2, 4, 6, 8]
    assert list(threads.ahead(one, [])) == []


def test_a_failure_ahead_reaches_the_caller(monkeypatch):
    monkeypatch.setenv("NUMBA_NUM_THREADS", "2")
    with pytest.raises(ZeroDivisionError):
        list(threads.ahead(lambda item: 1 // item, [1, 0]))
