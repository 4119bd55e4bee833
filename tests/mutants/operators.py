"""Small mistakes that a C++ source can be given, one at a time.

`mutations(text)` reads a source by its tokens and returns what could be changed: places within code, never within
comments, strings, directives, static_assert, arguments of templates, or what a `throw` says.
"""
import re
from dataclasses import dataclass

TOKEN = re.compile(r"""
    (?P<comment>//[^\n]*|/\*.*?\*/)
  | (?P<string>(?:u8|[uUL])?R"(?P<mark>[^()\\\s]{0,16})\(.*?\)(?P=mark)"|"(?:\\.|[^"\\\n])*"|'(?:\\.|[^'\\\n])*')
  | (?P<directive>^[ \t]*\#(?:\\\n|[^\n])*)
  | (?P<number>(?:0[xXbB][\da-fA-F']+|(?:\d[\d']*\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\w*)
  | (?P<word>[A-Za-z_]\w*)
  | (?P<sign><=>|<<=|>>=|->|<=|>=|==|!=|&&|\|\||\+\+|--|\+=|-=|\*=|/=|%=|::|<<|>>|[^\s\w])
""", re.X | re.S | re.M)

RELATIONS = {"<": ("<=", ">="), "<=": ("<", ">"), ">": (">=", "<="), ">=": (">", "<"), "==": ("!=",), "!=": ("==",)}
ARITHMETIC = {"+": "-", "-": "+", "*": "/", "/": "*", "%": "*", "+=": "-=", "-=": "+=", "*=": "/=", "/=": "*="}
LOGIC = {"&&": "||", "||": "&&"}
TWINS = {"min": "max", "minCoeff": "maxCoeff", "cwiseMin": "cwiseMax", "fmin": "fmax", "floor": "ceil", "sin": "cos"}
TWINS |= {b: a for a, b in TWINS.items()}
ASSIGNMENTS = {"=", "+=", "-=", "*=", "/=", "%=", "|=", "&="}
CLOSING = {"(": ")", "[": "]", "{": "}"}

# What a value returned without having been computed is already.
NOTHINGS = ("false", "0", "0.0", "nullptr", "std::nullopt", "nullopt")

OPERATORS = ("relation", "arithmetic", "sign", "constant", "off by one", "negated condition", "logic",
             "removed statement", "swapped min and max", "returned constant")


@dataclass(frozen=True)
class Token:
    kind: str
    text: str
    begin: int
    end: int


@dataclass(frozen=True)
class Mutation:
    operator: str
    begin: int  # characters begin to end of the text become `to`
    end: int
    to: str

    def apply(self, text):
        return text[:self.begin] + self.to + text[self.end:]

    def is_a_mistake(self, text):
        """Whether the program is another one: `return {}` for `return false` is the same."""
        before = text[self.begin:self.end]
        return self.operator != "returned constant" or before.removeprefix("return").strip() not in NOTHINGS


def tokens_of(text):
    """What is code: comments are left out, strings and directives are tokens of their own."""
    return [Token(m.lastgroup if m.lastgroup != "mark" else "string", m.group(), m.start(), m.end())
            for m in TOKEN.finditer(text) if m.lastgroup != "comment"]


