"""Parsing of a command's arguments: all missing options in one error, wrong ones with their fix, help in panels."""

from __future__ import annotations

import difflib
import pkgutil
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from hypertuna.errors import InputError, did_you_mean
from hypertuna.io.quantity import listed

UsageError: Any = typer.BadParameter.__mro__[1]  # base class of all errors of typer's parser
Table = Mapping[str, tuple[Any, str]]  # command -> (function or group in hypertuna.cli, or a table; line in help)

# Panels of options in a command's help: title -> names of the parameters that it lists.
PANELS = {
    "Robot": ("robot", "changes", "joints", "areas", "water"),
    "Gait": ("gait", "frequency", "amplitude", "phase", "bias"),
    "Output": ("plot", "output", "report", "gpx", "log", "black_box", "checkpoint", "no_pictures", "as_json", "help"),
}


class _ParserBase:
    """Base of commands and groups: turns the parser's errors into one sentence with its fix, and writes the help."""

    def parse_args(self, context: Any, args: list[str]) -> list[str]:
        """Parse the arguments; raise InputError for unknown, repeated and missing options."""
        typed = list(args)
        _check_words(self, context, typed)
        try:
            unparsed: list[str] = super().parse_args(context, args)  # type: ignore[misc]  # of typer's class
        except UsageError as error:
            if type(error).__name__ == "NoArgsIsHelpError":
                typer.echo(context.get_help(), err=True)
                raise typer.Exit(2) from None
            raise _explained(error, self, context, typed) from None
        _check_once(self, context, typed)
        return unparsed

    def get_help_option(self, context: Any) -> Any:
        """Return the option --help with the default False: to read the default None, typer would import pydantic."""
        option = super().get_help_option(context)  # type: ignore[misc]  # of typer's class, mixed in below
        if option is not None:
            option.default = False
            option.help = "Show this help and exit."
        return option

    def format_panels(self, context: Any, formatter: Any) -> None:
        """Write the options into the help, in panels."""
        home = {name: title for title, names in PANELS.items() for name in names}
        panels: dict[str, list[Any]] = {"Arguments": [], "Robot": [], "Gait": [], "Options": [], "Output": []}
        params: list[Any] = self.get_params(context)  # type: ignore[attr-defined]  # of typer's class, as above
        for param in params:
            if (record := param.get_help_record(context)) is not None:
                title = "Arguments" if param.param_type_name == "argument" else home.get(param.name or "", "Options")
                names, meaning = record
                panels[title].append((re.sub(r" <\S+>$", "", names), meaning))  # drops Python's name of the type
        for title, rows in panels.items():
            if rows:
                with formatter.section(title):
                    formatter.write_dl(rows)


class Command(_ParserBase, TyperCommand):
    """A command."""

    allow_extra_args = True  # checked in parse_args

    def parse_args(self, context: Any, args: list[str]) -> list[str]:
        """Read the arguments; refuse words that no option takes."""
        unparsed = super().parse_args(context, args)
        if unparsed and not context.resilient_parsing:
            raise _stray(unparsed[0], _name(context))
        return unparsed

    def format_options(self, context: Any, formatter: Any) -> None:
        """Write the options into the help."""
        self.format_panels(context, formatter)


class Group(_ParserBase, TyperGroup):
    """A group of commands."""

    def resolve_command(self, context: Any, args: list[str]) -> Any:
        """Return the command that the arguments name by their first word, or by the first two."""
        if " ".join(args[:2]) in self.commands:
            args = [" ".join(args[:2]), *args[2:]]
        if args[0] not in self.commands and not context.resilient_parsing:
            name = _name(context)
            fix = did_you_mean(args[0], self.commands)
            fix = fix if fix.endswith("?") else f"`{name} --help` lists the commands"
            if "." in args[0] and "info" in self.commands:
                fix = f"did you mean `{name} info {args[0]}`?"
            raise InputError(f"is not a command of `{name}`", key=args[0], fix=fix)
        return super().resolve_command(context, args)

    def format_options(self, context: Any, formatter: Any) -> None:
        """Write options and commands into the help; a group that is itself a command shows its options in panels."""
        if self.invoke_without_command and len(self.params) > 1:
            self.format_panels(context, formatter)
            self.format_commands(context, formatter)
        else:
            super().format_options(context, formatter)

    def format_commands(self, context: Any, formatter: Any) -> None:
        """Write the commands into the help, with the first paragraph of each."""
        lines = {name: self.commands[name].help or "" for name in self.list_commands(context)}
        with formatter.section("Commands"):
            formatter.write_dl([(name, " ".join(line.split("\n\n")[0].split())) for name, line in lines.items()])


