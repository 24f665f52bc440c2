"""Calls shared out over threads: each is made once, an error comes back, and what has not begun is dropped."""

import threading
import time

import pytest

from frictionloop.loop.parallel_runs import shared_out


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_each_call_is_made_once(workers):
    made = sorted(shared_out(lambda a, b: (a, b), [(i, -i) for i in range(40)], workers))
    assert made == [(i, -i) for i in range(40)]


def test_the_caller_works_too():
    """Two calls that wait for each other are done by two workers only if the caller is one of them."""
    both = threading.Barrier(2)
    threads = set(shared_out(lambda _: (both.wait(60) and None) or threading.get_ident(), [(1,), (2,)], 2))
    assert len(threads) == 2
    assert threading.get_ident() in threads


@pytest.mark.parametrize("thread", ["the caller", "its helper"])
def test_an_error_comes_back_and_drops_what_has_not_begun(thread):
    caller, began = threading.get_ident(), []
    met = threading.Event()

    def fails(number):
        began.append(number)
        if (threading.get_ident() == caller) == (thread == "the caller"):
            met.set()
            raise IndexError("no such place")
        met.wait(60)
        time.sleep(1e-3)

    with pytest.raises(IndexError, match="no such place"):
        list(shared_out(fails, [(i,) for i in range(100_000)], 2))
    assert len(began) < 100_000


def test_closing_drops_what_has_not_begun():
    began, threads = [], threading.active_count()

    def begins(number):
        began.append(number)
        time.sleep(1e-3)

    calls = shared_out(begins, [(i,) for i in range(100_000)], 2)
    next(calls)
    calls.close()
    assert len(began) < 100_000
    assert threading.active_count() == threads
