"""Runs what the pages tell a reader to run: every command of README.md and of the pages in docs.

    run_commands.py STARBREAK [--inputs DIR] [--keep DIR] [PAGE…]

STARBREAK is the command to run; without a PAGE all are run, but docs/decisions. Each page has a scratch
folder of its own. Of its blocks in sh and console, in their order,

- a command of starbreak, and `python3 -c`, is run by `sh -e` and has to end with 0. What it reads and no
  earlier command made comes from a small made-up world (made_up_inputs.py), or from DIR where DIR has that
  name. What it writes is removed before: the lines of a block are mostly alternatives that write to one
  name. Numbers that take long are made small, see REDUCED;
- any other command is listed as not run, and has to name files, tasks and steps that the repository has.

A block after a line `<!-- not run: REASON -->` is not run, and listed. Blocks in python are run page by
page where the package is importable here, unless a test does (TESTED). Commands within a sentence are
mostly mentions, without all that they need: of these only the verb, the flags and the files, tasks and
steps are looked up.

Ends with 1 and the list of what failed, if anything did.
"""

from __future__ import annotations

import argparse
import dataclasses
import importlib.util
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time

from made_up_inputs import World

PROJECT = pathlib.Path(__file__).resolve().parents[1]

#: What is made small, so that all pages take a few minutes: what a command has, and what is run.
REDUCED = [
    (r"^starbreak patterns (.*)-n \d+", r"starbreak patterns \1-n 10"),
    (r"^starbreak bench (?!.*--runs)", "starbreak bench --runs 1 "),
    (r"--runs \d+", "--runs 1"),
    (r"--particles [\d,]+", "--particles 1000"),
    (r"--set fracture\.particles=\d{5,}", "--set fracture.particles=5000"),
    (r"--regenerate \d+", "--regenerate 2"),
    (r"^starbreak study (.*)--severities [\d,]+", r"starbreak study --replicates 100 \1--severities 1,3"),
    (r"^starbreak divergence (?=.*(clean=|--simulated))", "starbreak divergence --permutations 99 --bootstrap 100 "),
]

#: Pages whose Python a test runs.
TESTED = {
    "README.md": "apps/python/tests/test_examples.py",
    "docs/live.md": "apps/python/tests/test_examples.py",
    "docs/python.md": "apps/python/tests/test_examples.py",
    "docs/python-pipelines.md": "apps/python/tests/test_pipelines.py",
}

#: Longest time of one command.
LIMIT_S = 300

NOT_RUN = re.compile(r"<!-- not run: (.+?) -->")
OUTPUT_FLAGS = {"-o", "--output", "--svg", "--frames-to", "--masks", "--curves", "--video", ">"}
OURS = "starbreak "


@dataclasses.dataclass
class Block:
    """A fenced block: its kind, the number of its first line, its lines, and why it is not run, if so."""

    kind: str
    line: int
    lines: list[str]
    not_run: str | None


def blocks_of(text: str) -> list[Block]:
    """The fenced blocks of a page."""
    blocks, block, last = [], None, ""
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("```"):
            if block is None:
                reason = NOT_RUN.fullmatch(last.strip())
                block = Block(line[3:].strip(), number + 1, [], reason and reason[1])
            else:
                blocks.append(block)
                block = None
        elif block is not None:
            block.lines.append(line)
        last = line
    return blocks


def prose_of(text: str) -> list[tuple[int, str]]:
    """What stands in backticks outside of blocks, with the number of its line."""
    is_code, found = False, []
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("```"):
            is_code = not is_code
        elif not is_code:
            found += [(number, span) for span in re.findall(r"`([^`]+)`", line)]
    return found


def is_whole(command: str) -> bool:
    """Whether it ends here: no quote is open, and no backslash continues it."""
    try:
        shlex.split(command, comments=True)
    except ValueError:
        return False
    return not command.endswith("\\")


def without_comment(command: str) -> str:
    """What stands before its comment."""
    for comment in re.finditer(r"(^|\s+)#", command):
        if is_whole(command[: comment.start()]):
            return command[: comment.start()].strip()
    return command.strip()


def commands_of(block: Block) -> list[tuple[int, str]]:
    """The commands of a block, each with the number of its first line, on one line and without its comment."""
    found, begun, first = [], "", block.line
    for number, line in enumerate(block.lines, block.line):
        if block.kind == "console":
            if not line.startswith("$ "):
                continue
            line = line[2:]
        if not begun:
            first = number
        begun = f"{begun}\n{line}" if begun else line
        if is_whole(begun):
            command = without_comment(re.sub(r"\\\n\s*", "", begun))
            if command:
                found.append((first, command))
            begun = ""
    if begun.strip():
        found.append((first, begun.strip()))
    return found


def outputs_of(command: str) -> list[str]:
    """The names that a command writes."""
    words = shlex.split(command, comments=True)
    return [after for word, after in zip(words, words[1:]) if word in OUTPUT_FLAGS]