class Source:
    def __init__(self, text):
        self.text = text
        self.tokens = tokens_of(text)
        self.partner = self._brackets()
        self.skipped = self._skipped()

    def _brackets(self):
        """Index of the other bracket, for each ( [ {."""
        partner, open_ones = {}, []
        for i, token in enumerate(self.tokens):
            if token.kind != "sign":
                continue
            if token.text in CLOSING:
                open_ones.append(i)
            elif token.text in CLOSING.values() and open_ones:
                other = open_ones.pop()
                partner[i], partner[other] = other, i
        return partner

    def is_at(self, i, *texts):
        return 0 <= i < len(self.tokens) and self.tokens[i].text in texts

    def _end_of_statement(self, i):
        while i < len(self.tokens) and not self.is_at(i, ";", "}"):
            i = self.partner.get(i, i) + 1 if self.is_at(i, "(", "[", "{") else i + 1
        return i

    def _end_of_angle(self, i):
        """The > of a < that stands right behind a word, or None: clang-format parts comparisons by spaces."""
        depth = 0
        for j in range(i, min(len(self.tokens), i + 60)):
            depth += {"<": 1, ">": -1, ">>": -2}.get(self.tokens[j].text, 0)
            if depth <= 0:
                return j
            if self.is_at(j, ";", "{", "&&", "||"):
                return None
        return None

    def _skipped(self):
        skipped = set()
        for i, token in enumerate(self.tokens):
            if token.text in ("static_assert", "using", "typedef", "requires", "concept", "throw", "operator"):
                last = i + 2 if token.text == "operator" else self._end_of_statement(i)
                skipped.update(range(i + (token.text == "throw"), last))
            if token.text == "<" and i > 0 and (self.is_at(i - 1, "template") or
                                               self.tokens[i - 1].kind == "word" and self.tokens[i - 1].end == token.begin):
                last = self._end_of_angle(i)
                if last is not None:
                    skipped.update(range(i, last + 1))
        return skipped

    # ---- bodies of functions -------------------------------------------------------------------------

    def _opens_code(self, i, begin, is_inside_code):
        """Whether the { at i begins statements; begin is where its statement does."""
        head = [t.text for t in self.tokens[begin:i]]
        if not head:
            return is_inside_code
        if head[0] in ("namespace", "class", "struct", "enum", "union", "extern", "public", "private"):
            return False
        if head[0] == "template" and any(word in head for word in ("class", "struct")) and "(" not in head:
            return False
        if head[-1] in (")", "]", "else", "do", "try", "const", "noexcept", "override", "mutable", "final"):
            return True
        if head[-1] == "}" or head[-1] == ":":
            return True
        return "->" in head and ")" in head and "=" not in head[head.index("->"):]

    def statements(self):
        """(first, last) of the tokens of each statement within a function; last is its semicolon."""
        found, begin, code = [], 0, [False]
        i = 0
        while i < len(self.tokens):
            text = self.tokens[i].text
            if self.tokens[i].kind == "directive":
                begin = i + 1
            elif text == "{":
                inside = self._opens_code(i, begin, code[-1])
                if not inside and begin < i and self.tokens[begin].text not in (
                        "namespace", "class", "struct", "union", "extern", "template"):
                    i = self.partner.get(i, i) + 1  # an initialiser, an enumeration
                    continue
                code.append(inside)
                begin = i + 1
            elif text == "}":
                if len(code) > 1:
                    code.pop()
                begin = i + 1
            elif text == "(" and self.is_at(i - 1, "if", "while", "for", "switch", "constexpr") and code[-1]:
                i = self.partner.get(i, i)
                begin = i + 1
            elif text in ("else", "do"):
                begin = i + 1
            elif text == ":" and self.is_at(begin, "case", "default"):
                begin = i + 1
            elif text == ";":
                if code[-1] and i > begin:
                    found.append((begin, i))
                begin = i + 1
            elif text in ("(", "[") and not self._holds_body(i):
                i = self.partner.get(i, i)
            i += 1
        return found

    def _holds_body(self, i):
        """Whether a lambda with statements stands between these brackets."""
        return any(self.is_at(j, "{") and self.is_at(j - 1, ")", "]") for j in range(i, self.partner.get(i, i)))

    def is_expression_statement(self, first, last):
        i = first
        if self.is_at(i, "continue", "break", "throw"):
            return True
        if self.is_at(i, "return"):
            return last == first + 1
        while self.is_at(i, "++", "--", "*", "("):
            i = self.partner.get(i, i) if self.is_at(i, "(") else i
            i += 1
        if i < len(self.tokens) and self.tokens[i].kind == "word":
            i += 1
        while i < last:
            if self.is_at(i, "::", ".", "->"):
                i += 2
            elif self.is_at(i, "(", "["):
                i = self.partner.get(i, last) + 1
            else:
                break
        return i == last or self.tokens[i].text in ASSIGNMENTS or self.is_at(i, "++", "--")


