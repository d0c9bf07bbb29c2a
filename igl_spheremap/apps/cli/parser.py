"""The parser of command lines, made from the table of commands. A wrong line is refused at once."""

import sys
from argparse import Action, ArgumentError, ArgumentParser, Namespace, RawDescriptionHelpFormatter
from collections.abc import Collection, Iterable, Iterator
from typing import Any, NoReturn

from ... import samples
from ..._version import __version__
from ...errors import import_optional
from ...io.formats import FORMATS
from .arguments import check_companions
from .exits import UsageError, status_help
from .table import COMMANDS, GROUPS


class _ByGroup(RawDescriptionHelpFormatter):
    """Help that lists the commands by subject."""

    def _format_action(self, action: Action) -> str:
        lines_of = super()._format_action
        if action.dest != "command":
            return lines_of(action)
        rows = {row.dest: row for row in action._get_subactions()}  # type: ignore[attr-defined]
        lines = []
        for title, names in GROUPS.items():
            lines += [f"\n  {title}:\n", *(f"  {lines_of(rows[name])}" for name in names)]
        return "".join(lines)


class _Completion(Action):
    """Print the completion of command lines for a shell."""

    def __call__(self, parser: ArgumentParser, _: Namespace, shell: Any, *__: Any) -> None:
        shtab = import_optional("shtab", "completion")
        if shell not in shtab.SUPPORTED_SHELLS:
            parser.error(f"shtab knows no {shell}; give one of {', '.join(shtab.SUPPORTED_SHELLS)}")
        parser._print_message(shtab.complete(build_parser(), shell), sys.stdout)
        parser.exit()


_COMMANDS = [command.name for command in COMMANDS]
#: Flags that stand before a command.
_GENERAL = ["--help", "--version", "-h", "--completion"]
#: Names of OUT in other programs.
_OUT = ("-o", "--out", "--output")


def _near(word: str, names: list[str]) -> list[str]:
    """The name, if any, that may have been meant by a word."""
    from difflib import get_close_matches  # only wrong lines need it

    return get_close_matches(word, names, n=1)


def _meant(names: list[str]) -> str:
    """The question whether one of these names was meant."""
    return "".join(f"; did you mean {name}?" for name in names)


def _alike(first: str) -> list[str]:
    """The likely meaning of the first word of a line, which is no command and no flag."""
    if first.startswith("-"):
        return _near(first, _GENERAL)
    if "." in first or ":" in first:
        return [f"map {first} OUT"]
    return _near(first, _COMMANDS)


def _hint(unknown: list[str], args: Namespace) -> str:
    """The likely meaning of words that a command does not take."""
    arguments = [names for names, _ in args.row.arguments]
    flag = unknown[0].partition("=")[0]
    if flag in _OUT and ["target"] in [[*names] for names in arguments]:
        return "; OUT is the second name of a line, without a flag"
    if not flag.startswith("-"):
        return "; it takes fewer names: put one with spaces in quotes; batch takes many files"
    return _meant(_near(flag, [name for names in arguments for name in names if name[:2] == "--"]))


class _Parser(ArgumentParser):
    """A parser that raises its failures: wrong usage, and help that its stream can't take."""

    def error(self, message: str) -> NoReturn:
        _, found, missing = message.partition("arguments are required: ")
        if found:
            message = f"{self.prog.split()[-1]} needs {missing}"
        raise UsageError(f"{message} (see {self.prog} --help)")

    def parse(self, words: list[str]) -> Namespace:
        """Parse a command line; a UsageError names the likely meaning of an unknown command or flag."""
        if words[0] == "help":
            words = [*words[1:], "--help"]
        first = words[0]
        if first not in (*_COMMANDS, *_GENERAL):
            kind = "command"
            if first.startswith("-"):
                kind = "flag"
            raise UsageError(
                f"there is no {kind} {first!r}{_meant(_alike(first))} (see {self.prog} --help)"
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

    def _check_value(self, action: Action, value: Any) -> None:
        if action.choices is not None and value not in action.choices:
            names = [str(choice) for choice in action.choices]
            hint = f"; choose from {', '.join(names)}"
            if near := _near(str(value), names):
                hint = _meant(near)
            raise ArgumentError(action, f"there is no {value}{hint}")

    def _match_argument(self, action: Action, pattern: str) -> int:
        try:
            return super()._match_argument(action, pattern)
        except ArgumentError:
            if not action.option_strings:
                raise
            wanted = self._get_formatter()._format_args(action, str(action.dest).upper())
            raise ArgumentError(action, f"it takes {wanted}") from None

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
    parser.add_argument(
        "--completion",
        action=_Completion,
        metavar="SHELL",
        help="print what completes command lines in bash, zsh, tcsh or fish: put it where your shell reads it; "
        "needs `pip install shtab`",
    )
    subparsers = parser.add_subparsers(
        title="commands", dest="command", metavar="COMMAND", required=True, parser_class=_Parser
    )
    for command in COMMANDS:
        subparser = subparsers.add_parser(
            command.name,
            help=command.purpose[0].lower() + command.purpose[1:].rstrip("."),
            description=f"{command.purpose}\n\n{_examples(command.examples)}",
            epilog=status_help(),
            formatter_class=RawDescriptionHelpFormatter,
        )
        subparser.set_defaults(row=command)
        if words is not None and command.name not in words:
            continue
        for names, options in command.arguments:
            own = {name: value for name, value in options.items() if name != "goes_with"}
            subparser.add_argument(*names, **own)
        subparser.usage = f"%(prog)s [options] {' '.join(_placed(subparser))}"
    return parser


def _placed(parser: ArgumentParser) -> Iterator[str]:
    """The names of a command line, as its usage shows them."""
    formatter = parser._get_formatter()
    for action in parser._get_positional_actions():
        yield formatter._format_args(action, str(action.dest))


def _examples(lines: Iterable[str]) -> str:
    return "examples:\n" + "".join(f"  {line}\n" for line in lines)
