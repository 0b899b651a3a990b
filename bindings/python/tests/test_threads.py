# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Several threads: what is allowed works, what is not is an error."""

import threading

import numpy as np
import pytest

import multisap
from multisap._gate import Gate

LO, HI = np.zeros((3, 3)), np.ones((3, 3))


def in_thread(function):
    """Runs it in another thread and returns what it returned or raised."""
    result = []

    def run():
        try:
            result.append(function())
        except Exception as error:
            result.append(error)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    return result[0]


CALLS = {
    "add": lambda world, ids: world.add(LO, HI),
    "update": lambda world, ids: world.update(ids, LO, HI),
    "remove": lambda world, ids: world.remove(ids),
    "shift_origin": lambda world, ids: world.shift_origin([1, 1, 1]),
    "bounds": lambda world, ids: world.bounds(ids),
    "user_data": lambda world, ids: world.user_data(ids),
    "set_user_data": lambda world, ids: world.set_user_data(ids, 1),
    "commit": lambda world, ids: world.commit(),
    "events": lambda world, ids: world.events(),
    "pairs": lambda world, ids: world.pairs(),
    "pair_data": lambda world, ids: world.pair_data([ids[:2]]),
    "set_pair_data": lambda world, ids: world.set_pair_data([ids[:2]], 1),
    "stats": lambda world, ids: world.stats(),
    "validate": lambda world, ids: world.validate(),
    "trim": lambda world, ids: world.trim(),
    "close": lambda world, ids: world.close(),
}


@pytest.mark.parametrize("call", CALLS)
def test_while_one_thread_commits_no_other_gets_in(world, call):
    """The callback stands for a commit that takes its time."""
    ids = world.add(LO, HI)
    answers = []
    world.commit(on_create=lambda *arguments: answers.append(in_thread(lambda: CALLS[call](world, ids))))
    assert len(answers) == 3
    for answer in answers:
        assert isinstance(answer, multisap.BusyError)
        assert str(answer) == "the world is in use by another call"
    assert world.stats().boxes == 3


def test_threads_take_turns(world):
    ids = world.add(LO, HI)
    in_thread(lambda: world.update(ids, LO + 5, HI + 5))
    assert len(in_thread(world.commit).created) == 3
    assert len(world.pairs()) == 3


def test_different_worlds_at_once(world):
    world.add(LO, HI)

    def use_another():
        with multisap.World() as other:
            other.add(LO, HI)
            return other.commit().active

    answers = []
    world.commit(on_create=lambda *arguments: answers.append(in_thread(use_another)))
    assert answers == [3, 3, 3]


def test_many_may_read():
    gate = Gate()
    with gate.reader:
        assert in_thread(lambda: gate.reader.__enter__()) is None
        assert isinstance(in_thread(lambda: gate.owner.__enter__()), multisap.BusyError)
        gate.reader.__exit__()
    with gate.owner:
        assert isinstance(in_thread(lambda: gate.reader.__enter__()), multisap.BusyError)
    with gate.reader:
        pass


def test_only_callbacks_are_let_through():
    gate = Gate()
    with gate.owner:
        with gate.callback:
            with gate.owner, gate.reader:
                assert isinstance(in_thread(lambda: gate.reader.__enter__()), multisap.BusyError)
        with pytest.raises(multisap.BusyError):
            gate.reader.__enter__()


def test_a_refused_call_leaves_the_gate_as_it_was():
    gate = Gate()
    with gate.owner:
        for turn in (gate.owner, gate.reader):
            with pytest.raises(multisap.BusyError):
                with turn:
                    pytest.fail("it was let in")
        with pytest.raises(multisap.BusyError):
            gate.owner.__enter__()
    with gate.owner:
        pass


def test_no_crash_whatever_threads_do():
    """Threads that do not care: each call works or is refused, and the world stays whole."""
    world = multisap.World()
    start = threading.Barrier(4)
    others = []

    def use(seed):
        rng = np.random.default_rng(seed)
        start.wait()
        for _ in range(300):
            name = rng.choice(["add", "remove", "commit", "pairs", "stats"])
            try:
                if name == "add":
                    lo = rng.random((20, 3)) * 5
                    world.add(lo, lo + 1)
                elif name == "remove" and len(world.pairs()):
                    world.remove(np.unique(world.pairs()[:10]))
                elif name == "commit":
                    world.commit()
                else:
                    world.pairs()
                    world.stats()
            except (multisap.BusyError, multisap.HandleError):
                pass
            except BaseException as error:
                others.append(error)

    threads = [threading.Thread(target=use, args=[seed]) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert others == []
    world.validate()
    world.close()
