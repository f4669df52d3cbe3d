"""All mistakes of a document in one error: each is replaced by a valid value, so that further checks can run."""

import copy
import difflib
import re
from collections.abc import Callable, Mapping
from typing import Any

from pydantic import BaseModel, ValidationError

from hypertuna.description.commented import commented
from hypertuna.description.validation import Place, field_at, fix_of, rule_of, written
from hypertuna.errors import InputError, InputErrors, did_you_mean, shown

# Kinds of TOML files: keys that only this kind has, and the command that reads it.
KINDS = {
    "a robot": ({"links", "joints", "body", "gaits"}, "a robot is an option: `--robot {file}`"),
    "a mission": ({"waypoints", "stay"}, "`hypertuna mission {file}` flies it"),
    "a manifest of trials": ({"recordings", "steady"}, "`hypertuna identify {file}` reads it"),
}
MOST = 200  # most mistakes that are reported; a file with more is of another kind
ROUNDS = 12  # most rounds of mending, since a mistake in a table hides those of its subtables
# A function that returns, for a document, two valid ones: as `hypertuna robot new` writes it, and with all tables.
Example = Callable[[Mapping[str, Any]], tuple[dict[str, Any], Mapping[str, Any]]]
Model = type[BaseModel]
ABOUT = ("uncertainty", "sources")  # tables about the values of other tables, which are not pasted


def translate(
    error: ValidationError, document: Mapping[str, Any], model: Model, file: str | None, example: Example | None = None
) -> InputError:
    """Return all mistakes of a document as one error, with the missing keys as text to paste.

    The rules come from the model's descriptions and units; `example` makes valid documents of about the same size.
    Without it, only the mistakes of pydantic's first run are found. For a nearly empty document, the text to paste is a
    whole file.
    """
    if wrong_kind := _of_another_kind(document, model, file):
        return wrong_kind
    by_key: dict[str, InputError] = {}
    missing: list[Place] = []
    if error.error_count() > MOST:
        example = None
    replaced: list[str] = []  # keys whose values are those of the example
    mended = copy.deepcopy(dict(document))
    first, valid = example(_spelled(document, model)) if example is not None else ({}, {})
    for _ in range(ROUNDS if example is not None else 1):
        errors = _in_order(error)
        mistakes = [(detail, _mistakes(detail, mended, model, file)) for detail in errors]
        for detail, reported in mistakes:
            new = [mistake for mistake in reported if not _follows(mistake, replaced)]
            for mistake in new:
                by_key.setdefault(mistake.key or "", mistake)
            missing += [detail["loc"]] * (detail["type"] == "missing" and bool(new))
        if example is None or sum(_mend(*pair, mended, model, valid, replaced) for pair in mistakes) < len(mistakes):
            break
        try:
            model.model_validate(mended)
            break
        except ValidationError as next_error:
            error = next_error
        if error.error_count() > MOST:
            break
    if (filled := _whole(missing, mended, model, first)) is not None:
        return InputErrors([*by_key.values()], commented(filled, model, hints={}), whole=True)
    paste = _paste(missing, model, first, valid)
    return InputErrors([*by_key.values()], paste) if len(by_key) > 1 or paste else next(iter(by_key.values()))


def _of_another_kind(document: Mapping[str, Any], model: Model, file: str | None) -> InputError | None:
    """Return the error for a file of another kind than the model's, such as a mission; None for the right kind."""
    (wanted,) = [kind for kind, (keys, _) in KINDS.items() if keys <= {*_keys(model)}] or [""]
    for kind, (keys, fix) in KINDS.items():
        if wanted not in ("", kind) and keys & document.keys() and not KINDS[wanted][0] & document.keys():
            return InputError(f"is {kind}, not {wanted}", file=file or "the file", fix=fix.format(file=file or "FILE"))
    return None


