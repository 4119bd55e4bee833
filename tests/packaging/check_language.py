#!/usr/bin/env python3
"""Counts what makes comments, pages and commit subjects hard to read, and compares the counts with limits.

Usage: check_language.py ROOT [--list FOLDER] [--write]

Rules, counted per top folder:
  fragment  a doc comment (///) that is only a prepositional or relative phrase, such as "Of the rows."
  phrase    an expression of PHRASES in a comment or page; a term of the field is plainer
  wide      a line of prose in a page with more than 120 characters
  long      a sentence in a page with more than 30 words
  subject   a commit subject after BASE with more than 72 characters

tests/packaging/language_limits.txt has a line "FOLDER RULE LIMIT" for each count that is not zero. The exit status is 1
if a count is above its limit. --list prints the places in FOLDER. --write stores lower counts; it never raises a limit.
"""

import collections
import os
import re
import subprocess
import sys

DIRECTIVE = re.compile(r"\s*#(?:include|define|undef|if|ifdef|ifndef|elif|else|endif|pragma|error)\b")
BASE = "46ff7616"  # subjects of older commits are not checked
LIMITS = os.path.join("tests", "packaging", "language_limits.txt")
MOST_COLUMNS, MOST_WORDS, LONGEST_SUBJECT = 120, 30, 72
SOURCES = (".hpp", ".cpp", ".py", ".js", ".cmake", ".sh")
SKIPPED = ("docs/results/", "docs/bad_inputs.md", "CHANGELOG.md", "LICENSES/", "tests/fuzz/corpus/",
           "tests/packaging/check_language")

FRAGMENT = re.compile(r"(of|by|as|to|from|in|on|at|for|with|without|behind|beside|what|that|who|whom|whose|which|where|"
                      r"whether|if|else)\b", re.I)
VERB = re.compile(r"\b(is|are|was|were|has|have|must|may|can|does|do|holds?|returns?|gives?|throws?|means?|contains?|"
                  r"\w+ed|\w+ises?|\w+izes?)\b", re.I)
PHRASES = re.compile("|".join(rf"\b{phrase}\b" for phrase in (
    r"(is|are|was|were|be) told", r"told (of|nothing|by)", r"gives? way", r"comes? to(?! rest)", r"came of", r"what came",
    r"who (walks|reads|calls|looks|wants|asks|has)", r"is to be had", r"shall be", r"hears? of", r"stands? (there|here)",
    r"of its own", r"of one's own", r"in turns", r"what (is|was) (really|asked)", r"no number", r"usual size",
    r"by so many", r"therein", r"namely", r"spoil(t|s)", r"mended", r"goes on with", r"nobody (knows|gave|asked)",
    r"what falls short", r"by hand", r"is in force", r"said of", r"what is not (told|said|met)")), re.I)


def tracked(root):
    listed = subprocess.run(["git", "-C", root, "ls-files"], capture_output=True, text=True, check=False).stdout.split("\n")
    if any(listed):
        return [name for name in listed if name]
    return sorted(os.path.relpath(os.path.join(folder, name), root)  # outside of a checkout
                  for folder, _, names in os.walk(root) for name in names)


def comments(text):
    """(line, text, is it a doc comment) of each comment; consecutive lines of a comment are joined."""
    found, begin, words, kind = [], 0, [], None
    for number, line in enumerate(text.split("\n"), 1):
        match = None if DIRECTIVE.match(line) else re.match(r"\s*(///|//|#)(?![!<])\s?(.*)$", line)
        trailing = None if match else re.search(r"(?:^|\s)(///<|//|#)\s+(.*)$", line)
        if match and match[1] == kind and not (words and words[-1].endswith(".") and kind == "//" and not match[2]):
            words.append(match[2].strip())
            continue
        if words:
            found.append((begin, " ".join(words), kind == "///"))
        begin, words, kind = (number, [match[2].strip()], match[1]) if match else (0, [], None)
        if trailing:
            found.append((number, trailing[2].strip(), trailing[1] == "///<"))
    if words:
        found.append((begin, " ".join(words), kind == "///"))
    return found


def check_source(text):
    for line, words, is_doc in comments(text):
        if is_doc and len(words.split()) <= 9 and FRAGMENT.match(words) and not VERB.search(words):
            yield line, "fragment", words
        match = PHRASES.search(words)
        if match:
            yield line, "phrase", words


