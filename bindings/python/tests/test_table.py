# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""The ctypes table says what the header says."""

import ctypes

import pytest

import multisap
from multisap import _api


def signature(described):
    return (described["returns"], *(kind for _, kind in described["arguments"]))


def test_every_function_has_its_result_and_arguments(description):
    assert {name: signature(f) for name, f in description["functions"].items()} == _api.FUNCTIONS


def test_every_callback_has_its_result_and_arguments(description):
    assert {name: signature(c) for name, c in description["callbacks"].items()} == _api.CALLBACKS


def test_every_struct_has_its_fields(description):
    fields = {name: [(field["name"], field["type"]) for field in struct["fields"]]
              for name, struct in description["structs"].items()}
    assert fields == _api.STRUCTS


STRUCTURES = {cls.__name__: cls for cls in vars(_api).values()
              if isinstance(cls, type) and issubclass(cls, ctypes.Structure)}


def test_every_struct_has_a_class():
    assert STRUCTURES.keys() == _api.STRUCTS.keys()


@pytest.mark.parametrize("name", STRUCTURES)
def test_fields_are_where_the_compiler_puts_them(description, name):
    structure, described = STRUCTURES[name], description["structs"][name]
    assert ctypes.sizeof(structure) == described["size"]
    for field in described["fields"]:
        place = getattr(structure, field["name"])
        assert (place.offset, place.size) == (field["offset"], field["size"]), field["name"]


def test_every_enum_has_its_values(description):
    assert description["enums"].keys() == _api.ENUMS.keys()
    for name, (enum, prefix) in _api.ENUMS.items():
        values = description["enums"][name]["values"]
        ours = {prefix + item.name: int(item) for item in enum}
        theirs = {prefix + python_name(name[len(prefix):]): number for name, number in values.items()}
        assert ours == theirs, name


def python_name(name):
    """MSAP_SIMD_NONE is Simd.NONE; what would begin with a digit keeps its prefix."""
    short = name[len("SIMD_"):] if name.startswith("SIMD_") else name
    return name if short[0].isdigit() else short


def test_constants(description):
    constants = dict(description["constants"])
    number = constants.pop("MSAP_VERSION_NUMBER")
    version = tuple(constants.pop(f"MSAP_VERSION_{part}") for part in ("MAJOR", "MINOR", "PATCH"))
    assert version == _api.VERSION
    assert number == version[0] * 10000 + version[1] * 100 + version[2]
    assert constants == {"MSAP_" + name: getattr(_api, name) for name in
                         ("STATUS_COUNT", "NULL_HANDLE", "MAX_BOXES", "MARGIN_AUTO", "STATIC", "AXIS_AUTO")}


# How C's scalar types must look in ctypes. An enum of the header fits an int.
WIDTHS = {"float": (4, 1.5), "int32_t": (4, -1), "uint32_t": (4, 2**32 - 1), "uint64_t": (8, 2**64 - 1),
          "msap_handle": (8, 2**64 - 1), "msap_status": (4, 11),
          "size_t": (ctypes.sizeof(ctypes.c_void_p), 2 ** (8 * ctypes.sizeof(ctypes.c_void_p)) - 1),
          "ptrdiff_t": (ctypes.sizeof(ctypes.c_void_p), -1)}


@pytest.mark.parametrize("name", WIDTHS)
def test_scalar_types(name):
    size, value = WIDTHS[name]
    kind = _api.ctype(name)
    assert ctypes.sizeof(kind) == size
    assert kind(value).value == value


def test_statuses_are_ints_to_the_compiler(description):
    assert {enum["size"] for enum in description["enums"].values()} == {ctypes.sizeof(ctypes.c_int)}


def test_types_that_the_header_does_not_have():
    with pytest.raises(TypeError):
        _api.ctype("unsigned long")


def test_the_library_lets_other_threads_run():
    python_api = 4
    from multisap._library import lib
    assert all(not getattr(lib, name)._flags_ & python_api for name in _api.FUNCTIONS)


def test_stats_have_the_fields_of_the_struct():
    assert list(multisap.Stats._fields) == [name for name, _ in _api.STRUCTS["msap_world_stats"][2:]]


def test_the_world_has_every_option():
    import inspect
    options = list(inspect.signature(multisap.World).parameters)
    assert options == [name for name, _ in _api.STRUCTS["msap_config"][1:]]
