"""The mistakes are made where code is, one at a time, and the same for the same seed."""
import contextlib
import io
import json
import tempfile
import unittest
from pathlib import Path
from unittest import mock

import mutate
import operators
import relink
import trial

SOURCE = '''#include <vector>
#define LIMIT 3
// a + b < c, as a comment
static_assert(sizeof(int) == 4, "no int of 4 bytes");
namespace a {
struct Options { int most = 7; std::vector<double> start = {}; };
double mean(const std::vector<double>& x, int n) {
  if (n == 0) throw std::runtime_error(fmt::format("{} of 1 + 2", n + 1));
  double sum = 0.0;
  for (int i = 0; i < n; ++i) {
    sum += x[i];
  }
  report("a - b", n);  /* n * 2 */
  const auto twice = [&](double y) { return -2.0 * y; };
  return n > 1 && sum < 1e3 ? twice(sum) : std::min(sum, x.front());
}
}  // namespace a
'''


def made(operator, text=SOURCE):
    return [mutation.apply(text) for mutation in operators.mutations(text) if mutation.operator == operator]


class Operators(unittest.TestCase):
    def changes(self, operator):
        """(line before, line after), by the one line that differs."""
        found = []
        for text in made(operator):
            pairs = [(a.strip(), b.strip()) for a, b in zip(SOURCE.split("\n"), text.split("\n")) if a != b]
            self.assertEqual(len(pairs), 1)
            found.append(pairs[0])
        return found

    def test_only_code_changes(self):
        for mutation in operators.mutations(SOURCE):
            if mutation.operator == "removed statement":
                continue
            for words in ("#define LIMIT 3", "// a + b < c, as a comment", "static_assert(sizeof(int) == 4",
                          '"{} of 1 + 2", n + 1', '"a - b"', "/* n * 2 */", "std::vector<double> start"):
                self.assertIn(words, mutation.apply(SOURCE))

    def test_nothing_for_nothing_is_no_mistake(self):
        text = "bool f(int n) {\n  if (n > 3) return false;\n  return n > 1;\n}\n"
        returned = [m for m in operators.mutations(text) if m.operator == "returned constant"]
        self.assertEqual([m.is_a_mistake(text) for m in returned], [False, True])

    def test_each_kind_is_made(self):
        after = {name: [b for _, b in self.changes(name)] for name in operators.OPERATORS}
        self.assertIn("if (n != 0) throw std::runtime_error(fmt::format(\"{} of 1 + 2\", n + 1));", after["relation"])
        self.assertIn("for (int i = 0; i <= n; ++i) {", after["relation"])
        self.assertIn("sum -= x[i];", after["arithmetic"])
        self.assertIn("const auto twice = [&](double y) { return 2.0 * y; };", after["sign"])
        self.assertIn("struct Options { int most = 8; std::vector<double> start = {}; };", after["constant"])
        self.assertIn("for (int i = 0; i < n - 1; ++i) {", after["off by one"])
        self.assertIn("sum += x[i + 1];", after["off by one"])
        self.assertIn("return n > 1 || sum < 1e3 ? twice(sum) : std::min(sum, x.front());", after["logic"])
        self.assertIn("return n > 1 && sum < 1e3 ? twice(sum) : std::max(sum, x.front());", after["swapped min and max"])
        self.assertIn("return {};", after["returned constant"])
        self.assertIn("const auto twice = [&](double y) { return {}; };", after["returned constant"])
        self.assertEqual(len(after["removed statement"]), 3)  # the throw, the sum, the report

    def test_a_condition_of_one_relation_is_not_also_negated(self):
        self.assertEqual(made("negated condition"), [])
        self.assertEqual(made("negated condition", "void f() { if (a && b) g(); }"), ["void f() { if (!(a && b)) g(); }"])

    def test_declarations_are_no_statements_to_remove(self):
        text = "void f() { int a = 1; std::vector<int> b(3); Mat& c = d; a.b().c[2] = 3; ++a; *p = 4; g(); }"
        removed = {text.replace(words, ";", 1) for words in ("a.b().c[2] = 3;", "++a;", "*p = 4;", "g();")}
        self.assertEqual(set(made("removed statement", text)), removed)

    def test_all_sources_can_be_read(self):
        files = [path for top in ("framework/saltus/qp", "integrators") for path in (relink.ROOT / top).rglob("*.cpp")]
        for path in files:
            text = path.read_text()
            for mutation in operators.mutations(text):
                self.assertNotEqual(mutation.apply(text), text, path)


