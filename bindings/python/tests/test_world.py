# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""A world from its beginning to its end."""

import copy
import ctypes
import gc
import pickle
import weakref

import numpy as np
import pytest

import brute_force
import multisap


def row_of_boxes(n, step=1.0, width=1.0):
    """n boxes along x: with step 1 and width 1 each touches the next."""
    lo = np.zeros((n, 3), np.float32)
    lo[:, 0] = np.arange(n) * step
    return lo, lo + np.float32(width)


# --------------------------------------------------------------------- events


def test_ids_are_the_handles_of_the_library(world):
    lo, hi = row_of_boxes(3)
    ids = world.add(lo, hi)
    assert ids.dtype == np.uint64
    assert ids.tolist() == [slot << 32 | 1 for slot in range(3)]


def test_boxes_come_move_and_go(world):
    lo, hi = row_of_boxes(3)
    ids = world.add(lo, hi)
    events = world.commit()
    assert events.created.tolist() == [[ids[0], ids[1]], [ids[1], ids[2]]]
    assert events.deleted.shape == (0, 2) and events.active == 2

    world.update(ids[:1], lo[2:] + 0.5, hi[2:] + 0.5)
    events = world.commit()
    assert events.created.tolist() == [[ids[0], ids[2]]]
    assert events.deleted.tolist() == [[ids[0], ids[1]]]

    world.remove(ids[2])
    events = world.commit()
    assert events.deleted.tolist() == [[ids[0], ids[2]], [ids[1], ids[2]]]
    assert events.active == 0 and len(world.pairs()) == 0


def test_pairs_have_names(world):
    ids = world.add(*row_of_boxes(3)).tolist()
    created = world.commit().created
    assert list(created) == [(ids[0], ids[1]), (ids[1], ids[2])]
    for pair in created:
        assert isinstance(pair, multisap.Pair) and pair.a < pair.b
        assert type(pair.a) is int
    assert list(world.pairs()) == list(created)
    assert list(created[created[:, 0] == ids[1]]) == [multisap.Pair(ids[1], ids[2])]


def test_columns_of_pairs_are_arrays(world):
    """Also where there are two pairs, and the transposed array looks like two pairs."""
    ids = world.add(*row_of_boxes(3))
    a, b = world.commit().created.T
    assert isinstance(a, np.ndarray) and isinstance(b, np.ndarray)
    assert (a == ids[:2]).all() and (b == ids[1:]).all()
    assert list(world.pairs()[0]) == ids[:2].tolist()


def test_results_outlive_everything():
    world = multisap.World()
    lo, hi = row_of_boxes(100)
    ids = world.add(lo, hi)
    events, pairs = world.commit(), world.pairs()
    kept = [array.copy() for array in (events.created, events.created_data, pairs)]
    world.update(ids, lo * 100, lo * 100)
    world.commit()
    world.trim()
    world.close()
    del world
    gc.collect()
    for array, copied in zip((events.created, events.created_data, pairs), kept):
        assert np.array_equal(array, copied)
        array[...] = 0


def test_events_can_be_read_again(world):
    ids = world.add(*row_of_boxes(2))
    world.commit()
    world.remove(ids[:1])
    assert world.events().created.tolist() == [ids.tolist()]
    assert world.commit().deleted.tolist() == world.events().deleted.tolist() == [ids.tolist()]
    world.trim()
    assert len(world.events().deleted) == 0
    assert repr(world.events()) == "<Events created=0 deleted=0 active=0>"


def test_two_static_boxes_never_pair(world):
    ids = world.add(*row_of_boxes(4), static=[True, True, False, False])
    assert world.commit().created.tolist() == [ids[1:3].tolist(), ids[2:4].tolist()]
    floor = world.add([[-1, -1, -1]], [[9, 9, 9]], static=True)
    assert world.commit().created.tolist() == [[ids[2], floor[0]], [ids[3], floor[0]]]


def test_two_dimensions():
    with multisap.World(dims=2) as world:
        assert world.dims == 2
        ids = world.add([[0, 0], [1, 1]], [[1, 1], [2, 2]])
        assert world.commit().created.tolist() == [ids.tolist()]
        assert [array.tolist() for array in world.bounds(ids)] == [[[0, 0], [1, 1]], [[1, 1], [2, 2]]]
        with pytest.raises(ValueError, match=r"\(n, 2\)"):
            world.add(np.zeros((1, 3)), np.zeros((1, 3)))


