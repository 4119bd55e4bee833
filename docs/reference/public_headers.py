#!/usr/bin/env python3
"""Converts the public headers for Doxygen and writes them to the folder OUT: OUT/saltus/core/types.hpp and so on.

Usage: public_headers.py OUT

The comments of the headers are written for readers of the source. For Doxygen they are rewritten without a change of
line numbers:

- the first comment of a header, `// One idea.`, documents the file;
- a comment after a declaration, `double thrust;  // N`, documents the declaration;
- for several names in one declaration, `double x, y;  ///< m`, and consecutive functions under one comment, the comment
  documents each;
- deprecated names are hidden;
- copy and move constructors and assignments are omitted; defaulted and deleted functions and the arithmetic of
  automatic differentiation receive a comment.
"""

import glob
import os
import re
import sys

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
LIST = os.path.join(ROOT, "framework", "cmake", "public_headers.txt")
ONCE = "#pragma once"
BEHIND = re.compile(r"^(\s*[^\s/}#].*[;,{])\s+//\s(?!NOLINT)(.*)$")  # `double thrust;  // N`
SEVERAL = re.compile(r"^(\s*)((?:static constexpr |const )?[\w:]+(?:<[^;=]*?>)?(?:::\w+)?) (\w+(?: = [^;]*|\{[^;]*)?, [^;]*);(.*)$")
ON_ONE_LINE = re.compile(r"^(\s*)((?:enum|struct|class) .*\};)\s+//(?:/<)? (.*)$")
FUNCTION = re.compile(r"^(\s*)(?!return |using |friend )([\w:<>,&*\[\] ]+ \w+\([^/]*\)(?: const)?;)$")
AS_MADE = re.compile(r"^(\s*)(\S.*=\s*(default|delete);.*)$")
COPIES = re.compile(r"^(\s*)(?:(\w+)\(const \2&[^,)]*\)|(\w+)& operator=\(const \3&[^,)]*\))(?: noexcept)?;")
MOVES = re.compile(r"^(\s*)(?:(\w+)\(\2&&[^,)]*\)|(\w+)& operator=\(\3&&[^,)]*\))(?: noexcept)?;")
# Types that carry derivatives or dependence; their operators need no comment.
ARITHMETIC = re.compile(
    r"^\s*(?:\[\[gnu::\w+\]\] )?(?:friend |static )?[\w:]+(?:<[^>]*>)?&? (?:operator[-+*/<>=!]+|sin|cos|tan|asin|acos"
    r"|atan|sinh|cosh|tanh|exp|log|sqrt|abs|min|max|atan2|hypot|pow|combine)\(")
AUTODIFF = ("saltus/autodiff/dual.hpp", "saltus/autodiff/math.hpp", "saltus/autodiff/tracer.hpp",
            "saltus/autodiff/dual.hpp")


def public_headers():
    """[(path below saltus/, file)], in order."""
    found = {}
    with open(LIST, encoding="utf-8") as file:
        patterns = [line.split()[1] for line in file if line.strip() and not line.startswith("#")]
    for pattern in patterns:
        for root in ("framework", "integrators", "robots"):  # SALTUS_INCLUDE_ROOTS of framework/cmake/SaltusTarget.cmake
            below = os.path.join(ROOT, root, "saltus")
            for path in glob.glob(os.path.join(below, pattern)):
                found[os.path.relpath(path, below)] = path
    return sorted(found.items())


def declarators(text):
    """["a = f(1, 2)", "b"] of "a = f(1, 2), b"."""
    parts, depth = [""], 0
    for letter in text:
        depth += (letter in "({[<") - (letter in ")}]>")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts]


def one_by_one(line, above):
    """Splits `double a, b;  ///< m` into two declarations with the same comment."""
    match = SEVERAL.match(line)
    if not match or match[2] in ("return", "using", "friend", "case", "template", "operator"):
        return line
    margin, kind, names, rest = match.groups()
    said = re.match(r"\s*///< (.*)", rest)
    words = said[1] if said else above
    if not words or not all(re.match(r"\w+( = .*|\{.*)?$", name) for name in declarators(names)):
        return line
    return margin + " ".join(f"{kind} {name}; /**< {words} */" for name in declarators(names))