class Repository:
    """What pages may name: files, tasks of xtask, steps of the validation, verbs and flags of the command."""

    def __init__(self, starbreak: pathlib.Path) -> None:
        self.starbreak = starbreak
        self.top = {path.name for path in PROJECT.iterdir()} - {"target"}
        usage = (PROJECT / "xtask/src/main.rs").read_text()
        self.tasks = set(re.findall(r"^  ([a-z]+) ", usage, re.M))
        steps = (PROJECT / "validation/run").read_text()
        self.steps = set(re.findall(r"^ *step (\w+) ", steps, re.M))
        self.help = {}

    def wrong(self, command: str) -> str | None:
        """What a command names that is not there, if anything."""
        words = command.split()
        if words[0] == "starbreak":
            return self.wrong_flags(words[1:])
        if words[:2] == ["cargo", "xtask"] and words[2:3] and words[2] not in self.tasks:
            return f"xtask has no task {words[2]}"
        if words[0] == "validation/run":
            for step in words[1:]:
                if re.fullmatch(r"[a-z_]+", step) and step not in self.steps:
                    return f"validation/run has no step {step}"
        for word in words:
            parts = pathlib.PurePosixPath(word).parts
            if len(parts) > 1 and parts[0] in self.top and re.fullmatch(r"[\w./-]+", word):
                if not (PROJECT / word).exists():
                    return f"the repository has no {word}"
        for flag, name in zip(words, words[1:]):
            if flag == "--example" and words[0] == "cargo":
                if not [*PROJECT.glob(f"crates/*/examples/{name}*")]:
                    return f"no crate has an example {name}"
        return None

    def wrong_flags(self, words: list[str]) -> str | None:
        """The verb or flag of a mention that the command does not have."""
        verbs = [word for word in words if re.fullmatch(r"[a-z]+", word)]
        if not verbs:
            return None
        verb = verbs[0]
        if verb not in self.help:
            told = subprocess.run([self.starbreak, "help", verb], capture_output=True, text=True, check=False)
            self.help[verb] = told.stdout if told.returncode == 0 else None
        if self.help[verb] is None:
            return f"starbreak has no verb {verb}"
        known = set(re.findall(r"--?[a-z][a-z-]*", self.help[verb]))
        for word in words:
            flag = re.match(r"--?[a-z][a-z-]*", word)
            if flag and flag[0] not in known:
                return f"starbreak {verb} has no flag {flag[0]}"
        return None