def test_bounds_are_those_last_given(world):
    lo, hi = row_of_boxes(3)
    ids = world.add(lo, hi)
    world.update(ids[1:], lo[1:] + 5, hi[1:] + 5)
    lo_read, hi_read = world.bounds(ids[::-1])
    assert np.array_equal(lo_read, lo[::-1] + np.float32([[5], [5], [0]]))
    assert np.array_equal(hi_read, hi[::-1] + np.float32([[5], [5], [0]]))


def test_of_an_id_that_comes_twice_the_last_counts(world):
    ids = world.add(*row_of_boxes(1))
    world.update([ids[0], ids[0]], [[1, 1, 1], [2, 2, 2]], [[3, 3, 3], [4, 4, 4]])
    assert world.bounds(ids)[0].tolist() == [[2, 2, 2]]


def test_the_origin_can_be_moved(world):
    lo, hi = row_of_boxes(3)
    ids = world.add(lo, hi)
    world.commit()
    world.shift_origin([1, 2, -0.5])
    assert np.array_equal(world.bounds(ids)[0], lo - np.float32([1, 2, -0.5]))
    assert len(world.commit().created) == 0
    world.shift_origin(np.float32([-1, -2, 0.5]))
    assert np.array_equal(world.bounds(ids)[1], hi)


def test_offsets_that_are_not_allowed(world):
    for offset in (1, [1, 2], np.zeros((3, 1))):
        with pytest.raises(ValueError, match=r"offset must have the shape \(3,\)"):
            world.shift_origin(offset)
    with pytest.raises(multisap.ConfigError):
        world.shift_origin([0, np.inf, 0])


# ------------------------------------------------------------------ user data


def test_user_data_of_pairs(world):
    world.add(*row_of_boxes(4))
    pairs = world.commit().created
    assert world.pair_data(pairs).tolist() == [0, 0, 0]
    world.set_pair_data(pairs, [7, -8, 9])
    assert world.pair_data(pairs[::-1, ::-1]).tolist() == [9, -8, 7]
    assert world.pair_data(list(pairs)).tolist() == [7, -8, 9]
    world.set_pair_data(pairs[:1], 1)
    world.remove(pairs[1, 0])
    events = world.commit()
    assert events.deleted.tolist() == pairs[:2].tolist() and events.deleted_data.tolist() == [1, -8]


def test_user_data_of_removed_boxes_until_the_commit(world):
    ids = world.add(*row_of_boxes(2), data=[3, 4])
    world.remove(ids[:1])
    assert world.user_data(ids).tolist() == [3, 4]
    world.commit()
    with pytest.raises(multisap.HandleError):
        world.user_data(ids)


# -------------------------------------------------------------------- options

OPTIONS = [
    dict(grid=multisap.Grid.NONE),
    dict(grid=multisap.Grid.AUTO, cell_size=2.0),
    dict(grid=multisap.Grid.FIXED, grid_cells=(4, 3, 2), grid_min=(0, 0, 0), grid_max=(9, 9, 9)),
    dict(grid=multisap.Grid.NONE, filters=False),
    dict(margin=0), dict(margin=0.5), dict(margin=multisap.MARGIN_AUTO),
    *(dict(strategy=strategy) for strategy in multisap.Strategy),
    *(dict(simd=simd) for simd in multisap.Simd),
]


@pytest.mark.parametrize("options", OPTIONS, ids=str)
def test_every_set_up_gives_the_same_events(rng, options):
    lo = rng.random((200, 3)).astype(np.float32) * 9
    with multisap.World() as plain, multisap.World(**options) as other:
        ids = plain.add(lo, lo + 1)
        assert (other.add(lo, lo + 1) == ids).all()
        for _ in range(5):
            one, two = plain.commit(), other.commit()
            assert np.array_equal(one.created, two.created) and np.array_equal(one.deleted, two.deleted)
            other.validate()
            lo += rng.normal(0, 0.3, lo.shape).astype(np.float32)
            plain.update(ids, lo, lo + 1)
            other.update(ids, lo, lo + 1)
        expected = brute_force.by_id(ids, brute_force.pairs(lo, lo + 1))
        plain.commit()
        other.commit()
        assert sorted(plain.pairs()) == sorted(other.pairs()) == sorted(map(tuple, expected.tolist()))