class TableGroup(Group):
    """A group of commands from tables, each a panel of the help; the help lists them without importing them."""

    def __init__(self, *, panels: Mapping[str, Table], **options: Any) -> None:
        super().__init__(**options)
        self.panels = panels
        self.commands: Any = _Commands({name: row for table in panels.values() for name, row in table.items()})

    def list_commands(self, _: Any) -> list[str]:
        """List the names of the commands of one word; two words, such as "mission new", are commands below these."""
        return [name for name in self.commands if " " not in name]

    def format_commands(self, _: Any, formatter: Any) -> None:
        """Write the commands into the help, in panels."""
        width = max(map(len, self.commands))
        for title, table in self.panels.items():
            with formatter.section(title):
                formatter.write_dl([(f"{name:{width}}", line) for name, (_, line) in table.items()])


class _Commands(Mapping[str, Any]):
    """Mapping of names to the commands of a table, each imported at its first use."""

    def __init__(self, table: Table) -> None:
        self.table = table

    def __getitem__(self, name: str) -> Any:
        place, line = self.table[name]
        if isinstance(place, Mapping):
            return TableGroup(
                name=name, help=line, panels={"Commands": place}, no_args_is_help=True, rich_markup_mode=None
            )
        target = pkgutil.resolve_name(f"hypertuna.cli.{place}")
        if not isinstance(target, typer.Typer):
            function, target = target, typer.Typer(add_completion=False, rich_markup_mode=None)
            target.command(name, cls=Command)(function)
        command: Any = get_command(target)
        command.name = name
        return command

    def __iter__(self) -> Iterator[str]:
        return iter(self.table)

    def __len__(self) -> int:
        return len(self.table)


class App(typer.Typer):
    """A group of commands whose functions are already imported."""

    def __init__(self, **options: Any) -> None:
        options = {"cls": Group} | options
        super().__init__(add_completion=False, rich_markup_mode=None, **options)

    def command(  # type: ignore[override]  # takes fewer options than typer's
        self, name: str | None = None, **options: Any
    ) -> Callable[[Callable[..., None]], Callable[..., None]]:
        """Add a command."""
        return super().command(name, **({"cls": Command} | options))


def _check_words(command: Any, context: Any, args: Sequence[str]) -> None:
    """Check that long options have two dashes, and that no option stands where the value of another belongs."""
    options = {name: param for param in command.get_params(context) for name in param.opts}
    for word, following in pairwise([*args, ""]):
        if word == "--" or context.resilient_parsing:
            return
        if not word.startswith("--") and f"-{word.partition('=')[0]}" in options:
            raise _no_option(word, _name(context), f"did you mean -{word}?")
        param = options.get(word)
        if param and not getattr(param, "is_flag", True) and following.partition("=")[0] in options:
            raise InputError("needs a value", key=word, fix=f"write {word} {param.metavar or 'VALUE'}")


def _no_option(word: str, name: str, fix: str) -> InputError:
    """Return the error for an option that a command does not have."""
    return InputError(f"is not an option of `{name}`", key=word, fix=fix)