def _of_tokens(source):
    text, tokens = source.text, source.tokens
    for i, token in enumerate(tokens):
        if i in source.skipped:
            continue
        spaced = text[token.begin - 1:token.begin].isspace() and text[token.end:token.end + 1].isspace()

        def to(operator, new):
            return Mutation(operator, token.begin, token.end, new)

        if token.kind == "sign":
            if token.text in RELATIONS and spaced:
                for other in RELATIONS[token.text]:
                    yield to("relation", other)
            if token.text in ARITHMETIC and spaced and not source.is_at(i - 1, "const"):
                yield to("arithmetic", ARITHMETIC[token.text])
            if token.text in LOGIC and spaced:
                yield to("logic", LOGIC[token.text])
            if token.text == "-" and not text[token.end:token.end + 1].isspace() and (
                    source.is_at(i - 1, "(", ",", "=", "return", "?", ":", "{", "[", "&&", "||", "<", ">", "+", "*", "/")):
                yield to("sign", "")
            if token.text == "[" and i > 0 and i in source.partner and source.partner[i] > i + 1 and (
                    _is_subscripted(tokens, i - 1)):
                close = tokens[source.partner[i]]
                yield Mutation("off by one", close.begin, close.begin, " + 1")
        elif token.kind == "number":
            yield from (to("constant", other) for other in _other_numbers(token.text))
        elif token.kind == "word":
            if token.text in ("true", "false"):
                yield to("constant", "false" if token.text == "true" else "true")
            elif token.text in TWINS and source.is_at(i + 1, "(") and source.is_at(i - 1, "::", ".", "->"):
                yield to("swapped min and max", TWINS[token.text])
            elif token.text == "abs" and source.is_at(i + 1, "(") and source.is_at(i - 1, "::") and source.is_at(i - 2, "std"):
                yield Mutation("sign", tokens[i - 2].begin, token.end, "")
            elif token.text in ("if", "while") and source.is_at(i + 1, "("):
                first, last = i + 1, source.partner.get(i + 1)
                inner = [j for j in range(first, last or first) if source.is_at(j, ";")]
                begin = tokens[inner[-1]].end if inner else tokens[first].end
                if last:
                    condition = text[begin:tokens[last].begin]
                    if _is_one_relation(condition):
                        continue  # the other relation is the same mistake
                    yield Mutation("negated condition", begin, tokens[last].begin, f"!({condition.strip()})")
            elif token.text == "for" and source.is_at(i + 1, "("):
                ends = [j for j in range(i + 1, source.partner.get(i + 1, i + 1)) if source.is_at(j, ";")]
                if len(ends) == 2 and ends[1] > ends[0] + 1:
                    inside = [t.text for t in tokens[ends[0]:ends[1]]]
                    if "<" in inside and "&&" not in inside and "||" not in inside:
                        yield Mutation("off by one", tokens[ends[1]].begin, tokens[ends[1]].begin, " - 1")


def _is_subscripted(tokens, i):
    """Whether a [ behind token i takes an entry: it neither declares an array nor begins a lambda."""
    if tokens[i].text in (")", "]"):
        return True
    is_declared = i > 0 and tokens[i - 1].kind == "word" and tokens[i - 1].text not in ("return", "else", "case")
    return tokens[i].kind == "word" and tokens[i].text not in ("return", "delete", "new") and not is_declared


def _is_one_relation(condition):
    words = [token.text for token in tokens_of(condition)]
    return sum(word in RELATIONS for word in words) == 1 and not any(word in LOGIC or word == "?" for word in words)


def _other_numbers(number):
    if re.fullmatch(r"\d+", number):
        n = int(number)
        return (str(n + 1),) if n == 0 else (str(n + 1), str(n - 1))
    if re.fullmatch(r"[\d.]+(?:[eE][+-]?\d+)?", number):
        return ("1.0",) if float(number) == 0.0 else (f"(2.0 * {number})", "0.0")
    return ()


def _of_statements(source):
    for first, last in source.statements():
        begin, end = source.tokens[first].begin, source.tokens[last].begin
        if first in source.skipped:
            continue
        if source.is_expression_statement(first, last):
            yield Mutation("removed statement", begin, end, "")
        if source.is_at(first, "return") and last > first + 1 and source.text[begin:end] != "return {}":
            yield Mutation("returned constant", begin, end, "return {}")


def mutations(text):
    """All of them, in the order of their places."""
    source = Source(text)
    found = set(_of_tokens(source)) | set(_of_statements(source))
    return sorted(found, key=lambda m: (m.begin, m.end, m.operator, m.to))