def test_the_limit_of_boxes():
    with multisap.World(max_boxes=2) as world:
        with pytest.raises(multisap.FullError) as caught:
            world.add(*row_of_boxes(3))
        assert caught.value.row == 2
        world.add(*row_of_boxes(2))


@pytest.mark.parametrize("options", [
    dict(dims=4), dict(dims=2**32 + 3), dict(dims=-1), dict(grid=9), dict(strategy=4), dict(simd=5),
    dict(filters=2),
    dict(workers=0), dict(workers=65), dict(task_grain=2**32), dict(margin=-2), dict(margin=float("nan")),
    dict(cell_size=-1),
    dict(grid=multisap.Grid.FIXED, grid_cells=(0, 1, 1)), dict(grid_cells=(1, 1, 1, 1)),
    dict(grid=multisap.Grid.FIXED, grid_cells=(2**32 + 1, 1, 1), grid_max=(1, 1, 1)),
    dict(grid=multisap.Grid.FIXED, grid_cells=(2, 1, 1)),
], ids=str)
def test_options_that_are_not_allowed(options):
    with pytest.raises(multisap.ConfigError):
        multisap.World(**options)


@pytest.mark.parametrize("options", [dict(dims="3"), dict(max_boxes=1.5), dict(margin="wide"),
                                     dict(alloc=lambda user, size: None), dict(jobs_user=object()), dict(colour=1)],
                         ids=lambda options: next(iter(options)))
def test_options_of_the_wrong_type(options):
    with pytest.raises(TypeError):
        multisap.World(**options)


class Allocator:
    """An allocator in Python that counts, and fails when told to."""

    def __init__(self):
        self.held = {}
        self.users = set()
        self.left = None
        self.options = dict(alloc=multisap.AllocFunction(self.alloc), free=multisap.FreeFunction(self.free),
                            allocator_user=4711)

    def alloc(self, user, size):
        self.users.add(user)
        if self.left is not None:
            if self.left == 0:
                return None
            self.left -= 1
        block = ctypes.create_string_buffer(size)
        self.held[ctypes.addressof(block)] = block
        return ctypes.addressof(block)

    def free(self, user, pointer, size):
        self.users.add(user)
        assert len(self.held.pop(pointer)) == size


def test_an_allocator_in_python():
    allocator = Allocator()
    with multisap.World(**allocator.options) as world:
        world.add(*row_of_boxes(100))
        world.commit()
        assert world.stats().bytes == sum(map(len, allocator.held.values()))
    assert not allocator.held and allocator.users == {4711}


def test_an_allocator_outlives_its_world():
    """The hooks are kept alive by the world, which needs them when it is collected."""
    allocator = Allocator()
    world = multisap.World(**allocator.options)
    world.add(*row_of_boxes(100))
    alive = weakref.ref(allocator.options["free"])
    allocator.options.clear()
    gc.collect()
    assert alive() is not None
    del world
    gc.collect()
    assert not allocator.held


def test_no_memory_leaves_the_world_as_it_was():
    allocator = Allocator()
    with multisap.World(**allocator.options) as world:
        ids = world.add(*row_of_boxes(2))
        world.commit()
        for name in ("add", "commit"):
            for left in range(1000):
                allocator.left = left
                try:
                    world.add(*row_of_boxes(500)) if name == "add" else world.commit()
                    break
                except multisap.OutOfMemoryError as error:
                    assert isinstance(error, MemoryError) and error.row is None
                    world.validate()
                    assert world.pairs().tolist() == [ids.tolist()]
            else:
                pytest.fail(f"{name} never has enough memory")
            assert left > 0, f"{name} asked for no memory"
        allocator.left = None
        assert world.events().active > 500


def test_hooks_as_addresses():
    """So they come from libraries that were not loaded with ctypes."""
    allocator = Allocator()
    alloc, free = (ctypes.cast(allocator.options[name], ctypes.c_void_p).value for name in ("alloc", "free"))
    with multisap.World(alloc=alloc, free=free, allocator_user=4711) as world:
        world.add(*row_of_boxes(10))
        assert allocator.held
    assert not allocator.held


