"""A random sample of canwire's texts for a reader to judge: `python -m tests.language.sample SEED [COUNT]`.

Prints COUNT (100) sentences of the documentation, as many docstrings of public names and as many messages, each with
its place. The same seed and the same texts give the same sample.
"""

from __future__ import annotations

import random
import sys
from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from pathlib import Path

from tests.language.texts import Text, docstrings, messages, pages, sentences, sources


def draw(seed: int, count: int) -> Iterator[tuple[str, list[Text]]]:
    """Each kind of text with COUNT drawn ones, in the order of their places."""
    python = [path for path in sources() if path.suffix == ".py"]
    kinds: tuple[tuple[str, Callable[[Path], Iterable[Text]], list[Path]], ...] = (
        ("sentences", sentences, pages()),
        ("docstrings", docstrings, python),
        ("messages", messages, python),
    )
    for name, read, paths in kinds:
        texts = list(chain.from_iterable(map(read, paths)))
        yield name, sorted(random.Random(f"{seed} {name}").sample(texts, count))


def main() -> None:
    """Prints the sample."""
    seed = int(sys.argv[1])
    count = int(sys.argv[2]) if len(sys.argv) > 2 else 100
    for name, texts in draw(seed, count):
        print(f"# {count} {name}, seed {seed}\n", *texts, sep="\n", end="\n\n")


if __name__ == "__main__":
    main()