def begins_at(out):
    """Index of the first line of the next declaration, which includes preceding `template <...>` and `requires` lines."""
    at = len(out)
    while at > 0 and re.match(r"\s*(template\s*<.*>|requires .*)\s*$", out[at - 1]):
        at -= 1
    return at


def as_words(line):
    """Escapes what Doxygen would interpret as a command or as HTML."""
    code, mark, words = line.partition("//")
    if not mark:
        return line
    return code + mark + re.sub(r"<(\w[\w ]*)>", r"\\<\1\\>", re.sub(r"\\(?=[ntx])", r"\\\\", words))


def without_deprecated(lines):
    """Hides deprecated names, which docs/migration.md lists, with their comments. A declaration ends where its braces
    are closed."""
    out, depth, is_hidden = [], 0, False
    for i, line in enumerate(lines):
        follows = lines[i + 1] if i + 1 < len(lines) else ""
        if line.strip().startswith("/// Deprecated name") and "[[deprecated" in line + follows:
            out.append("")
            continue
        if not is_hidden and "[[deprecated" in line and out and out[-1] == "" and i and "///" in lines[i - 1]:
            is_hidden, depth = True, 0
            line = f"/** \\cond */ {line.strip()}"
        if is_hidden:
            code = re.sub(r'"[^"]*"', "", line)
            depth += code.count("{") - code.count("}")
            if depth == 0 and code.rstrip().endswith((";", "}")):
                is_hidden = False
                line += " /** \\endcond */"
        out.append(line)
    return out


def rewritten(name, lines):
    lines = without_deprecated(lines)
    out, is_head, above, shared = [], True, "", ""
    for i, line in enumerate(lines):
        is_head = is_head and line.startswith("//")
        behind, as_made = BEHIND.match(line), AS_MADE.match(line)
        is_said = i > 0 and "///" in lines[i - 1] and lines[i - 1].strip().startswith("///")
        if line.strip().startswith("///"):
            above = (above + " " if is_said else "") + line.strip()[3:].strip()
        elif not is_said:
            above = ""
        # Doxygen 1.9.4 links to pages of concepts that it does not write.
        is_concept = line.startswith("concept ")
        line = re.sub(r"^concept (\w+) =", r"inline constexpr bool \1 =", line)
        at = begins_at(out)
        if is_concept and at < len(out) and not out[at - 1].startswith("///"):
            out[at] = "/** Requirements of a template on its arguments. */ " + out[at]
        copies = COPIES.match(line) or MOVES.match(line)
        function = FUNCTION.match(line)
        shared = (above if is_said else shared) if function else ""
        if is_head:  # names the file in the same comment, which would otherwise document the namespace
            follows = lines[i + 1] if i + 1 < len(lines) else ""
            out.append(f"///{line[2:]}" + ("" if follows.startswith("//") or follows == ONCE else f" \\file {name}"))
        elif line == ONCE and out and out[-1].startswith("///"):
            out.append(f"/// \\file {name}")
        elif as_made and not is_said:
            words = "Defaulted." if as_made[3] == "default" else "Deleted."
            out.append(f"{as_made[1]}/** {words} */ {as_made[2]}")
        elif copies and not is_said:
            out.append(f"{copies[1]}/** \\cond */ {line.strip()} /** \\endcond */")
        elif name in AUTODIFF and ARITHMETIC.match(line) and not is_said and "///" not in line:
            at = begins_at(out)
            if at < len(out):
                out[at] = "/** Same as for numbers, with derivatives or dependence. */ " + out[at].strip()
                out.append(line)
            else:
                out.append("/** Same as for numbers, with derivatives or dependence. */ " + line.strip())
        elif function and shared and not is_said:
            out.append(f"{function[1]}/** {shared} */ {function[2]}")
        elif one_line := ON_ONE_LINE.match(line):
            out.append(f"{one_line[1]}/** {one_line[3]} */ {one_line[2]}")
        elif behind:
            out.append(one_by_one(f"{behind[1]}  ///< {behind[2]}", above))
        else:
            out.append(one_by_one(line, above))
    return "\n".join(as_words(line) for line in out) + "\n"


def main(out):
    for name, path in public_headers():
        with open(path, encoding="utf-8") as file:
            text = rewritten(f"saltus/{name}", file.read().splitlines())
        made = os.path.join(out, "saltus", name)
        os.makedirs(os.path.dirname(made), exist_ok=True)
        with open(made, "w", encoding="utf-8") as file:
            file.write(text)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