def _in_order(error: ValidationError) -> list[Any]:
    """Return pydantic's errors, without consequences of others; unknown keys come first, since these explain others."""
    errors = [one for one in error.errors(include_url=False) if one["type"] != "default_factory_not_called"]
    bad = {one["loc"][:n] for one in errors for n in range(len(one["loc"]))}
    errors = [one for one in errors if one["type"] != "too_short" or one["loc"] not in bad]  # only good items count
    return sorted(errors, key=lambda one: one["type"] != "extra_forbidden")[:MOST]


def _mistakes(item: Any, document: Any, model: Model, file: str | None) -> list[InputError]:
    """Return the mistakes of the file for one of pydantic's errors."""
    place, cause = item["loc"], item.get("ctx", {}).get("error")
    if isinstance(cause, InputError):
        errors = cause.errors if isinstance(cause, InputErrors) else (cause,)
        owner, _ = field_at(model, place)
        table = getattr(owner, "table", "") if place else ""
        return [
            InputError(e.rule, file=file, key=_placed(e.key or "", table, place), value=e.value, fix=e.fix)
            for e in errors
        ]
    key = written(place)
    owner, field = field_at(model, place)
    if item["type"] == "extra_forbidden":
        owner, _ = field_at(model, place[:-1])
        if new_name := getattr(owner, "renamed", {}).get(place[-1]):
            return [InputError("was renamed", file=file, key=key, fix=f"write {new_name}")]
        fix = did_you_mean(str(place[-1]), _keys(owner))
        return [InputError("is not a known key", file=file, key=key, fix=fix)]
    if item["type"] == "missing":
        misspelled = _meant(_value_at(document, place[:-1]), field_at(model, place[:-1])[0]).values()
        return [] if place[-1] in misspelled else [InputError("is missing", file=file, key=key, fix=fix_of(field))]
    return [
        InputError(rule_of(item["msg"]), file=file, key=key, value=shown(_value_at(document, place)), fix=fix_of(field))
    ]


def _placed(key: str, table: str, place: Place) -> str:
    """Return a key with the indices of its table's place: joints[0].line.bore_m for joints.line.bore_m."""
    return f"{written(place)}{key.removeprefix(table)}" if table and key.startswith(table) else key


def _follows(mistake: InputError, replaced: list[str]) -> bool:
    """Return whether a mistake may be due to a replaced value: its own value, or one that its rule names."""
    key = mistake.key or ""
    return any(
        key.startswith(other) or other.startswith(key) or re.split(r"[.\[]", other)[-1] in mistake.rule
        for other in replaced
    )


def _mend(item: Any, reported: list[InputError], document: Any, model: Model, valid: Any, replaced: list[str]) -> bool:
    """Mend a document at one of pydantic's errors; return whether this was possible. `replaced` collects the keys."""
    place = item["loc"]
    owner = _value_at(document, place[:-1])
    if isinstance(item.get("ctx", {}).get("error"), InputError):
        if not place:
            return False
        keys = [_place(error.key or "") for error in reported]
        if any(written(key) in replaced for key in keys):
            keys = [place]  # replace the whole table
        return sum(_replace(key, document, valid, replaced) for key in keys) == len(keys)
    if item["type"] == "extra_forbidden":
        if isinstance(owner, dict) and place[-1] in owner:
            intended = _meant(owner, field_at(model, place[:-1])[0]).get(place[-1])
            value = owner.pop(place[-1])
            if intended is not None:
                owner[intended] = value
        return True
    if item["type"] == "missing" and isinstance(owner, dict) and place[-1] in owner:
        return True  # a misspelled key that is already corrected
    return _replace(place, document, valid, replaced)


def _replace(place: Place, document: Any, valid: Any, replaced: list[str]) -> bool:
    """Replace a value, or a whole list of numbers, by the example's; return whether the document has the place."""
    while isinstance(place[-1], int) and not isinstance(_value_at(valid, place), Mapping):
        place = place[:-1]
    replaced.append(written(place))
    return _put(document, place, _value_at(valid, place))


def _place(key: str) -> Place:
    """Return the place of a key such as ``joints[0].links[2]``: its names and indices."""
    parts = re.findall(r'"([^"]*)"|\[(\d+)\]|([^.\[\]"]+)', key)
    return tuple(int(index) if index else quoted or plain for quoted, index, plain in parts)


