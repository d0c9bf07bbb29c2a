"""The parser of command lines, made from the table of commands. A wrong line is refused at once."""

import sys
from argparse import Action, ArgumentParser, Namespace, RawDescriptionHelpFormatter
from collections.abc import Collection, Iterable
from typing import Any, NoReturn

from ... import samples
from ..._version import __version__
from ...io.formats import FORMATS
from .arguments import check_companions
from .exits import UsageError, status_help
from .table import COMMANDS, GROUPS


class _ByGroup(RawDescriptionHelpFormatter):
    """Help that lists the commands under what they are about."""

    def _format_action(self, action: Action) -> str:
        lines_of = super()._format_action
        if action.dest != "command":
            return lines_of(action)
        rows = {row.dest: row for row in action._get_subactions()}  # type: ignore[attr-defined]
        lines = []
        for title, names in GROUPS.items():
            lines += [f"\n  {title}:\n", *(f"  {lines_of(rows[name])}" for name in names)]
        return "".join(lines)


_COMMANDS = [command.name for command in COMMANDS]
#: Flags that stand before a command.
_GENERAL = ["--help", "--version", "-h"]
#: What other programs call OUT.
_OUT = ("-o", "--out", "--output")


def _near(word: str, names: list[str]) -> list[str]:
    """The name that may have been meant by a word, if there is one."""
    from difflib import get_close_matches  # only wrong lines need it

    return get_close_matches(word, names, n=1)


def _meant(names: list[str]) -> str:
    """The question whether one of these names was meant."""
    return "".join(f"; did you mean {name}?" for name in names)


def _is_known(first: str) -> bool:
    """Whether a line may begin with this word."""
    return first in _COMMANDS or first in _GENERAL


def _kind(word: str) -> str:
    """What a word is by its first letter."""
    if word.startswith("-"):
        return "flag"
    return "command"


def _alike(first: str) -> list[str]:
    """What may have been meant by the first word of a line, which is no command and no flag."""
    if first.startswith("-"):
        return _near(first, _GENERAL)
    if "." in first or ":" in first:
        return [f"map {first} OUT"]
    return _near(first, _COMMANDS)


def _hint(unknown: list[str], args: Namespace) -> str:
    """What may have been meant by words that a command does not take."""
    arguments = [names for names, _ in args.row.arguments]
    flag = unknown[0].partition("=")[0]
    if flag in _OUT and ["target"] in [[*names] for names in arguments]:
        return "; OUT is the second name of a line, without a flag"
    if not flag.startswith("-"):
        return "; it takes fewer names: put one with spaces in quotes; batch takes many files"
    return _meant(_near(flag, [name for names in arguments for name in names if name[:2] == "--"]))


class _Parser(ArgumentParser):
    """A parser that raises what goes wrong: wrong usage, and help that its stream can't take."""

    def error(self, message: str) -> NoReturn:
        _, found, missing = message.partition("arguments are required: ")
        if found and "-" not in missing:
            names = [str(each.metavar) for each in self._get_positional_actions() if each.required]
            missing = str(missing.count(",") + 1)
            message = f"{' '.join(names)} are needed; missing: {missing}"
        raise UsageError(f"{message} (see {self.prog} --help)")

    def parse(self, words: list[str]) -> Namespace:
        """Parse a command line; a UsageError names what may have been meant by an unknown command or flag."""
        if words[0] == "help":
            words = [*words[1:], "--help"]
        first = words[0]
        if not _is_known(first):
            raise UsageError(
                f"there is no {_kind(first)} {first!r}{_meant(_alike(first))} (see {self.prog} --help)"
            )
        if "" in words:  # as a path it would be the working folder
            raise UsageError(
                f"argument {words.index('')} of {first} is empty: a variable of the shell may be unset"
            )
        args, unknown = self.parse_known_args(words)
        if unknown:
            raise UsageError(
                f"{args.command} takes no {unknown[0]}{_hint(unknown, args)} "
                f"(see {self.prog} {args.command} --help)"
            )
        check_companions(args)
        return args

    # argparse's own hides OSErrors
    def _print_message(self, message: str, file: Any = None) -> None:
        if file is None:
            file = sys.stderr
        file.write(message)


def build_parser(words: Collection[str] | None = None) -> _Parser:
    """The parser of the command line; with its words, commands not among them get no arguments, which takes time."""
    suffixes = " ".join(
        suffix for entry in FORMATS if entry.name != "FreeSurfer" for suffix in entry.suffixes
    )
    firsts = [
        command for first, *_ in GROUPS.values() for command in COMMANDS if command.name == first
    ]
    parser = _Parser(
        prog="igl-spheremap",
        description="Conformal maps of genus-0 meshes to the unit sphere, proved free of foldings.",
        epilog=f"{_examples(command.examples[0] for command in firsts)}\nfiles:\n"
        f"  {suffixes} and FreeSurfer's (lh.pial, lh.sphere.conformal);\n"
        "  sample:NAME[:key=value,...] is a shape that the package makes itself, NAME one of\n"
        f"  {', '.join(samples.names())}\n\n{status_help()}",
        formatter_class=_ByGroup,
    )
    parser.add_argument("--version", action="version", version=f"igl-spheremap {__version__}")
    subparsers = parser.add_subparsers(
        title="commands", dest="command", metavar="COMMAND", required=True, parser_class=_Parser
    )
    for command in COMMANDS:
        subparser = subparsers.add_parser(
            command.name,
            help=command.purpose[0].lower() + command.purpose[1:].rstrip("."),
            description=command.purpose,
            epilog=f"{_examples(command.examples)}\n{status_help()}",
            formatter_class=RawDescriptionHelpFormatter,
        )
        subparser.set_defaults(row=command)
        if words is not None and command.name not in words:
            continue
        for names, options in command.arguments:
            own = {name: value for name, value in options.items() if name != "goes_with"}
            subparser.add_argument(*names, **own)
    return parser


def _examples(lines: Iterable[str]) -> str:
    return "examples:\n" + "".join(f"  {line}\n" for line in lines)
