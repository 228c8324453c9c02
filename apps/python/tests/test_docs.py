"""Every public name has a docstring; its examples run."""

import doctest

import pytest
import starbreak


def documented():
    for name in starbreak.__all__:
        value = getattr(starbreak, name)
        if isinstance(value, str):
            continue
        yield name, value
        if isinstance(value, type):
            for member, inside in sorted(vars(value).items()):
                if not member.startswith("_"):
                    yield f"{name}.{member}", getattr(inside, "__func__", inside)


@pytest.mark.parametrize(("name", "value"), list(documented()), ids=lambda value: value if isinstance(value, str) else "")
def test_docstring_and_its_examples(name, value):
    text = value.__doc__
    assert text and text.strip(), name
    example = doctest.DocTestParser().get_doctest(text, {}, name, None, None)
    said = []
    failed = doctest.DocTestRunner().run(example, out=said.append).failed
    assert failed == 0, "".join(said)


@pytest.mark.parametrize("name", ["crack", "simulate", "corrupt", "Recipe", "CrackNetwork", "ReadyCrack", "item_seed"])
def test_what_users_begin_with_has_an_example(name):
    assert ">>> " in getattr(starbreak, name).__doc__