def _put(document: Any, place: Place, value: Any) -> bool:
    """Put a value at a place of a document, or remove it if None; return whether the document has the place."""
    owner = _value_at(document, place[:-1])
    if isinstance(owner, dict):
        owner.pop(place[-1], None)
        if value is not None:
            owner[place[-1]] = copy.deepcopy(value)
        return True
    if isinstance(owner, list) and isinstance(place[-1], int) and value is not None:
        owner[place[-1]] = copy.deepcopy(value)
        return True
    return False


def _value_at(value: Any, place: Place) -> Any:
    """Return the value at a place; None if there is none; the last one of a list that is too short."""
    for part in place:
        if isinstance(value, Mapping):
            value = value.get(part)
        elif isinstance(value, list) and isinstance(part, int) and value:
            value = value[min(part, len(value) - 1)]
        else:
            return None
    return value


def _keys(owner: Model | None) -> list[str]:
    """Return the keys of a model as in the file; none without a model."""
    return [info.alias or name for name, info in owner.model_fields.items()] if owner else []


def _meant(table: Any, owner: Model | None) -> dict[str, str]:
    """Return for each unknown key of a table the absent key that was likely meant."""
    if not isinstance(table, Mapping) or len(table) > MOST:
        return {}
    known_keys = _keys(owner)
    renamed = getattr(owner, "renamed", {})
    close = {key: difflib.get_close_matches(key, known_keys, n=1) for key in table if key not in known_keys}
    close |= {key: [renamed[key]] for key in close if key in renamed}
    return {key: matches[0] for key, matches in close.items() if matches and matches[0] not in table}


def _spelled(table: Mapping[str, Any], model: Model, place: Place = ()) -> dict[str, Any]:
    """Return a document with its unknown keys replaced by the keys that were likely meant."""
    meant = _meant(table, field_at(model, place)[0])
    keys = {key: meant.get(key, key) for key in table}
    return {
        keys[key]: _spelled(value, model, (*place, keys[key])) if isinstance(value, Mapping) else value
        for key, value in table.items()
    }


def _whole(missing: list[Place], mended: Any, model: Model, first: dict[str, Any]) -> dict[str, Any] | None:
    """Return a nearly empty document completed from an example; None for other documents."""
    if not first or not {("links",), ("joints",), ("water",)} & {*missing} or not mended.keys() <= first.keys():
        return None
    filled = copy.deepcopy(mended)
    for place in missing:
        _put(filled, place, _value_at(first, place))
    result = {key: filled.get(key, value) for key, value in first.items() if key not in ABOUT or key in filled}
    result["water"] = first["water"] | result["water"]  # the document may have only a density
    try:
        model.model_validate(result)
    except ValidationError:
        return None
    return result


def _paste(missing: list[Place], model: Model, first: Mapping[str, Any], valid: Mapping[str, Any]) -> str:
    """Return the missing keys as TOML text, with an example's values."""
    parts: dict[str, dict[str, Any]] = {}
    for place in missing:
        value = _value_at(first, place) or _value_at(valid, place)
        if value is None or isinstance(place[-1], int):  # an item of a list has no key
            continue
        names = [part for part in place[:-1] if isinstance(part, str)]
        index = next((part for part in reversed(place) if isinstance(part, int)), None)
        comment = "" if index is None else f"# into [[{place[0]}]] number {index + 1}\n"
        nested: Any = {place[-1]: value}
        for name in reversed(names):
            nested = {name: nested}
        _merge(parts.setdefault(comment, {}), nested)
    texts = []
    for comment, document in sorted(parts.items()):
        text = commented(document, model, hints={})
        texts.append(comment + (re.sub(r"^\[joints\]\n", "", text) if comment else text))
    return "\n".join(texts)


def _merge(whole: dict[str, Any], part: Mapping[str, Any]) -> None:
    """Merge a document into another, in place."""
    for key, value in part.items():
        if isinstance(value, Mapping) and isinstance(whole.get(key), dict):
            _merge(whole[key], value)
        else:
            whole[key] = value
