"""Read a component's declaration, `<Component>.toml`, and the files that it includes.

`read` returns a `Declaration`; anything wrong raises `DeclarationError`, whose text names the file, the
variable, the key and the rule.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, TypeAlias

from declaration import PLAIN_TYPES, TAKEN, Declaration, DeclarationError, Fragment, Variable
from pydantic import ValidationError

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

INT32 = 2**31 - 1

Table: TypeAlias = dict[str, Any]


def read(path: Path) -> Declaration:
    """Read and check a declaration; what it includes comes first."""
    content = _table(path, path.name)
    whole, outputs = (_names(path, content, key) for key in ("include", "outputs_of"))
    overrides = content.pop("override", {})
    included = [*whole, *outputs]
    parts = [
        *(_fragment(path, name, "include") for name in whole),
        *(_outputs(_fragment(path, name, "outputs_of")) for name in outputs),
    ]
    shared = {name: _settings(name, part) for name, part in zip(included, parts, strict=True)}
    for key in {"settings", "shared"} & content.keys():
        raise DeclarationError(f"{path.name}: {key}: only an included file may have settings")
    _override(path.name, parts, overrides)

    own = _validated(Declaration, path.name, content)
    if own.name != path.stem:
        raise DeclarationError(f"{path.name}: name = '{own.name}': must be that of the file")
    fragments = [(name, _validated(Fragment, name, part)) for name, part in zip(included, parts, strict=True)]
    origins = [*fragments, (path.name, own)]
    _refuse_repetitions(path.name, origins)
    declaration = own.model_copy(
        update={
            "enumeration": {name: e for _, part in origins for name, e in part.enumeration.items()},
            "variable": [variable for _, part in origins for variable in part.variable],
            "shared": {settings_header(name): part for name, part in shared.items() if part.settings},
        }
    )
    files = {variable.name: name for name, part in origins for variable in part.variable}
    for subject, problem in (*_problems(declaration), *_strangers(shared, origins)):
        raise DeclarationError(f"{files.get(subject, path.name)}: {problem}")
    return declaration


def read_settings(path: Path) -> Fragment:
    """Read a file that has settings; its header does not depend on the components that include it."""
    return _settings(path.name, _table(path, path.name))


def settings_header(name: str) -> str:
    """`shared/correction.toml` -> `settings/correction.hpp`."""
    return f"settings/{Path(name).stem}.hpp"


def _settings(file: str, content: Table) -> Fragment:
    fragment: Fragment = _validated(Fragment, file, content)
    for group in fragment.settings:
        variables = [v for v in fragment.of("parameter", "tunable") if v.path[0] == group]
        if not variables:
            raise DeclarationError(f"{file}: settings: no parameter of the file is in the group '{group}'")
        for v in variables:
            if len(v.path) != 2:
                raise DeclarationError(f"{file}: variable '{v.name}': settings have no groups within groups")
            if v.type not in (*PLAIN_TYPES, *fragment.enumeration):
                raise DeclarationError(f"{file}: variable '{v.name}': type: '{v.type}' must be of this file")
    return fragment


def _strangers(shared: dict[str, Fragment], origins: list[tuple[str, Fragment]]) -> Iterator[tuple[str, str]]:
    """Parameters of a group in settings that another file declares."""
    home = {group: name for name, part in shared.items() for group in part.settings}
    for name, part in origins:
        for variable in part.of("parameter", "tunable"):
            if home.get(group := variable.path[0], name) != name:
                yield (
                    variable.name,
                    f"variable '{variable.name}': the group '{group}' is in the settings of {home[group]}",
                )


def _table(path: Path, name: str) -> Table:
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except tomllib.TOMLDecodeError as error:
        raise DeclarationError(f"{name}: {error}") from error


def _names(path: Path, content: Table, key: str) -> list[str]:
    """Names of the files of a key, which is taken out of the content."""
    names = content.pop(key, [])
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise DeclarationError(f"{path.name}: {key}: must be a list of file names")
    return names


def _fragment(path: Path, name: str, key: str) -> Table:
    """Content of an included file; its name is relative to the including one."""
    file = path.parent / name
    if not file.is_file():
        raise DeclarationError(f"{path.name}: {key}: there is no file '{name}'")
    return _table(file, name)


def _outputs(fragment: Table) -> Table:
    """The outputs alone of an included file, with the enumerations that they have."""
    variables = [v for v in fragment.get("variable", []) if v.get("causality") == "output"]
    types = {v.get("type") for v in variables}
    enumerations = {n: e for n, e in fragment.get("enumeration", {}).items() if n in types}
    return {"variable": variables, "enumeration": enumerations}


def _override(file: str, parts: list[Table], overrides: Table) -> None:
    """Replace keys of included variables."""
    variables = {v.get("name"): v for part in parts for v in part.get("variable", [])}
    for name, keys in overrides.items():
        if name not in variables:
            raise DeclarationError(f"{file}: override '{name}': no included file declares this variable")
        if not isinstance(keys, dict) or "name" in keys:
            raise DeclarationError(f"{file}: override '{name}': must be a table of keys other than name")
        variables[name].update(keys)


def _validated(kind: type[Fragment], file: str, content: Table) -> Any:
    try:
        return kind.model_validate(content)
    except ValidationError as error:
        raise DeclarationError("\n".join(_sentences(file, content, error))) from error


def _sentences(file: str, content: Table, error: ValidationError) -> Iterator[str]:
    """Pydantic's complaints, with the variable's name for its number."""
    for problem in error.errors():
        where = list(problem["loc"])
        subject = ""
        variables = content.get("variable")
        if where[:1] == ["variable"] and len(where) > 1 and isinstance(variables, list):
            entry = variables[int(where[1])]
            subject = f"variable '{entry.get('name', f'number {int(where[1]) + 1}')}': "
            where = where[2:]
        # Beyond the key, the place is pydantic's name for one arm of a union.
        key = f"{where[0]}: " if len(where) > 0 and subject else "".join(f"{part}: " for part in where)
        yield f"{file}: {subject}{key}{problem['msg'].removeprefix('Value error, ')}"


def _refuse_repetitions(file: str, origins: list[tuple[str, Fragment]]) -> None:
    """Each variable and each enumeration stands in one place."""
    seen: dict[tuple[str, str], str] = {}
    for origin, part in origins:
        named = [("variable", v.name) for v in part.variable] + [("enumeration", e) for e in part.enumeration]
        for kind, name in named:
            if (kind, name) in seen:
                where = {seen[kind, name], origin} - {file}
                places = f" (in {' and '.join(sorted(where))})" if where else ""
                raise DeclarationError(f"{file}: {kind} '{name}': declared twice{places}")
            seen[kind, name] = origin


def _problems(declaration: Declaration) -> Iterator[tuple[str, str]]:
    """Rules that concern more than one variable: the variable, if it is one, and the sentence."""
    for name in declaration.enumeration:
        if not re.fullmatch(r"[A-Z][A-Za-z0-9]*", name):
            yield name, f"enumeration '{name}': must be CamelCase"
        if name in TAKEN:
            yield name, f"enumeration '{name}': the name is taken; so are {', '.join(TAKEN)}"
    names = {variable.name for variable in declaration.variable}
    for variable in declaration.variable:
        for problem in _problems_of(variable, declaration, names):
            yield variable.name, f"variable '{variable.name}': {problem}"


def _problems_of(variable: Variable, declaration: Declaration, names: set[str]) -> Iterator[str]:
    for depth in range(1, len(variable.path)):
        prefix = ".".join(variable.path[:depth])
        if prefix in names:
            yield f"'{prefix}' is a variable and cannot be a group of variables too"
        group = "".join(word.capitalize() for word in variable.path[depth - 1].split("_"))
        if group in declaration.enumeration:
            yield f"the group '{prefix}' and the enumeration '{group}' would have one C++ name"
    if variable.type not in (*PLAIN_TYPES, *declaration.enumeration):
        known = ", ".join((*PLAIN_TYPES, *declaration.enumeration))
        yield f"type: '{variable.type}' is unknown; known are {known}"
    elif variable.start is not None:
        yield from (f"start: {text}" for text in _start_problems(variable, declaration))


def _start_problems(variable: Variable, declaration: Declaration) -> Iterator[str]:
    """Start values of the wrong number, the wrong type or out of range."""
    start, shape = variable.start, variable.shape
    if isinstance(start, list):
        rows = tuple(len(row) for row in start if isinstance(row, list))
        fits = (len(shape) == 1 and not rows and len(start) == shape[0]) or (
            len(shape) == 2 and len(start) == shape[0] and rows == (shape[1],) * shape[0]
        )
        if not fits:
            yield f"the list must have the size {list(shape) if shape else 'of a scalar'}"
            return
    for value in variable.starts:
        if variable.type in declaration.enumeration:
            items = [item.name for item in declaration.enumeration[variable.type].items]
            if value not in items:
                yield f"'{value}' is not an item of {variable.type}; items are {', '.join(items)}"
        elif variable.type == "Boolean":
            if not isinstance(value, bool):
                yield f"'{value}' must be true or false"
        elif isinstance(value, (bool, str)) or (variable.type == "Integer" and not isinstance(value, int)):
            yield f"'{value}' must be a number, of type {variable.type}"
        elif not math.isfinite(value) and not variable.optional:
            yield f"{value} must be a finite number"
        elif variable.type == "Integer" and abs(value) > INT32:
            yield f"{value} must fit into 32 bits"
        elif variable.smallest is not None and value < variable.smallest:
            yield f"{value} must be at least {variable.smallest}"
        elif variable.above is not None and value <= variable.above:
            yield f"{value} must be greater than {variable.above}"
        elif variable.largest is not None and value > variable.largest:
            yield f"{value} must be at most {variable.largest}"
