"""Writes a program's manual page and its bash completion, both from what it says to --help (CLI11's form).

Usage: program_pages.py PROGRAM MANUAL_PAGE COMPLETION
"""

import os
import re
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path

TEXT_COLUMN = 30
ENTRY = re.compile(r" {2}(\S.*?)(?: {2,}(\S.*))?$")  # an option or a command, and its text if there is room
CONTINUED = re.compile(r" {10,}(\S.*)$")
GROUP = re.compile(r"\[Option Group: (.*)\]$")  # indents what is in it
RULE = re.compile(r" {2}\[(.*)\]$")  # of a group: how many of its options may be given
TITLE = re.compile(r"(\S.*):$")
LONG = re.compile(r"--[a-z][a-z-]*")
NAME = re.compile(r"(?<![\w-])(--?[A-Za-z][\w-]*)")
CHOICES = re.compile(r":\{([^}]*)\}")


@dataclass
class Help:
    command: list  # words: the program's name, a command, a command below it
    about: list = field(default_factory=list)  # lines
    usage: str = ""
    sections: list = field(default_factory=list)  # (title, [(head, text)])
    footer: list = field(default_factory=list)  # lines
    commands: list = field(default_factory=list)  # of Help

    def entries(self):
        return [entry for title, entries in self.sections if title != "Subcommands" for entry in entries]


def ask(program, words):
    variables = {name: value for name, value in os.environ.items() if not name.startswith("GICUBE_")}
    answer = subprocess.run([program, *words, "--help"], stdout=subprocess.PIPE, env=variables, check=True, text=True)
    return answer.stdout


def read_entry(line, page):
    entries = page.sections[-1][1]
    if more := CONTINUED.match(line):
        head, text = entries[-1]
        entries[-1] = (head, f"{text} {more[1]}".strip())
    elif entry := ENTRY.match(line):
        entries.append((entry[1], entry[2] or ""))
    elif line.strip() and line != "Options:":
        raise ValueError(f"{' '.join(page.command)} --help: not understood: {line}")


def with_text(head, text):
    """A head that just fits leaves one blank before its text."""
    column = TEXT_COLUMN - 2
    fits = head[column - 1 : column] == " " and head[:column].count("[") == head[:column].count("]")
    return (head[:column].strip(), head[column:]) if fits and not text else (head, text)


def read(program, words=()):
    page = Help([Path(program).name, *words])
    in_group = False
    for line in ask(program, words).splitlines():
        if line.startswith("Usage: "):
            page.usage = line.removeprefix("Usage: ")
        elif not page.usage:
            page.about.append(line)
        elif group := GROUP.match(line):
            in_group = True
            page.sections.append((group[1], []))
        elif in_group and (rule := RULE.match(line)):
            page.sections[-1] = (f"{page.sections[-1][0]} ({rule[1]})", [])
        elif in_group and line.startswith("  "):
            read_entry(line.removeprefix("  "), page)
        elif page.footer or (line and not line.startswith(" ") and not TITLE.match(line)):
            page.footer.append(line)
        elif title := TITLE.match(line):
            in_group = False
            page.sections.append((title[1], []))
        elif line.strip():
            read_entry(line, page)
    for title, entries in page.sections:
        entries[:] = [with_text(*entry) for entry in entries]
        if title == "Subcommands":
            page.commands = [read(program, (*words, name)) for name, _ in entries]
    return page


# ---- manual page


def escaped(text):
    text = text.replace("\\", r"\e").replace("-", r"\-")
    return r"\&" + text if text.startswith((".", "'")) else text


def head_line(head):
    head = re.sub(r"^(-\w),--", r"\1, --", head)
    return NAME.sub(lambda name: r"\fB" + name[1] + r"\fR", escaped(head).replace(r"\-", "-")).replace("-", r"\-")


def option_lines(page):
    for title, entries in page.sections:
        if title == "Subcommands":
            continue
        if title not in ("Options", "Positionals"):
            yield f".PP\n{escaped(title)}:"
        for head, text in entries:
            yield f".TP\n{head_line(head)}"
            yield escaped(text) or r"\&"


def command_lines(page):
    for command in page.commands:
        yield f".SS {escaped(' '.join(command.command[1:]))}"
        yield from map(escaped, filter(None, command.about))
        if not command.commands:
            yield f".PP\n{head_line(command.usage)}"
        yield from option_lines(command)
        yield from command_lines(command)


def manual_page(page, version):
    name = page.command[0]
    yield f'.TH {name.upper()} 1 "" "{version}" "GI-Cube SDK"'
    yield f".SH NAME\n{name} \\- {escaped(page.about[0].rstrip('.'))}"
    yield f".SH SYNOPSIS\n{head_line(page.usage)}"
    if page.about[1:]:
        yield ".SH DESCRIPTION"
        yield from map(escaped, filter(None, page.about[1:]))
    yield ".SH OPTIONS"
    yield from option_lines(page)
    if page.commands:
        yield ".SH COMMANDS"
        yield from command_lines(page)
    if page.footer:
        yield ".SH NOTES\n.nf"
        yield from map(escaped, page.footer)
        yield ".fi"
    yield ".SH SEE ALSO\nThe guide in share/doc/gicube/docs, beside bin."


# ---- completion


def below(page):
    yield page
    for command in page.commands:
        yield from below(command)


def words_after(page):
    options = [name for head, _ in page.entries() for name in LONG.findall(head.split(" ")[0])]
    return [command.command[-1] for command in page.commands] + options


def choices(page):
    for each in below(page):
        for head, _ in each.entries():
            if found := CHOICES.search(head):
                for name in NAME.findall(head.split(" ")[0]):
                    yield name, found[1].replace(",", " ")


def completion(page):
    name = page.command[0]
    function = "_" + name.replace("-", "_")
    yield f"""# bash completion for {name}, made from its --help.
{function}() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD - 1]}} command= words= word
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case "$command/$word" in"""
    for each in below(page):
        for command in each.commands:
            yield f"      {'/'.join(['', *command.command[1:]])}) command=/{'/'.join(command.command[1:])} ;;"
    yield '      *) ;;\n    esac\n  done\n  case "$command" in'
    for each in below(page):
        path = "/".join(["", *each.command[1:]]) if each.command[1:] else '""'
        yield f'    {path}) words="{" ".join(words_after(each))}" ;;'
    yield '  esac\n  case "$previous" in'
    for option, values in dict(choices(page)).items():
        yield f'    {option}) words="{values}" ;;'
    yield f"""    *) ;;
  esac
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current")
}}
complete -o default -F {function} {name}  # no such word: a file"""


def main(program, manual, script):
    version = subprocess.run([program, "--version"], stdout=subprocess.PIPE, check=True, text=True).stdout.strip()
    page = read(program)
    for file, lines in ((manual, manual_page(page, version)), (script, completion(page))):
        Path(file).parent.mkdir(parents=True, exist_ok=True)
        Path(file).write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