class Campaign(unittest.TestCase):
    def test_a_seed_draws_the_same_mutants_and_all_of_them(self):
        found = {name: [("a.cpp", m) for m in operators.mutations(SOURCE) if m.operator == name]
                 for name in operators.OPERATORS}
        once = list(mutate.drawn(found, "1 qp"))
        self.assertEqual(once, list(mutate.drawn(found, "1 qp")))
        self.assertNotEqual(once, list(mutate.drawn(found, "2 qp")))
        self.assertEqual(len(once), len(operators.mutations(SOURCE)))

    def test_half_a_line_of_results_is_dropped(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "seed1.jsonl"
            path.write_text('{"layer": "qp"}\n{"layer": "q')
            self.assertEqual(mutate.read_results(path, 1), [{"layer": "qp"}])
            with self.assertRaisesRegex(relink.Failure, "nothing of seed 2"):
                mutate.read_results(Path(folder) / "seed2.jsonl", 2)

    def test_an_interrupted_campaign_goes_on_where_it_was(self):
        layers = {name: {"folders": [], "tests": [], "later": [], "last": []} for name in ("qp", "integrators")}
        file = "integrators/saltus/integrators/simulate.cpp"
        text = (relink.ROOT / file).read_text()
        found = {name: [(file, m) for m in operators.mutations(text) if m.operator == name] for name in operators.OPERATORS}

        def judged(build, mutant, rounds, scratch, most):
            if self.left == 0:
                raise KeyboardInterrupt
            self.left -= 1
            return ("not compiled", "killed", "survived")[len(mutant.after) % 3], ""

        def begun_and_ended(folder, *stops):
            path = Path(folder) / "seed3.jsonl"
            mutate.write_results(path, [])
            for self.left in stops:
                with contextlib.suppress(KeyboardInterrupt):
                    results = mutate.read_results(path, 3)
                    mutate.campaign(mock.Mock(work=Path(folder)), layers, list(layers), 3, 12, results, path)
            return [mutate.key(result) for result in mutate.read_results(path, 3)], results

        with mock.patch.multiple(mutate, judge=judged, sites=lambda *_: (found, 0), Programs=mock.Mock()), \
                contextlib.redirect_stdout(io.StringIO()), tempfile.TemporaryDirectory() as folder:
            whole, results = begun_and_ended(folder, 1000)
            self.assertEqual(begun_and_ended(folder, 0, 1, 5, 1000)[0], whole)
            for layer in layers:
                tested = [r for r in results if r["layer"] == layer and r["status"] != "not compiled"]
                self.assertEqual(len(tested), 6)

    def test_a_mutant_is_found_again_as_long_as_its_line_stands(self):
        file = "integrators/saltus/integrators/simulate.cpp"
        mutation = operators.mutations((relink.ROOT / file).read_text())[0]
        facts = mutate.Mutant(file, mutation).facts()
        again = mutate.found_again(facts | {"line": facts["line"] + 7})
        self.assertEqual((again.before, again.after), (facts["before"], facts["after"]))
        self.assertIsNone(mutate.found_again(facts | {"before": "no such line"}))

    def test_survivors_need_a_reason_and_enough_must_be_killed(self):
        def result(status, line):
            return {"layer": "qp", "file": "a.cpp", "line": line, "operator": "sign", "before": str(line), "after": "",
                    "status": status, "by": ""}
        results = [result("killed", n) for n in range(17)] + [result("survived", n) for n in range(17, 20)]
        reason = {mutate.key(each): "equivalent" for each in results}
        self.assertTrue(mutate.summary(results, reason)[1])
        self.assertFalse(mutate.summary(results, {})[1])
        self.assertFalse(mutate.summary(results + [result("survived", 20)], reason | {("a.cpp", "20", ""): ""})[1])

    def test_tests_and_a_folder_may_be_chosen(self):
        self.assertEqual(trial.parts_of("test_qp"), ("test_qp", "*", ""))
        self.assertEqual(trial.parts_of("test_qp=A.*:B.*-A.C@problems/biped/survey"), ("test_qp", "A.*:B.*-A.C", "problems/biped/survey"))
        self.assertEqual(trial.parts_of("test_qp@robots"), ("test_qp", "*", "robots"))

    def test_an_endless_program_and_one_that_sleeps_are_stopped(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertEqual(trial.run(["true"], Path(folder), 5)[0], "passed")
            self.assertEqual(trial.run(["false"], Path(folder), 5)[0], "failed")
            self.assertEqual(trial.run(["sh", "-c", "while :; do :; done"], Path(folder), 1)[0], "too long")

    def test_reasons_name_lines_that_stand_in_the_sources(self):
        for entry in json.loads(mutate.EXPLAINED.read_text()):
            lines = {" ".join(line.split()) for line in (relink.ROOT / entry["file"]).read_text().split("\n")}
            self.assertIn(entry["before"], lines, f"{entry['file']} has changed: run the mutant again")
            self.assertTrue(entry["reason"])


if __name__ == "__main__":
    unittest.main()