def _check_once(command: Any, context: Any, args: list[str]) -> None:
    """Check that no option that takes one value is given twice."""
    if context.resilient_parsing:
        return
    _, _, order = command.make_parser(context).parse_args(args=list(args))
    for param in order:
        single = param.param_type_name == "option" and not (param.multiple or param.is_flag or param.count)
        if single and sum(other is param for other in order) > 1:
            raise InputError("must be given once", key=max(param.opts, key=len), fix="remove all but one")


def _name(context: Any) -> str:
    """Return the words of the command that a parser's context belongs to, such as "hypertuna joint fit"."""
    names: list[str] = []
    while context is not None and context.parent is not None:
        names, context = [context.info_name, *names], context.parent
    return " ".join(["hypertuna", *names])


def _explained(error: Any, command: Any, context: Any, args: list[str]) -> InputError:
    """Return the InputError for an error of the parser, with its fix."""
    kind, name = type(error).__name__, _name(context)
    if kind == "MissingParameter":
        needed = listed([_asked_for(param) for param in _missing(command, context, args)])
        return InputError(f"needs {needed}", key=f"`{name}`")
    if kind == "NoSuchOption":
        word = next((word for word in args if word.startswith(error.option_name)), error.option_name).partition("=")[0]
        dashed = f"--{word.lstrip('-')}"
        choices = [option for param in command.get_params(context) for option in param.opts if option.startswith("--")]
        near = difflib.get_close_matches(dashed, choices, n=1)
        longer = [option for option in choices if option.startswith(dashed)]
        fix = f"did you mean {(longer or near)[0]}?" if longer or near else f"`{name} --help` lists the options"
        if dashed == "--robot" and any(param.name == "robot" for param in command.get_params(context)):
            fix = f"write the robot alone, such as `{name} hypertuna`"
        if context.parent is None:
            fix = f"write options after a command, such as `hypertuna swim {dashed} ...`"
            fix = "did you mean --version?" if word.lower() == "-v" else fix
        return _no_option(word, name, fix)
    if kind == "BadOptionUsage":
        param = next((param for param in command.get_params(context) if error.option_name in param.opts), None)
        takes = f"write {error.option_name} {param.metavar or 'VALUE'}" if param is not None else ""
        flag = param is not None and getattr(param, "is_flag", False)
        rule, fix = ("takes no value", f"write {error.option_name} alone") if flag else ("needs a value", takes)
        return InputError(rule, key=error.option_name, fix=fix)
    return InputError(error.format_message().rstrip("."), fix=f"see `{name} --help`")


def _missing(command: Any, context: Any, args: list[str]) -> Iterator[Any]:
    """Yield the required parameters that the arguments lack."""
    given, rest, _ = command.make_parser(context).parse_args(args=args)
    for param in command.get_params(context):
        try:
            _, rest = param.handle_parse_result(context, given, rest)
        except UsageError as error:
            if type(error).__name__ == "MissingParameter":
                yield param
        except InputError:  # the parameter is given, but its value is wrong
            continue


def _asked_for(param: Any) -> str:
    """Return the text of a parameter in an error: its name, the form of its value, and the start of its help."""
    sentence = (param.help or "").removesuffix(".").split(". ")[0]
    shape = param.metavar or (param.name or "value").upper()
    name = f"{max(param.opts, key=len)} {shape}" if param.param_type_name == "option" else shape
    text = f"{sentence[:1].lower()}{sentence[1:]}" if sentence[1:2].islower() else sentence
    return f"{name} ({text})" if text else name


def _stray(word: str, name: str) -> InputError:
    """Return the error for a word that no option takes."""
    from hypertuna.description.robot import robots

    if word.endswith(".toml") or word in robots():
        return InputError("is not expected here", key=word, fix=f"give the robot as an option, `{name} --robot {word}`")
    if all(part.removeprefix("-").replace(".", "", 1).isdigit() for part in word.split(",")):
        fix = "separate the values of an option by commas, without spaces, such as --amplitude 16,25"
        return InputError("is not expected here", key=word, fix=fix)
    return InputError("is not expected here", key=word, fix=f"leave it out, or see `{name} --help`")
