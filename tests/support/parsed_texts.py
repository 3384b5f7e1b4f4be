"""What a parser makes of a text, and what it says of a wrong one."""

import pytest

from graph.base.errors import UserError
from graph.files.source import Source


def reading(parse, name):
    """Two functions of a text of a file of this name: its tree with the problems found, and the one that refuses it."""

    def tree(text):
        problems = []
        root, _ = parse(Source(name, text), problems)
        return root, [str(problem) for problem in problems]

    def only_problem(text):
        with pytest.raises(UserError) as caught:
            tree(text)
        [problem] = caught.value.problems
        return str(problem)

    return tree, only_problem