class Run:
    """One run over pages, and what is to be said at its end."""

    def __init__(self, starbreak: pathlib.Path, inputs: pathlib.Path | None, folder: pathlib.Path) -> None:
        self.folder = folder
        self.repository = Repository(starbreak)
        programs = folder / "programs"
        programs.mkdir(parents=True)
        (programs / "starbreak").symlink_to(starbreak)
        # A link would not find the packages of a virtual environment.
        (programs / "python3").write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
        (programs / "python3").chmod(0o755)
        self.environment = {**os.environ, "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}
        self.world = World(folder / "world", inputs, programs, self.environment)
        self.n_run = 0
        self.failed: list[str] = []
        self.not_run: list[tuple[str, str]] = []
        self.reduced: dict[str, str] = {}

    def page(self, page: pathlib.Path) -> None:
        """Runs a page, and says each command."""
        name = str(page.relative_to(PROJECT)) if page.is_relative_to(PROJECT) else page.name
        print(f"== {name}", flush=True)
        text = page.read_text()
        scratch = self.folder / name.replace("/", "-").removesuffix(".md")
        scratch.mkdir()
        (scratch / "docs/figures").mkdir(parents=True)
        for block in blocks_of(text):
            if block.kind in ("sh", "console"):
                for line, command in commands_of(block):
                    self.command(f"{name}:{line}", command, block.not_run, scratch)
        self.python(name, text, scratch)
        for line, span in prose_of(text):
            if span.startswith((OURS, "cargo xtask ", "validation/", "python3 ")):
                if wrong := self.repository.wrong(span):
                    self.fail(f"{name}:{line}", span, wrong)

    def command(self, place: str, command: str, not_run: str | None, scratch: pathlib.Path) -> None:
        """Runs a command, or notes why not."""
        is_ours = command.startswith(OURS) or command.startswith("python3 -c")
        if not_run or not is_ours:
            self.not_run.append((not_run or "no command of starbreak", f"{place}: {command.splitlines()[0]}"))
            if wrong := self.repository.wrong(command):
                self.fail(place, command, wrong)
            return
        small = command
        for pattern, instead in REDUCED:
            small = re.sub(pattern, instead, small)
        if small != command:
            self.reduced[command] = small
        for output in outputs_of(small):
            remove(scratch, output)
        try:
            self.world.link_into(scratch, small, outputs_of(small))
        except (OSError, subprocess.SubprocessError) as cause:
            self.fail(place, command, f"its inputs could not be made: {cause}{getattr(cause, 'stderr', None) or ''}")
            return
        self.execute(place, command, ["sh", "-e", "-c", small], scratch)

    def python(self, name: str, text: str, scratch: pathlib.Path) -> None:
        """Runs the Python of a page as one program, or notes why not."""
        program = []
        for block in blocks_of(text):
            if block.kind.split()[:1] != ["python"]:
                continue
            place = f"{name}:{block.line}: python"
            if name in TESTED:
                self.not_run.append((f"{TESTED[name]} runs it", place))
            elif block.not_run:
                self.not_run.append((block.not_run, place))
            elif importlib.util.find_spec("starbreak") is None:
                self.not_run.append((f"{sys.executable} has no package starbreak", place))
            else:
                program += block.lines
        if program:
            source = "\n".join(program)
            self.world.link_into(scratch, source, [])
            self.execute(name, "its Python", [sys.executable, "-c", source], scratch)

    def execute(self, place: str, command: str, words: list[str], scratch: pathlib.Path) -> None:
        """Runs it, says how long it took, and notes it where it fails."""
        began = time.monotonic()
        try:
            done = subprocess.run(
                words, cwd=scratch, env=self.environment, capture_output=True, text=True, check=False, timeout=LIMIT_S
            )
            wrong = None if done.returncode == 0 else f"exit code {done.returncode}\n{done.stderr.strip()}"
        except subprocess.TimeoutExpired:
            wrong = f"not done in {LIMIT_S} s; make it smaller in REDUCED of docs/run_commands.py"
        self.n_run += 1
        took_s = time.monotonic() - began
        print(f"{'FAILED' if wrong else 'ok':6} {took_s:5.1f} s  {place}: {command}", flush=True)
        if wrong:
            self.fail(place, command, wrong)

    def fail(self, place: str, command: str, wrong: str) -> None:
        """Notes a failure."""
        self.failed.append(f"{place}: {command}\n    " + wrong.replace("\n", "\n    "))

    def end(self) -> int:
        """Says what was made small, what was not run and what failed; the exit code."""
        print(f"\n{len(self.reduced)} commands were made small:")
        for command, small in self.reduced.items():
            print(f"  {command}\n    as {small}")
        print(f"{len(self.not_run)} were not run:")
        for reason in dict.fromkeys(reason for reason, _ in self.not_run):
            print(f"  {reason}:")
            for known, what in self.not_run:
                if known == reason:
                    print(f"    {what}")
        for failure in self.failed:
            print(f"error: {failure}", file=sys.stderr)
        print(f"{self.n_run} run, {len(self.not_run)} not run, {len(self.failed)} failed", flush=True)
        return 1 if self.failed else 0


def remove(scratch: pathlib.Path, output: str) -> None:
    """Removes what an earlier command wrote under this name, and beside a file (out.mp4.track.json)."""
    place = (scratch / output).parent.resolve() / pathlib.Path(output).name
    if not place.is_relative_to(scratch.resolve()):
        return
    beside = [*place.parent.glob(f"{place.name}.*")] if place.suffix else []
    for path in [place, *beside]:
        if path.is_symlink() or path.is_file():
            path.unlink()
        elif path.is_dir():
            shutil.rmtree(path)


def pages() -> list[pathlib.Path]:
    """README.md and the pages of docs, but the decisions, which say what was true of their day."""
    docs = sorted((PROJECT / "docs").rglob("*.md"))
    return [PROJECT / "README.md", *(page for page in docs if "decisions" not in page.parts)]


def main() -> int:
    """Runs the pages."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("starbreak", type=pathlib.Path, help="the command")
    parser.add_argument("--inputs", type=pathlib.Path, help="folder with inputs of your own, by the names of the pages")
    parser.add_argument("--keep", type=pathlib.Path, help="new folder for all that is made, kept")
    parser.add_argument("pages", nargs="*", type=pathlib.Path, help="pages [default: all]")
    given = parser.parse_intermixed_args()
    if not given.starbreak.is_file():
        parser.error(f"{given.starbreak}: no such file; build it by `cargo build --release --package starbreak-cli`")
    if given.inputs and not given.inputs.is_dir():
        parser.error(f"{given.inputs}: no such folder; --inputs takes one with KITTI, COCO, photo.png …")
    if given.keep and given.keep.exists():
        parser.error(f"{given.keep}: exists; name a new folder")
    with tempfile.TemporaryDirectory(prefix="starbreak-docs-") as temporary:
        folder = given.keep or pathlib.Path(temporary)
        run = Run(given.starbreak.resolve(), given.inputs and given.inputs.resolve(), folder.resolve())
        for page in given.pages or pages():
            run.page(page.resolve())
        return run.end()


if __name__ == "__main__":
    sys.exit(main())
