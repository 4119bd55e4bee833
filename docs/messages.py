#!/usr/bin/env python3
"""Lists every message of the program with its file and line, or checks the messages that a page quotes.

Usage: messages.py SOURCE...              prints the list, e.g. messages.py framework robots
       messages.py --page PAGE SOURCE...  checks the page

SOURCE is a file or a folder with C++, Python and shell files. A message is a string of at least two words. `{}` in the
list stands for a value. Strings that one expression joins are one message.

A page quotes messages in code style, in the first column of tables that have the title "Message". `...` in a quotation
stands for any text. Every other part must occur in a string of the C++ files. The exit status is 1 if a part does not
occur.
"""

import ast
import os
import re
import sys

# The tokens of C++ that matter here: comments, raw strings, strings, characters, and directives with file names.
TOKEN = re.compile(r'(?P<skip>//[^\n]*|/\*.*?\*/|\'(?:[^\'\\\n]|\\.)+\'|^[ \t]*#[ \t]*include[^\n]*)'
                   r'|R"(?P<mark>\w*)\((?P<raw>.*?)\)(?P=mark)"|"(?P<text>(?:[^"\\\n]|\\.)*)"', re.S | re.M)
# Code between two strings of one message: nothing, or a value between two operators.
JOINED = re.compile(r"\s*$|\s*(?:\+|<<)[^;{}]*(?:\+|<<)\s*$")
TWO_WORDS = re.compile(r"[A-Za-z]{2,}[^A-Za-z]*\s.*[A-Za-z]{2,}", re.S)


def plain(literal):
    """The literal without its escapes."""
    return literal.replace('\\"', '"').replace("\\n", "\n").replace("\\\\", "\\")


def cpp_messages(text):
    """(line, message) of each string, or of strings that are joined, in the C++ source."""
    text = re.sub(r"(?<=\d)'(?=\d)", "", text)  # separators of digits
    found, end = [], None
    for token in TOKEN.finditer(text):
        if token["skip"] is not None:
            continue
        words = token["raw"] if token["raw"] is not None else plain(token["text"])
        gap = text[end:token.start()] if end is not None else ";"
        gap = re.sub(r"//[^\n]*|\\\n", "", gap)  # comments, and ends of lines in macros
        if JOINED.match(gap):
            line, before = found.pop()
            found.append((line, before + ("{}" if gap.strip() else "") + words))
        else:
            found.append((text.count("\n", 0, token.start()) + 1, words))
        end = token.end()
    return found


def python_messages(text):
    """(line, message) of each string of the Python source but its doc strings. A program's usage is a message."""
    tree = ast.parse(text)
    skipped = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(node, clean=False):
            if not (isinstance(node, ast.Module) and "__doc__" in text):
                skipped.add(node.body[0].value)
        elif isinstance(node, ast.JoinedStr):
            skipped.update(part for part in node.values if isinstance(part, ast.Constant))
            skipped.update(inner for part in node.values if isinstance(part, ast.FormattedValue)
                           for inner in ast.walk(part.format_spec or part.value) if inner is part.format_spec)
    for node in ast.walk(tree):
        if node in skipped:
            continue
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.lineno, node.value
        elif isinstance(node, ast.JoinedStr):
            yield node.lineno, "".join(part.value if isinstance(part, ast.Constant) else "{}" for part in node.values)


def shell_messages(text):
    """(line, message) of the strings in double quotes and of the texts between <<'TEXT' and TEXT."""
    for match in re.finditer(r'<<\'TEXT\'\n(.*?)\nTEXT|^[ \t]*#[^\n]*|"((?:[^"\\]|\\.)*)"', text, re.S | re.M):
        if match[1] or match[2]:
            yield text.count("\n", 0, match.start()) + 1, match[1] or plain(match[2])


def reader_of(path):
    """The function that reads the messages of the file, or None."""
    if path.endswith((".cpp", ".hpp")):
        return cpp_messages
    if path.endswith(".py"):
        return python_messages
    try:
        with open(path, "rb") as file:
            first = file.readline()
    except OSError:
        return None
    if first.startswith(b"#!") and b"python" in first:
        return python_messages
    return shell_messages if first.startswith(b"#!") and b"sh" in first else None


def files(sources):
    for source in sources:
        if os.path.isfile(source):
            yield source
        for folder, folders, names in os.walk(source):
            folders.sort()
            yield from (os.path.join(folder, name) for name in sorted(names))


def messages(sources):
    """(file, line, message) of all strings."""
    for path in files(sources):
        reader = reader_of(path)
        if reader:
            with open(path, encoding="utf-8") as file:
                for line, message in sorted(reader(file.read()), key=lambda found: found[0]):
                    yield path, line, message


def quotations(page):
    """The messages in the first column of tables with the title Message."""
    is_quoted = False
    with open(page, encoding="utf-8") as file:
        for line in file:
            if not line.startswith("|"):
                is_quoted = False
            elif line.startswith("| Message |"):
                is_quoted = True
            elif is_quoted:
                match = re.match(r"\| `(.+?)` \|", line)
                if match:
                    yield match[1].replace("\\|", "|")


def check(page, sources):
    known = "\n".join(message for path, _, message in messages(sources) if path.endswith((".cpp", ".hpp")))
    quoted = list(quotations(page))
    missing = [text for text in quoted
               if not all(part.strip() in known for part in re.split(r"\.\.\.|'[^' ]*'", text) if len(part.strip()) > 3)]
    for text in missing:
        print(f"{page}: no source has the message '{text}'", file=sys.stderr)
    if missing or not quoted:
        sys.exit(1)
    print(f"{len(quoted)} messages")


def print_list(sources):
    for path, line, message in messages(sources):
        if TWO_WORDS.search(message):
            print(f"{path}:{line}: " + "\n    ".join(message.strip().split("\n")))


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    if sys.argv[1] == "--page":
        check(sys.argv[2], sys.argv[3:])
    else:
        print_list(sys.argv[1:])