def paragraphs(text):
    """(line, text) of prose: without code, tables, headings, formulas and pictures; items of lists are paragraphs."""
    begin, words, is_code = 0, [], False
    for number, line in enumerate([*text.split("\n"), ""], 1):
        plain = line.strip()
        if plain.startswith("```"):
            is_code = not is_code
        ends = is_code or not plain or plain.startswith(("```", "|", "#", "<!--", "![")) or line.startswith("    ")
        item = re.match(r"\s*(?:[-*]|\d+\.)\s+", line)
        if (ends or item) and words:
            yield begin, " ".join(words)
            words = []
        if not ends:
            begin = begin if words else number
            words.append(plain[len(item[0].lstrip()):] if item else plain)


def check_page(text):
    is_code = False
    for number, line in enumerate(text.split("\n"), 1):
        is_code = is_code != line.strip().startswith("```")
        if not is_code and len(line) > MOST_COLUMNS and "](" not in line and not line.startswith("    ") \
                and not line.lstrip().startswith(("|", "<", "#", "`")):
            yield number, "wide", line.strip()
    for number, text_of in paragraphs(text):
        match = PHRASES.search(re.sub(r"`[^`]*`", "x", text_of))
        if match:
            yield number, "phrase", text_of
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", re.sub(r"`[^`]*`", "x", text_of))
        for sentence in re.split(r"(?<=[.!?:;])\s+", plain):
            if len(sentence.split()) > MOST_WORDS:
                yield number, "long", sentence


def hits(root):
    """(folder, file, line, rule, text), and the number of words per folder."""
    found, words = [], collections.Counter()
    for name in tracked(root):
        if name.startswith(SKIPPED) or not name.endswith((*SOURCES, ".md")):
            continue
        try:
            with open(os.path.join(root, name), encoding="utf-8") as file:
                text = file.read()
        except (OSError, UnicodeDecodeError):
            continue
        folder = name.split("/")[0] if "/" in name else "."
        is_page = name.endswith(".md")
        words[folder] += sum(len(part[1].split()) for part in (paragraphs(text) if is_page else comments(text)))
        for line, rule, where in (check_page if is_page else check_source)(text):
            found.append((folder, name, line, rule, where))
    log = subprocess.run(["git", "-C", root, "log", "--format=%s", f"{BASE}..HEAD"], capture_output=True, text=True, check=False)
    for subject in log.stdout.split("\n"):  # empty if the history does not reach that far
        if len(subject) > LONGEST_SUBJECT:
            found.append(("commits", "commit", 0, "subject", subject))
    return found, words


def read_limits(root):
    limits = {}
    try:
        with open(os.path.join(root, LIMITS), encoding="utf-8") as file:
            for line in file:
                if line.strip() and not line.startswith("#"):
                    folder, rule, limit = line.split()
                    limits[folder, rule] = int(limit)
    except FileNotFoundError:
        pass
    return limits


def write_limits(root, limits):
    with open(os.path.join(root, LIMITS), "w", encoding="utf-8") as file:
        file.write("# Largest permitted counts of check_language.py. They only go down: check_language.py . --write\n")
        for (folder, rule), limit in sorted(limits.items()):
            if limit:
                file.write(f"{folder} {rule} {limit}\n")


def main(arguments):
    root = arguments[0]
    found, words = hits(root)
    if "--list" in arguments:
        folder = arguments[arguments.index("--list") + 1]
        for where, name, line, rule, text in found:
            if where == folder or name.startswith(folder):
                print(f"{name}:{line}: {rule}: {text[:140]}")
        return 0
    counts = collections.Counter((folder, rule) for folder, _, _, rule, _ in found)
    limits, is_new = read_limits(root), not os.path.exists(os.path.join(root, LIMITS))
    if "--write" in arguments:
        lower = counts if is_new else {key: min(limit, counts[key]) for key, limit in limits.items()}
        write_limits(root, lower)
        limits = dict(lower)
    status = 0
    for key in sorted(counts):
        if counts[key] > limits.get(key, 0):
            folder, rule = key
            status = 1
            print(f"language: {folder} has {counts[key]} places of kind '{rule}', at most {limits.get(key, 0)} are permitted: "
                  f"tests/packaging/check_language.py . --list {folder}")
    total, read = sum(counts.values()), sum(words.values())
    lower = sum(1 for key, limit in limits.items() if counts[key] < limit)
    hint = f"; {lower} limits can be lowered by --write" if lower else ""
    print(f"language: {total} places in {read} words, {1000 * total / max(1, read):.1f} per 1,000 words{hint}")
    return status


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1:]))