@pytest.mark.parametrize("hook", ["alloc", "free", "enqueue", "finish"])
def test_hooks_come_in_pairs(hook):
    kind = getattr(multisap, hook.capitalize() + "Function")
    with pytest.raises(multisap.ConfigError):
        multisap.World(**{hook: kind(lambda *arguments: None)})


def test_a_job_system_in_python(rng):
    """It runs each task at once, or as late as is allowed."""
    waiting = []

    @multisap.EnqueueFunction
    def enqueue(user, run, task):
        if len(waiting) % 2:
            run(task)
            return None
        waiting.append((run, task))
        return len(waiting)

    @multisap.FinishFunction
    def finish(user, ticket):
        run, task = waiting[ticket - 1]
        run(task)

    lo = rng.random((500, 3)).astype(np.float32) * 9
    with multisap.World(workers=4, task_grain=64, enqueue=enqueue, finish=finish) as world:
        ids = world.add(lo, lo + 1)
        created = world.commit().created
        assert np.array_equal(created, brute_force.by_id(ids, brute_force.pairs(lo, lo + 1)))


# ---------------------------------------------------------- looking after it


def test_stats(world):
    stats = world.stats()
    assert isinstance(stats, multisap.Stats) and stats.boxes == stats.commits == 0
    ids = world.add(*row_of_boxes(10))
    assert world.stats().boxes == world.stats().pending == 10
    world.commit()
    stats = world.stats()
    assert (stats.boxes, stats.pairs, stats.pending, stats.commits) == (10, 9, 0, 1)
    assert 0 < stats.bytes <= stats.bytes_peak and stats.allocations > 0
    world.remove(ids)
    world.commit()
    world.trim()
    assert world.stats().bytes < stats.bytes_peak


def test_validate_tells_what_is_broken(world, monkeypatch):
    """The library's own tests break worlds; here its answer stands for it."""
    from multisap import _world

    class Broken:
        def msap_validate(self, world, what):
            what._obj.value = b"a sentence"
            return multisap.Status.ERROR_CORRUPT

    with monkeypatch.context() as patch:
        patch.setattr(_world, "lib", Broken())
        with pytest.raises(multisap.CorruptError, match="a sentence"):
            world.validate()


# ------------------------------------------------------------------------ end


def test_a_closed_world_refuses_everything():
    world = multisap.World()
    ids = world.add(*row_of_boxes(2))
    assert repr(world) == "<multisap.World dims=3>"
    world.close()
    world.close()
    assert repr(world) == "<multisap.World dims=3 closed>"
    pairs = np.empty((0, 2), np.uint64)
    for call in (lambda: world.add(*row_of_boxes(1)), lambda: world.update(ids, *row_of_boxes(2)),
                 lambda: world.remove(ids), lambda: world.bounds(ids), lambda: world.user_data(ids),
                 lambda: world.set_user_data(ids, 1), world.commit, world.events, world.pairs,
                 lambda: world.commit(on_create=print), lambda: world.pair_data(pairs),
                 lambda: world.set_pair_data(pairs, 0), lambda: world.shift_origin([1, 1, 1]),
                 world.stats, world.validate, world.trim):
        with pytest.raises(multisap.MultisapError, match="the world is closed"):
            call()


def test_with_closes_the_world_after_an_error_too():
    with pytest.raises(KeyError):
        with multisap.World() as world:
            raise KeyError
    with pytest.raises(multisap.MultisapError, match="closed"):
        world.commit()


def test_a_collected_world_is_destroyed_once():
    allocator = Allocator()
    world = multisap.World(**allocator.options)
    world.cycle = world
    del world
    gc.collect()
    assert not allocator.held


@pytest.mark.parametrize("duplicate", [copy.copy, copy.deepcopy, pickle.dumps])
def test_a_world_cannot_be_duplicated(world, duplicate):
    with pytest.raises(TypeError, match="neither copied nor pickled"):
        duplicate(world)


def test_many_worlds_at_once(rng):
    worlds = [multisap.World() for _ in range(20)]
    for n, world in enumerate(worlds):
        world.add(*row_of_boxes(n))
    for n, world in enumerate(worlds):
        assert len(world.commit().created) == max(0, n - 1)
        world.close()
