#!/usr/bin/env python3
"""Which sources of a target may be compiled as one: no two of them define the same name for themselves alone.

    unity_groups.py LINES SOURCE...

A number a source, in their order, separated by semicolons: those of one number go together. LINES: about how long a group becomes. Read are lines that
begin at the margin, as .clang-format leaves whatever a namespace holds; a name that is seen wrongly costs a group, no more.
"""
import functools
import pathlib
import re
import sys

NAMES = [
    re.compile(r"^(?:template <.*> )?(?:struct|class|enum class|enum|union) (\w+)"),
    re.compile(r"^#define (\w+)"),
    re.compile(r"^(?:MATCHER|ACTION)\w*\((\w+)"),
]
ALIAS = re.compile(r"^(?:using|namespace) (\w+) = .*;")
# A function or a variable: what stands before its parameters or its value, unless a class or a namespace goes before it.
OTHER = re.compile(r"(?<![:\w'.])([A-Za-z_]\w*)(?=\s*[({=;\[])")
# Inside functions too: what hides a constant of another file is warned of.
CONSTANT = re.compile(r"^ .*\b(k[A-Z]\w*)(?=\s*[({=\[])")
NO_NAMES = re.compile(r"^(?:using|namespace|template|return|TEST|INSTANTIATE|#|//|[^A-Za-z])")


INCLUDE = re.compile(r'^#include "(.+)"')


@functools.cache
def names_of(path):
    """Two dictionaries of names, of those that the file defines for itself alone and of all, its headers' too: what they stand for if they may be said
    again, else None."""
    own, every, inside = {}, {}, False
    with open(path, encoding="utf-8") as file:
        for line in file:
            if header := INCLUDE.match(line):
                for folder in path.parents[:2]:  # a header's name has its room's folder, or a test's is beside it
                    if (folder / header.group(1)).exists():
                        every.update(dict.fromkeys(names_of(folder / header.group(1))[1]))
                        break
            if line.startswith("namespace {"):
                inside = True
            elif line.rstrip() == "}  // namespace":
                inside = False
            found = {match.group(1): None for match in (kind.match(line) for kind in NAMES) if match}
            if alias := ALIAS.match(line):
                found = {alias.group(1): alias.group(0)}
            elif not found and not NO_NAMES.match(line):
                found = dict.fromkeys(OTHER.findall(line))
            elif constant := CONSTANT.match(line):
                every.setdefault(constant.group(1))
            every.update(found)
            if inside or line.startswith(("static ", "#define ", "namespace ", "using ")):
                own.update(found)
    return own, every


def clash(own, others):
    return any(name in others and (meaning is None or meaning != others[name]) for name, meaning in own.items())


def lines_of(path):
    with open(path, encoding="utf-8") as file:
        return sum(1 for _ in file)


def main():
    most, sources = int(sys.argv[1]), [pathlib.Path(word).resolve() for word in sys.argv[2:]]
    groups, numbers = [], []  # of each group: its own names, all its names, its lines
    for source in sources:
        own, every = names_of(source)
        length = lines_of(source)
        for number, (their_own, theirs, lines) in enumerate(groups):
            if lines + length <= most and not clash(own, theirs) and not clash(their_own, every):
                break
        else:
            number = len(groups)
            groups.append(({}, {}, 0))
        their_own, theirs, lines = groups[number]
        groups[number] = (their_own | own, theirs | every, lines + length)
        numbers.append(number)
    print(";".join(map(str, numbers)), end="")


if __name__ == "__main__":
    main()
