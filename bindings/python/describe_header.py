# SPDX-FileCopyrightText: 2026 the multisap authors
# SPDX-License-Identifier: MIT
"""Describes multisap.h in JSON, for those who write bindings.

    python3 describe_header.py multisap.h OUTPUT.json

pycparser reads the preprocessed header and tells names and types; what only a
compiler knows, sizes, offsets and values, is printed by a small program that is
compiled and run. Types are spelled as in the header:

    functions   name: {returns, arguments: [[name, type], ...]}
    callbacks   the same, of the types of function pointers
    structs     name: {size, fields: [{name, type, offset, size}, ...]}
    enums       name: {size, values: {name: number}}
    constants   name of a macro: number

The compiler is $CC, or cc.
"""

import json
import os
import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

from pycparser import c_ast, c_parser

PREFIX = "msap_"
COMPILER = [*shlex.split(os.environ.get("CC", "cc")), "-std=c99"]


def run(*command):
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout


# ---------------------------------------------------------------- what pycparser tells


def parse(header):
    """What the compiler's own headers say beyond C99 is taken out: pycparser does not read it."""
    text = run(*COMPILER, "-E", "-P", "-D__attribute__(x)=", "-D__extension__=", str(header))
    return c_parser.CParser().parse(text).ext


def spell(node):
    """A type as C spells it, without the name that it declares."""
    if isinstance(node, c_ast.PtrDecl):
        inner = spell(node.type)
        star = "*" if inner.endswith("*") else " *"
        return inner + star + "".join(node.quals)
    if isinstance(node, c_ast.ArrayDecl):
        return f"{spell(node.type)}[{node.dim.value}]"
    if isinstance(node, c_ast.TypeDecl):
        return " ".join([*node.quals, *node.type.names])
    return spell(node.type)


def describe_function(node):
    arguments = [[argument.name, spell(argument.type)] for argument in node.args.params]
    return {"returns": spell(node.type),
            "arguments": [] if arguments == [[None, "void"]] else arguments}


def collect(nodes):
    """Names and types of what the header declares."""
    found = {"functions": {}, "callbacks": {}, "structs": {}, "enums": {}}
    for node in nodes:
        if not (node.name or "").startswith(PREFIX):
            continue
        kind = node.type
        inner = getattr(kind, "type", None)
        if isinstance(kind, c_ast.FuncDecl):
            found["functions"][node.name] = describe_function(kind)
        elif isinstance(kind, c_ast.PtrDecl) and isinstance(inner, c_ast.FuncDecl):
            found["callbacks"][node.name] = describe_function(inner)
        elif isinstance(inner, c_ast.Struct) and inner.decls:
            found["structs"][node.name] = [(field.name, spell(field.type)) for field in inner.decls]
        elif isinstance(inner, c_ast.Enum):
            found["enums"][node.name] = [value.name for value in inner.values.enumerators]
    return found


def collect_constants(header):
    """The macros that are numbers: those without parameters that have a value and are not MSAP_API."""
    macros = run(*COMPILER, "-E", "-dM", str(header))
    names = re.findall(r"^#define (MSAP_\w+) \S", macros, re.MULTILINE)
    return sorted(set(names) - {"MSAP_API"})


# ------------------------------------------------------------ what a compiler tells


def measure(header, expressions):
    """The values of C expressions, as a compiled program prints them."""
    prints = "\n".join(f'    printf("%.17g\\n", (double)({expression}));' for expression in expressions)
    source = f'#include "{header}"\n#include <stdio.h>\nint main(void)\n{{\n{prints}\n    return 0;\n}}\n'
    with tempfile.TemporaryDirectory() as folder:
        program = pathlib.Path(folder, "measure")
        program.with_suffix(".c").write_text(source)
        run(*COMPILER, "-o", str(program), str(program.with_suffix(".c")))
        numbers = map(float, run(str(program)).split())
    return {e: int(n) if n.is_integer() else n for e, n in zip(expressions, numbers)}


def describe(header):
    found = collect(parse(header))
    constants = collect_constants(header)
    expressions = list(constants)
    for name, fields in found["structs"].items():
        expressions.append(f"sizeof({name})")
        for field, _ in fields:
            expressions += [f"offsetof({name}, {field})", f"sizeof((({name} *)0)->{field})"]
    for name, values in found["enums"].items():
        expressions += [f"sizeof({name})", *values]
    value = measure(header, expressions)

    for name, fields in found["structs"].items():
        found["structs"][name] = {"size": value[f"sizeof({name})"], "fields": [
            {"name": field, "type": kind, "offset": value[f"offsetof({name}, {field})"],
             "size": value[f"sizeof((({name} *)0)->{field})"]} for field, kind in fields]}
    for name, values in found["enums"].items():
        found["enums"][name] = {"size": value[f"sizeof({name})"],
                                "values": {item: value[item] for item in values}}
    return {**found, "constants": {name: value[name] for name in constants}}


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(f"usage: {sys.argv[0]} multisap.h OUTPUT.json")
    description = describe(pathlib.Path(sys.argv[1]).resolve())
    pathlib.Path(sys.argv[2]).write_text(json.dumps(description, indent=1) + "\n")
