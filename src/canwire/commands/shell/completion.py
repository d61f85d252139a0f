"""`canwire completion`: what a shell needs to complete canwire's verbs and options.

canwire completion bash >> ~/.bashrc        or eval "$(canwire completion bash)" for this shell alone
canwire completion zsh >> ~/.zshrc
canwire completion fish > ~/.config/fish/completions/canwire.fish

Needs canwire[tools] (argcomplete).
"""

from __future__ import annotations

import argparse

from canwire import ExtraMissing

SHELLS = ("bash", "zsh", "fish")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the verb's arguments."""
    parser.add_argument("shell", metavar="SHELL", choices=SHELLS, help=", ".join(SHELLS))


def run(arguments: argparse.Namespace) -> int:
    """Print the shell's code; raises ExtraMissing without argcomplete."""
    try:
        from argcomplete.shell_integration import shellcode
    except ModuleNotFoundError:
        raise ExtraMissing("argcomplete", "tools") from None
    print(shellcode(["canwire"], shell=arguments.shell))
    return 0


def answer(parser: argparse.ArgumentParser) -> None:
    """Answer a shell's request for completions, then exit. Without argcomplete, do nothing."""
    try:
        import argcomplete
    except ModuleNotFoundError:
        return
    argcomplete.autocomplete(parser)
