#!/usr/bin/env python3
"""Checks that the scripts of `saltus bench` check answers, resume, merge and compare correctly. Argument: the program
saltus-bench.

Needs numpy; packages made here replace the peers.
"""

import argparse
import importlib.util
import json
import os
import subprocess
import sys
import unittest

from own_folder import OwnFolder

PROGRAM = sys.argv.pop(1)
SCRIPTS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../benchmarks/suite/scripts")
SMALL = ["--problems", "recipe/no-impact,sequence", "--start", "cold", "--instances", "2",
         "--repetitions", "1"]


class Scripts(OwnFolder):
    def bench(self, *words, status=0, **environment):
        done = subprocess.run(
            [sys.executable, "-B", os.path.join(SCRIPTS, "bench.py"), *words], text=True,
            capture_output=True, check=False, cwd=self.folder,
            env={**os.environ, "SALTUS_PROGRAM": PROGRAM, "SALTUS_PEERS": self.path("peers"),
                 **environment})
        self.assertEqual(done.returncode, status, done.stdout + done.stderr)
        return done

    def run_small(self, name, *more, status=0, solvers="riccati,sparse", **environment):
        done = self.bench("run", *SMALL, "--solvers", solvers, "--out", self.path(name), *more,
                          status=status, **environment)
        return done

    def untimed(self, name):
        return [json.dumps({k: v for k, v in line.items() if k not in ("times", "machine")})
                for line in self.lines(name)[1:]]

    def test_wrong_optimal_status_is_detected(self):
        self.run_small("a.jsonl", solvers="riccati,toy")
        verdicts = {(l["solver"], l["verdict"]) for l in self.lines("a.jsonl") if "solver" in l}
        self.assertEqual(verdicts, {("riccati", "solved"), ("toy", "wrong")})
        toy = next(l for l in self.lines("a.jsonl") if l.get("solver") == "toy")
        self.assertEqual(toy["claimed"], "optimal")

    def test_interrupted_run_resumes(self):
        self.run_small("whole.jsonl")
        with open(self.path("whole.jsonl"), encoding="utf-8") as file:
            text = file.read()
        first_end = text.index('{"done"')
        with open(self.path("cut.jsonl"), "w", encoding="utf-8") as file:
            file.write(text[:text.index("\n", first_end) + 200])
        done = self.run_small("cut.jsonl")
        self.assertIn("is incomplete", done.stderr)
        self.assertNotIn("recipe/no-impact cold;", done.stderr)
        self.assertEqual(self.untimed("cut.jsonl"), self.untimed("whole.jsonl"))

    def test_shards_make_the_whole(self):
        self.run_small("whole.jsonl")
        for part in ("1", "2"):
            self.run_small(part + ".jsonl", "--shard", part + "/2")
        self.bench("merge", self.path("2.jsonl"), self.path("1.jsonl"), "--out",
                   self.path("merged.jsonl"))
        self.assertEqual(self.untimed("merged.jsonl"), self.untimed("whole.jsonl"))
        self.bench("merge", self.path("1.jsonl"), "--out", self.path("half.jsonl"), status=3)

    def test_compare_finds_regressions(self):
        self.run_small("a.jsonl")
        self.bench("compare", "a.jsonl", "a.jsonl")
        for change in ("slower", "lost"):
            with open(self.path(change), "w", encoding="utf-8") as file:
                for line in self.lines("a.jsonl"):
                    if line.get("solver") == "riccati" and change == "slower":
                        line["times"] = {key: [3.0 * t for t in line["times"][key]] for key in ("wall_us", "cpu_us")}
                    if line.get("solver") == "riccati" and change == "lost":
                        line["verdict"] = "wrong"
                    file.write(json.dumps(line) + "\n")
            done = self.bench("compare", "a.jsonl", change, status=1)
            self.assertIn("WORSE", done.stdout)
            self.assertNotIn("WORSE", self.bench("compare", change, "a.jsonl").stdout)

    def test_compare_separates_slower_machine_from_slower_solver(self):
        def write(name, ours, others):
            with open(self.path(name), "w", encoding="utf-8") as file:
                tasks = [f"box/{k}x1 cold" for k in range(20)]
                print(json.dumps({"format": "saltus-bench 1", "saltus": {}, "machine": {}, "packages": {"piqp": "1"},
                                  "matrix": {"tasks": tasks, "solvers": ["riccati", "piqp"]}}), file=file)
                for task in tasks:
                    for solver, us in (("riccati", ours),) + ((("piqp", others),) if others else ()):
                        print(json.dumps({"problem": task, "start": "cold", "solver": solver, "instance": 1, "verdict": "solved",
                                          "times": {"wall_us": [us], "cpu_us": [us]}}), file=file)
                    print(json.dumps({"done": task}), file=file)
        write("a", 10.0, 100.0)
        write("loaded", 13.0, 130.0)
        write("slower", 16.0, 130.0)
        done = self.bench("compare", "a", "loaded")
        self.assertIn("solvers took 1.30 times as long", done.stdout)
        self.assertIn("0 worse, 0 better", done.stdout)
        self.assertNotIn("without other solvers", done.stdout)
        self.assertIn("20 worse, 0 better", self.bench("compare", "a", "slower", status=1).stdout)
        write("alone", 10.0, None)
        write("alone slower", 16.0, None)
        self.assertIn("without other solvers in both runs", self.bench("compare", "alone", "alone slower", status=1).stdout)

    def records(self, name, cells, matrix, **more):
        """A file of results: (task, solver) -> verdicts by instance."""
        with open(self.path(name), "w", encoding="utf-8") as file:
            matrix = {"tasks": [task for task, _ in cells], "solvers": ["riccati", "saltus"], **matrix}
            print(json.dumps({"format": "saltus-bench 1", "saltus": {}, "machine": {}, "packages": {}, "matrix": matrix}), file=file)
            for (task, solver), verdicts in cells.items():
                for instance, verdict in verdicts.items():
                    print(json.dumps({"problem": task, "solver": solver, "instance": instance, "verdict": verdict,
                                      "times": {"wall_us": [1.0], "cpu_us": [1.0]}, **more}), file=file)
                print(json.dumps({"done": task}), file=file)

    def test_compare_counts_the_instances_that_both_have(self):
        key = "box/4x1 cold", "riccati"
        self.records("ten", {key: dict.fromkeys(range(1, 11), "solved")}, {"tolerance": 1e-8})
        self.records("three", {key: dict.fromkeys((1, 2, 3), "solved")}, {"tolerance": 1e-8})
        self.records("lost", {key: {1: "solved", 2: "wrong", 3: "solved"}}, {"tolerance": 1e-8})
        self.records("others", {key: {11: "solved"}}, {"tolerance": 1e-8})
        self.records("crashed", {key: {0: "crashed"}}, {"tolerance": 1e-8})
        self.records("loose", {key: dict.fromkeys(range(1, 11), "solved")}, {"tolerance": 1e-6})
        self.assertIn("0 worse, 0 better", self.bench("compare", "ten", "three").stdout)
        self.assertIn("0 worse, 0 better", self.bench("compare", "three", "ten").stdout)
        self.assertIn("3 of 3 solved, now 2 of 3", self.bench("compare", "ten", "lost", status=1).stdout)
        self.assertIn("10 of 10 solved, now 0 of 1", self.bench("compare", "ten", "crashed", status=1).stdout)
        self.assertIn("have no problem and solver in common", self.bench("compare", "ten", "others", status=2).stderr)
        self.assertIn("different tolerances, 1e-08 and 1e-06", self.bench("compare", "ten", "loose", status=2).stderr)

    def test_compare_reports_losses_of_a_campaign(self):
        self.records("a", {("push 1", "saltus"): {1: "recovered"}}, {"campaign": "pushes"}, drawn={"push.impulse": 5.0})
        self.records("b", {("push 1", "saltus"): {1: "not recovered"}}, {"campaign": "pushes"}, drawn={"push.impulse": 5.0})
        self.records("c", {("push 1", "saltus"): {1: "recovered"}}, {"campaign": "pushes"}, drawn={"push.impulse": 6.0})
        self.assertIn("WORSE  push 1, saltus: 1 of 1 recovered, now 0 of 1", self.bench("compare", "a", "b", status=1).stdout)
        self.assertIn("better push 1", self.bench("compare", "b", "a").stdout)
        self.assertIn("'push 1' has different random draws", self.bench("compare", "a", "c", status=2).stderr)
        self.records("d", {("dart", "saltus"): {1: "as printed"}}, {"campaign": "reproduce"})
        self.records("e", {("dart", "saltus"): {1: "differs"}}, {"campaign": "reproduce"})
        self.assertIn("1 of 1 as printed, now 0 of 1", self.bench("compare", "d", "e", status=1).stdout)

    def test_worst_repetition_is_reported(self):
        sys.path.insert(0, SCRIPTS)
        import task

        class Wavering:
            kkt = iter((1e-10, 1e-3, 1e-10))

            def begin(self, tolerance, setting):
                return {"setup_us": 1.0, "first_us": 1.0}

            def run(self, tolerance, setting):
                return ({"kkt": {"stationarity": next(self.kkt)}, "says_solved": True},
                        {"wall_us": 1.0, "cpu_us": 1.0, "own_us": None})
        results, choice = {1: {"verdict": ""}}, argparse.Namespace(asked=1e-8, setting="own start", default="own start")
        for _ in range(3):
            task.measure({"tolerance": 1e-8}, {1: Wavering()}, results, choice)
        self.assertEqual(results[1]["verdict"], "wrong")
        self.assertEqual(results[1]["kkt"], {"stationarity": 1e-3})
        import figures
        self.assertIsNone(figures.time_of(results[1]))

    def test_nonlinear_problems_are_judged_by_the_program(self):
        self.bench("run", "--problems", "library/brachistochrone,library/switch_of_speed", "--solvers",
                   "riccati,riccati-generic,sparse,ipopt,piqp", "--repetitions", "1", "--out", self.path("n.jsonl"))
        verdicts = [(l["problem"], l["solver"], l["verdict"])
                    for l in self.lines("n.jsonl") if "solver" in l]
        self.assertEqual(len(verdicts), 6)  # PIQP and sizes of quadratic programs do not apply to them
        self.assertEqual({v for *_, v in verdicts}, {"solved"})

    def test_suboptimal_solution_is_a_miss(self):
        sys.path.insert(0, SCRIPTS)
        import task
        answer = {"kkt": {"stationarity": 1e-10}, "objective": 5.0, "optimum": 4.0, "margin": 1e-3,
                  "says_solved": True}
        self.assertEqual(task.verdict(answer, 1e-8), "worse optimum")
        self.assertEqual(task.verdict({**answer, "objective": 4.0005}, 1e-8), "solved")
        self.assertEqual(task.verdict({**answer, "kkt": {"stationarity": 1e-3}}, 1e-8), "wrong")

    @unittest.skipUnless(importlib.util.find_spec("casadi"), "needs casadi")
    def test_casadi_receives_the_same_program(self):
        sys.path.insert(0, SCRIPTS)
        from nonlinear_program import CasadiProgram, read_nonlinear
        from program import Program
        os.environ["SALTUS_PROGRAM"] = PROGRAM
        with Program() as program:
            for name in ("bryson_denham", "juggled_ball", "three_modes", "low_ceiling_arcs"):
                program.ask(do="export", problem="library/" + name, file=self.path("p.json"))
                file = read_nonlinear(self.path("p.json"))
                self.assertLess(CasadiProgram(file).disagreement()[0], 1e-12)
                file.data["checks"][1]["hessian"][0] += 1.0
                self.assertEqual(CasadiProgram(file).disagreement()[1], "hessian")

    PUSHES = ["pushes", "--plant", "centroidal", "--runs", "2", "--seed", "5", "--set", "push.start=0.2",
              "--jobs", "2"]

    @unittest.skipUnless(os.access(os.path.join(os.path.dirname(PROGRAM), "saltus"), os.X_OK),
                         "needs the program saltus")
    def test_pushes_are_the_same_in_shards_and_resumed(self):
        done = self.bench(*self.PUSHES, "--out", self.path("whole.jsonl"))
        self.assertIn("at 95 %", done.stdout)
        self.assertEqual(sum(l.get("verdict") == "recovered" for l in self.lines("whole.jsonl")), 2)
        for part in ("1", "2"):
            self.bench(*self.PUSHES, "--out", self.path(part + ".jsonl"), "--shard", part + "/2")
        self.bench("merge", self.path("1.jsonl"), self.path("2.jsonl"), "--out", self.path("merged.jsonl"))
        self.assertEqual(self.untimed("merged.jsonl"), self.untimed("whole.jsonl"))
        again = self.bench("pushes", "--merged", self.path("merged.jsonl"))
        self.assertEqual(again.stdout, done.stdout)
        with open(self.path("whole.jsonl"), encoding="utf-8") as file:
            text = file.read()
        with open(self.path("cut.jsonl"), "w", encoding="utf-8") as file:
            file.write(text[:text.index("\n", text.index('{"done"')) + 100])
        self.bench(*self.PUSHES, "--out", self.path("cut.jsonl"))
        self.assertEqual(self.untimed("cut.jsonl"), self.untimed("whole.jsonl"))
        self.assertIn("its matrix differs", self.bench(*self.PUSHES, "--seed", "6", "--out", self.path("whole.jsonl"),
                                                       status=2).stderr)
        self.assertIn("LOW:HIGH", self.bench("pushes", "--impulse", "5", status=2).stderr)
        self.assertIn("did you mean 'centroidal'", self.bench("reproduce", "centroid", status=2).stderr)

    @unittest.skipUnless(os.environ.get("SALTUS_ICUB_URDF"), "needs the model of iCub in SALTUS_ICUB_URDF")
    def test_robustness_is_the_same_in_shards_and_resumed(self):
        words = ["robustness", "swing_side_7", "--seeds", "2", "--set", "push.start=0.5"]
        done = self.bench(*words, "--jobs", "2", "--out", self.path("whole.jsonl"))
        self.assertRegex(done.stdout, r"7 N s +2 +[0-2]/2 ")
        self.assertIn("for 2 runs", done.stdout)
        self.assertIn("nothing to run", self.bench(*words, "--out", self.path("whole.jsonl")).stderr)
        self.bench(*words, "--out", self.path("2.jsonl"), "--shard", "2/2")
        with open(self.path("whole.jsonl"), encoding="utf-8") as file:
            text = file.read()
        with open(self.path("cut.jsonl"), "w", encoding="utf-8") as file:
            file.write(text[:text.index("\n", text.index('{"done"')) + 1].replace('"shard": null', '"shard": "1/2"'))
        self.bench("merge", self.path("cut.jsonl"), self.path("2.jsonl"), "--out", self.path("merged.jsonl"))
        self.assertEqual(self.untimed("merged.jsonl"), self.untimed("whole.jsonl"))
        again = self.bench("robustness", "--merged", self.path("merged.jsonl"))
        self.assertEqual(again.stdout.splitlines()[:-1], done.stdout.splitlines()[:-1])  # the last has times

    def robustness_tasks(self, *words):
        sys.path.insert(0, SCRIPTS)
        import bench
        import robustness
        return robustness.tasks_of(bench.parser().parse_args(["robustness", *words]))

    def test_cases_of_robustness_depend_on_their_seed_only(self):
        few, many = (self.robustness_tasks("unknown_ground", "--seeds", count) for count in ("9", "30"))
        self.assertEqual(few, many[:9])
        self.assertEqual([task["drawn"]["condition"] for task in few],
                         ["height", "slope", "half foothold", "soft", "rough", "low friction", "mixed", "height", "slope"])
        self.assertNotEqual(few[0]["words"], few[7]["words"])
        for task in many:
            grounds = [key for key in task["drawn"] if key.startswith("simulator.ground_")]
            self.assertGreaterEqual(len(grounds), 2 if task["drawn"]["condition"] == "mixed" else 1)
        self.assertEqual(len(self.robustness_tasks("two_feet_8", "--seeds", "1")), 16)
        only = self.robustness_tasks("mismatch", "--seeds", "2", "--conditions", "model's mass*", "--set", "drives=ideal")
        self.assertEqual([task["drawn"]["model.mass_error"] for task in only], [-0.1, 0.1, -0.1, 0.1])
        self.assertEqual([word for word in only[0]["words"] if word.startswith("drives")], ["drives=ideal"])
        every = self.robustness_tasks()
        self.assertEqual(len({task["id"] for task in every}), len(every))

    def test_robustness_reports_rates_and_causes(self):
        sys.path.insert(0, SCRIPTS)
        import campaign
        self.assertEqual([f"{bound:.3f}" for bound in campaign.wilson(95, 100)], ["0.888", "0.978"])
        self.assertEqual([f"{bound:.3f}" for bound in campaign.wilson(0, 20)], ["0.000", "0.161"])
        reasons = ("", "fell at 3.50 s; first, at 2.80 s, the angular momentum exceeded 1 Nms",
                   "the left foot slipped by 12 mm", None)
        tasks = [f"mismatch, exact model, seed {k}" for k in range(1, 5)]
        head = {"format": "saltus-bench 1", "saltus": {}, "machine": {}, "packages": {},
                "matrix": {"campaign": "robustness", "tasks": tasks, "solvers": ["saltus"],
                           "commands": [["run", "push_recovery", "--set", f"sensor.seed={k}"] for k in range(1, 5)]}}
        with open(self.path("a"), "w", encoding="utf-8") as file:
            print(json.dumps(head), file=file)
            for k, (task, reason) in enumerate(zip(tasks, reasons), 1):
                line = {"problem": task, "solver": "saltus", "instance": 1, "times": {"cpu_s": 2.0},
                        "drawn": {"experiment": "mismatch", "condition": "exact model", "seed": k, "plant": "dart"}}
                if reason is None:
                    line |= {"verdict": "crashed", "claimed": "saltus ended with status -11"}
                else:
                    line |= {"verdict": "not recovered" if reason else "recovered", "reason": reason,
                             "fell": reason.startswith("fell"), "mass_kg": 10.0, "touchdown_s": 2.7,
                             "landing_force_n": 98.1 * k, "hardware_safe": not reason,
                             "hardware_excesses": ["speed of l_knee", "overlap of a and b", "speed of r_knee"] if reason else []}
                print(json.dumps(line), file=file)
                print(json.dumps({"done": task}), file=file)
        told = self.bench("robustness", "--merged", self.path("a"), status=3).stdout
        for text in ("2/4 50.0 % (15.0 to 85.0)", "1/4 25.0 % (4.6 to 69.9)", "2.00     3.00",
                     "not recovered, fell, first momentum: 1 of 4; for example exact model, seed 2:\n"
                     "  saltus run push_recovery --set sensor.seed=2\n",
                     "not recovered, slipped: 1 of 4", "not recovered, crashed: 1 of 4",
                     "not hardware-safe, joint speed: 2 of 4", "not hardware-safe, limb contact: 2 of 4",
                     "processor time: 8 s for 4 runs"):
            self.assertIn(text, told)
        self.assertIn("did you mean 'swing_side_7'", self.bench("robustness", "swing_side_8", status=2).stderr)
        self.assertIn("no case has a condition 'x'", self.bench("robustness", "--conditions", "x", status=2).stderr)
        self.assertIn("--seeds must be at least 1", self.bench("robustness", "--seeds", "0", status=2).stderr)

    def test_different_table_is_reported_with_skipped_ones(self):
        sys.path.insert(0, SCRIPTS)
        import campaign
        for status, told, verdict in (
                (0, "pictures ...\npictures: as printed\n", "as printed"),
                (3, "b.png: skipped; no program\npictures: 1 differ\n", "differs"),
                (0, "b.png: skipped; no program\npictures: as printed, 1 of 2 skipped\n", "partly skipped"),
                (0, "pictures: skipped; all 2\n", "skipped"), (1, "b.png: skipped; no program\n", "crashed")):
            self.assertEqual(campaign.verdict_on_table("pictures", status, told), verdict)

    def test_explicit_options_override_quick(self):
        for words, instances, repetitions in (([], 3, 1), (["--instances", "1"], 1, 1),
                                              (["--instances", "2", "--repetitions", "2"], 2, 2)):
            out = f"quick{len(words)}.jsonl"
            self.bench("run", "--quick", "--problems", "recipe/no-impact", "--start", "cold", "--solvers", "riccati", *words,
                       "--out", self.path(out))
            matrix = self.lines(out)[0]["matrix"]
            self.assertEqual((matrix["instances"], matrix["repetitions"]), (instances, repetitions))
            self.assertEqual(sum(line.get("solver") == "riccati" for line in self.lines(out)), instances)

    MAP = ["map", "--plant", "centroidal", "--directions", "1", "--impulses", "3", "--step-times", "0.3,0.6", "--set", "push.start=0.2",
           "--jobs", "2"]

    @unittest.skipUnless(os.access(os.path.join(os.path.dirname(PROGRAM), "saltus"), os.X_OK),
                         "needs the program saltus")
    def test_map_has_each_cell_once_and_round_trips(self):
        self.bench(*self.MAP, "--controllers", "none", "--out", self.path("map.jsonl"), "--folder", self.path("map"))
        self.bench("map", "--merged", self.path("map.jsonl"), "--folder", self.path("again"))
        with open(self.path("map/map.csv"), encoding="utf-8") as file:
            rows = file.read().splitlines()
        self.assertEqual(len(rows), 2)  # the header and the one cell
        with open(self.path("again/map.csv"), encoding="utf-8") as file:
            self.assertEqual(file.read().splitlines(), rows)

    def test_map_without_steps_runs_once_for_all_step_times(self):
        sys.path.insert(0, SCRIPTS)
        import argparse
        import campaign
        tasks = campaign.map_tasks(argparse.Namespace(plant="dart", directions=4, impulses="3,4", step_times="0.3,0.6",
                                                      controllers="mpc,none", set=None))
        self.assertEqual([t["id"] for t in tasks], ["mpc 0.3 s 3 N s", "mpc 0.3 s 4 N s", "mpc 0.6 s 3 N s", "mpc 0.6 s 4 N s",
                                                    "none 3 N s", "none 4 N s"])

    def test_unknown_names_are_reported(self):
        for words, sentence in ((["--solvers", "ricati"], "did you mean 'riccati'"),
                                (["--problems", "recipe/kI=8"], "did you mean 'recipe/kI=7'"),
                                (["--problems", "library/brachistochron"],
                                 "did you mean 'library/brachistochrone'"),
                                (["--solvers", "casadi-ipot"], "did you mean 'casadi-ipopt'"),
                                (["--shard", "3/2"], "a shard must be I/N"),
                                (["--instances", "0"], "at least 1"),
                                (["--tolerance", "-1"], "a number above 0"), (["--tolerance", "nan"], "a number above 0"),
                                (["--out", self.path("no/a.jsonl")], "No such file or directory")):
            done = self.bench("run", *words, status=2)
            self.assertIn(sentence, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1)
        for text, sentence in (("", "contains no results"), ("[]\n", "contains no results"),
                               ('{"format": "saltus-bench 0"}\n', "'saltus-bench 0'"),
                           ('{"format": "saltus-bench 1"}\n', "lacks machine, matrix or packages")):
            with open(self.path("bad.jsonl"), "w", encoding="utf-8") as file:
                file.write(text)
            for verb in ("report", "compare"):
                words = ["bad.jsonl"] * (2 if verb == "compare" else 1)
                self.assertIn(sentence, self.bench(verb, *words, status=2).stderr)
            self.assertIn(sentence, self.run_small("bad.jsonl", status=2).stderr)

    def test_results_of_another_kind_are_named(self):
        self.records("run", {("box/4x1 cold", "riccati"): {1: "solved"}},
                     {"tolerance": 1e-8, "instances": 1, "repetitions": 1, "horizons": {"box/4x1 cold": 20}})
        self.records("pushes", {("push 1", "saltus"): {1: "recovered"}}, {"campaign": "pushes"})
        self.records("map", {("none 3 N s", "saltus"): {1: "recovered"}}, {"campaign": "map"})
        self.records("none", {}, {"campaign": "pushes"})
        self.records("half", {("box/4x1 cold", "riccati"): {1: "solved"}}, {})
        for words, sentence in ((["report", "pushes"], "'pushes' contains results of `bench pushes`, not of `bench run`"),
                                (["report", "half"], "its matrix lacks instances"),
                                (["pushes", "--merged", "run"], "'run' contains results of `bench run`, not of `bench pushes`"),
                                (["pushes", "--merged", "pushes"], "a run has no push.impulse"),
                                (["pushes", "--merged", "none"], "there are no runs"),
                                (["map", "--merged", "run"], "'run' contains results of `bench run`, not of `bench map`"),
                                (["map", "--merged", "pushes"], "'pushes' contains results of `bench pushes`, not of `bench map`"),
                                (["map", "--merged", "map"], "there are no cells of the map")):
            done = self.bench(*words, status=2)
            self.assertIn(sentence, done.stderr)
            self.assertEqual(done.stderr.count("\n"), 1)

    def test_edited_results_are_rejected(self):
        self.run_small("a.jsonl")
        with open(self.path("a.jsonl"), encoding="utf-8") as file:
            text = file.read()
        for before, after in (('"verdict": "solved"', '"verdict": 3'), ('"times": {', '"times": 4, "was": {')):
            with open(self.path("b.jsonl"), "w", encoding="utf-8") as file:
                file.write(text.replace(before, after, 1))
            self.assertIn("line 2 is not a result", self.bench("report", "b.jsonl", status=2).stderr)
        with open(self.path("b.jsonl"), "w", encoding="utf-8") as file:
            file.write(text.splitlines(keepends=True)[0])
        self.assertIn("have no problem and solver in common", self.bench("compare", "a.jsonl", "b.jsonl", status=2).stderr)

    def test_results_of_another_run_are_not_mixed(self):
        self.run_small("a.jsonl")
        self.assertIn("its matrix differs",
                      self.run_small("a.jsonl", "--tolerance", "1e-6", status=2).stderr)

    def test_results_of_other_inputs_are_rejected(self):
        """Data, a library and the program file: changes are named, and unchanged files are counted."""
        self.own_problem(-1.0)
        words = ["run", "--problems", "own/one", "--start", "cold", "--solvers", "sparse,hpipm", "--repetitions", "1", "--out", self.path("a.jsonl")]
        own = {"SALTUS_BENCH_PROGRAMS": self.path("own"), "SALTUS_HPIPM": ""}
        self.assertNotIn("already", self.bench(*words, **own).stderr)
        self.assertEqual(list(self.lines("a.jsonl")[0]["inputs"]), ["own/one"])
        self.assertIn(f"1 of 1 tasks are already in '{self.path('a.jsonl')}': nothing to run", self.bench(*words, **own).stderr)
        with open(self.path("libhpipm.so"), "w", encoding="utf-8") as file:
            file.write("no library")
        self.assertIn("its inputs differ (SALTUS_HPIPM)",
                      self.bench(*words, status=2, **{**own, "SALTUS_HPIPM": self.path("libhpipm.so")}).stderr)
        self.own_problem(-2.0)
        self.assertIn("its inputs differ (own/one)", self.bench(*words, status=2, **own).stderr)
        self.own_problem(-1.0)
        head, *lines = self.lines("a.jsonl")
        self.assertEqual(len(head["saltus"]["program"]), 64)
        head["saltus"]["program"] = "another"
        with open(self.path("a.jsonl"), "w", encoding="utf-8") as file:
            file.writelines(json.dumps(line) + "\n" for line in (head, *lines))
        self.assertIn("its saltus differs (program)", self.bench(*words, status=2, **own).stderr)

    def test_shards_of_several_machines_are_reported(self):
        def part(name, task, **more):
            head = {"format": "saltus-bench 1", "saltus": {"commit": "abc", "program": "1"},
                    "machine": {"processor": "A", "processors": 2}, "packages": {"piqp": "1"}, "inputs": {"own/one": "1"},
                    "matrix": {"tasks": ["one", "two"], "solvers": ["riccati"]}}
            result = {"problem": task, "solver": "riccati", "instance": 1, "verdict": "solved", "times": {}}
            with open(self.path(name), "w", encoding="utf-8") as file:
                for line in ({**head, **more}, result, {"done": task}):
                    print(json.dumps(line), file=file)
        part("1", "one")
        part("2", "two")
        self.assertEqual(self.bench("merge", "1", "2", "--out", "whole").stderr, "")
        part("2", "two", machine={"processor": "B", "processors": 2}, saltus={"commit": "abc", "program": "2"})
        done = self.bench("merge", "1", "2", "--out", "whole")
        self.assertIn("different machines (A; B)", done.stderr)
        self.assertIn("different builds of the commit abc", done.stderr)
        self.assertEqual(self.lines("whole")[0]["machine"], {"processor": "A; B", "processors": 2})
        for more, sentence in (({"packages": {"piqp": "2"}}, "its packages differ (piqp)"),
                               ({"inputs": {"own/one": "2"}}, "its inputs differ (own/one)"),
                               ({"saltus": {"commit": "abd", "program": "1"}}, "its saltus differs (commit)")):
            part("2", "two", **more)
            self.assertIn(sentence, self.bench("merge", "1", "2", "--out", "whole", status=2).stderr)

    def test_files_that_a_campaign_depends_on_are_among_its_inputs(self):
        sys.path.insert(0, SCRIPTS)
        import campaign
        import inputs
        with open(self.path("robot.yaml"), "w", encoding="utf-8") as file:
            file.write("name: r\n")
        settings = ["config=" + self.path("robot.yaml"), "push.start=1"]
        self.assertEqual(list(inputs.of_campaign("pushes", settings)), [self.path("robot.yaml")])
        os.environ["SALTUS_PROGRAM"] = PROGRAM
        if os.access(os.path.join(os.path.dirname(PROGRAM), "saltus"), os.X_OK):
            found = inputs.of_campaign("reproduce", None)
            self.assertLess({"README.md", "problems/push_recovery/experiments.md", "docs/results/tables.py"}, set(found))

    def fake_package(self, name, code):
        folder = self.path("fake")
        os.makedirs(os.path.join(folder, f"{name}-9.dist-info"))
        with open(os.path.join(folder, f"{name}-9.dist-info/METADATA"), "w",
                  encoding="utf-8") as file:
            file.write(f"Metadata-Version: 2.1\nName: {name}\nVersion: 9\n")
        with open(os.path.join(folder, name + ".py"), "w", encoding="utf-8") as file:
            file.write(code)
        return folder

    def test_broken_import_is_reported_and_others_continue(self):
        folder = self.fake_package("clarabel", "raise ImportError('no such symbol')\n")
        done = self.run_small("a.jsonl", solvers="riccati,clarabel", status=3, PYTHONPATH=folder)
        self.assertIn("clarabel is broken at import", done.stdout)
        self.assertEqual(sum(l.get("verdict") == "solved" for l in self.lines("a.jsonl")), 4)

    def test_crashing_peer_does_not_affect_others(self):
        folder = self.fake_package("clarabel", "import os\nos.abort()\n")
        self.run_small("a.jsonl", solvers="riccati,clarabel", status=3, PYTHONPATH=folder)
        verdicts = [(l["solver"], l["verdict"]) for l in self.lines("a.jsonl") if "solver" in l]
        self.assertEqual(verdicts.count(("riccati", "solved")), 4)
        self.assertEqual(verdicts.count(("clarabel", "crashed")), 4)

    def test_endless_solver_is_stopped_and_others_continue(self):
        self.run_small("a.jsonl", solvers="riccati,endless", SALTUS_BENCH_PATIENCE="3")
        verdicts = [(l["solver"], l["verdict"]) for l in self.lines("a.jsonl") if "solver" in l]
        self.assertEqual(verdicts.count(("riccati", "solved")), 4)
        self.assertEqual(verdicts.count(("endless", "too slow")), 4)

    def test_wall_time_counts_unless_processor_time_agrees(self):
        sys.path.insert(0, SCRIPTS)
        import figures
        for wall, cpu, counts in ((100.0, 98.0, 98.0), (100.0, 94.0, 100.0), (100.0, 104.0, 104.0), (100.0, 190.0, 100.0),
                                  (2e5, 400.0, 2e5)):
            self.assertEqual(figures.reported(wall, cpu), counts)

    def test_work_outside_of_the_times_is_reported(self):
        sys.path.insert(0, SCRIPTS)
        import figures

        def lines(solver, **times):
            usual = {"wall_us": [2e3], "cpu_us": [2e3], "first_us": 3e3, "reading_us": 100.0}
            return [{"solver": solver, "problem": "p", "times": {**usual, **times}}]
        made = [*lines("usual"), *lines("outside", reading_us=1e5), *lines("remembers", first_us=1e5), *lines("threads", cpu_us=[4e3]),
                *lines("seldom", first_us=1e5), *lines("seldom"), *lines("short", wall_us=[5.0], cpu_us=[9.0], first_us=300.0)]
        self.assertEqual([text.partition(" (")[0] for text in figures.all_remarks(made)], [
            "outside: it works outside of its timed call",
            "remembers: its first solve takes much longer than the next ones of the same program",
            "threads: it uses several processors at a time"])

    def test_judges_agree_despite_rounding_of_large_terms(self):
        sys.path.insert(0, SCRIPTS)
        import numpy
        import task
        from quadratic_program import QuadraticProgram, largest_sum
        one = {"row": [0], "col": [0], "value": [1e9]}
        qp = QuadraticProgram({"problem": "own/one", "instance": 1, "variables": 1, "rows": 1, "hessian": one, "jacobian": one,
                               "gradient": [-1e9], "constant": 0.0, "lower": [None], "upper": [None], "row_lower": [1e9],
                               "row_upper": [None], "stages": []})
        terms = largest_sum(qp, *(numpy.array([v]) for v in (1.0, 0.0, 0.0)))
        self.assertEqual(terms, 2e9)

        def agree(here, there, *more):
            return task.agree({"objective": 1.0, "kkt": {"stationarity": here}}, {"objective": 1.0, "kkt": {"stationarity": there}}, *more)
        self.assertEqual([agree(1e-7, 2e-7), agree(1e-7, 2e-7, terms), agree(1e-7, 1e-3, terms)], [False, True, False])

    def test_published_optima_are_compared(self):
        sys.path.insert(0, SCRIPTS)
        import data_problems
        import numpy
        import published
        os.makedirs(self.path("set/data"))
        for name in ("ONE", "TWO"):
            numpy.savez(self.path(f"set/data/{name}.npz"), P=numpy.eye(2), q=numpy.array([-1.0, 1.0]), lb=numpy.zeros(2))
        with open(self.path("set/data/expected.csv"), "w", encoding="utf-8") as file:
            file.write("ONE.npz,2,0,0,0,-0.5\n")
        before = os.environ.get("SALTUS_REFERENCE_DATA")
        self.addCleanup(lambda: os.environ.__setitem__("SALTUS_REFERENCE_DATA", before or ""))
        os.environ["SALTUS_REFERENCE_DATA"] = self.path("set")
        self.assertEqual(published.drawn(1, 1), ["public/ONE"])
        with self.assertRaisesRegex(ValueError, "only 1 problems have a published optimum"):
            published.drawn(2, 1)
        words = ["check", "--optima", "1", "--solvers", "sparse,toy"]
        told = self.bench(*words).stdout
        self.assertRegex(told, r"public/ONE +2 +0 +-5.0000000e-01 +[0-9.e-]+ +wrong")
        self.assertIn("1 of 1 costs agree with the published optima", told)
        with open(self.path("set/data/expected.csv"), "w", encoding="utf-8") as file:
            file.write("ONE.npz,2,0,0,0,-0.6\n")
        self.assertIn("0 of 1 costs agree", self.bench(*words, status=1).stdout)
        self.assertEqual(data_problems.source_of("public/ONE")[1], -0.6)

    def test_invalid_limit_is_rejected(self):
        for variable, unit in (("SALTUS_BENCH_PATIENCE", "seconds"), ("SALTUS_BENCH_MEMORY", "GB")):
            self.assertIn(f"{variable} must be a number of {unit} above 0, not 'x'",
                          self.run_small("a.jsonl", status=2, **{variable: "x"}).stderr)

    def choice(self, residual, count=10, settings=("own start",)):
        """The choice for a solver whose residual is residual(instance, asked, setting); iterations follow its setting."""
        sys.path.insert(0, SCRIPTS)
        import task
        tried = []

        class Run:
            ladder = task.LADDER

            def __init__(self, number):
                self.number, self.settings = number, list(settings)

            def run(self, asked, setting, is_timed=True):
                tried.append((self.number, asked))
                return {"kkt": {"stationarity": residual(self.number, asked, setting)}, "says_solved": True,
                        "iterations": 30 - 10 * self.settings.index(setting)}, {}
        return task.Choice({number: Run(number) for number in range(1, count + 1)}, 1e-8), tried

    def test_tolerance_has_a_margin_and_is_tightened_until_all_instances_pass(self):
        for factor, asked in ((0.4, 1e-8), (0.98, 1e-9), (9000.0, 1e-12)):
            self.assertAlmostEqual(self.choice(lambda n, tol, s: factor * tol)[0].asked, asked, delta=1e-6 * asked)  # noqa: B023
        # The probes pass, and one other instance misses by 2 %.
        choice, _ = self.choice(lambda n, tol, s: (1.02 if n == 3 else 0.3) * tol)
        self.assertAlmostEqual(choice.asked, 1e-9, delta=1e-15)
        # No tolerance helps one instance: the loosest is kept.
        choice, _ = self.choice(lambda n, tol, s: 1.0 if n == 3 else 0.3 * tol)
        self.assertEqual((choice.asked, choice.is_hopeless), (1e-8, False))
        choice, tried = self.choice(lambda n, tol, s: 1.0)
        self.assertTrue(choice.is_hopeless)
        self.assertEqual({number for number, _ in tried}, {1, 5, 10})

    def test_all_solvers_have_the_same_ladder_and_limits(self):
        sys.path.insert(0, SCRIPTS)
        import matrix
        import task
        for peer in matrix.all_peers():
            # Without a tolerance, or with one of another kind.
            self.assertIn("ladder" in vars(peer), (peer.name in ("casadi-qpoases", "crocoddyl-boxfddp"),), peer.name)
        qp = argparse.Namespace(file="f", instance=1, guess=None)
        of_task = {"problem": "own/one", "start": "cold"}
        self.assertEqual(task.Ours(None, "riccati", of_task, qp, None).ladder, task.LADDER)
        for name in [*os.listdir(SCRIPTS), *(os.path.join("adapters", name) for name in os.listdir(os.path.join(SCRIPTS, "adapters")))]:
            if name.endswith(".py"):
                with open(os.path.join(SCRIPTS, name), encoding="utf-8") as file:
                    self.assertNotRegex(file.read(), "max_cpu_time|CPUtime|time_limit", name)

    def test_our_solvers_have_the_limits_of_the_others(self):
        """A program that does not answer is stopped like any other solver."""
        for name, code, verdict in (("hangs", "time.sleep(1e6)", "too slow"), ("dies", "sys.exit(3)", "crashed")):
            program = self.path(name)
            with open(program, "w", encoding="utf-8") as file:
                file.write(f"#!{sys.executable}\nimport json, os, sys, time\n"
                           "if sys.argv[2] != 'answer':\n"
                           f"    os.execv({sys.executable!r}, [{sys.executable!r}, '-B', {os.path.join(SCRIPTS, 'bench.py')!r}, "
                           "*sys.argv[2:]])\n"
                           "for line in sys.stdin:\n"
                           "    if json.loads(line)['do'] == 'solve':\n"
                           f"        {code}\n"
                           "    print(json.dumps({'version': '1', 'commit': 'c', 'machine': {'cpu': '', 'lanes': 4}, 'build': {},"
                           " 'problems': [], 'solvers': []}), flush=True)\n")
            os.chmod(program, 0o755)
            self.own_problem(-1.0)
            self.bench("run", "--problems", "own/one", "--solvers", "sparse,toy", "--repetitions", "1", "--out", self.path(verdict),
                       status=3 if verdict == "crashed" else 0, SALTUS_PROGRAM=program, SALTUS_BENCH_PATIENCE="3",
                       SALTUS_BENCH_PROGRAMS=self.path("own"))
            verdicts = {line["solver"]: line["verdict"] for line in self.lines(verdict) if "solver" in line}
            self.assertEqual(verdicts, {"sparse": verdict, "toy": "wrong"})

    def test_setting_with_the_fewest_iterations_is_chosen(self):
        choice, _ = self.choice(lambda n, tol, s: 0.3 * tol, settings=("own start", "guess", "guess rolled out"))
        self.assertEqual((choice.default, choice.setting), ("own start", "guess rolled out"))
        self.assertEqual(choice.swept, {"own start": [3, 90], "guess": [3, 60], "guess rolled out": [3, 30]})
        choice, _ = self.choice(lambda n, tol, s: 1.0 if s == "guess" else 0.3 * tol, settings=("own start", "guess"))
        self.assertEqual(choice.setting, "own start")
        # A setting that needs a tighter tolerance is not left out.
        choice, _ = self.choice(lambda n, tol, s: (0.9 if s == "guess" else 0.3) * tol, settings=("own start", "guess"))
        self.assertEqual((choice.setting, round(1e9 * choice.asked, 9)), ("guess", 1.0))

    def staged_program(self):
        """Two intervals of x+ = x + u with 0 <= u <= 1 from x = 1, with a guess and a warm start."""
        entries = {"row": [0, 0, 0, 1, 1, 1], "col": [0, 1, 2, 2, 3, 4], "value": [1.0, 1.0, -1.0] * 2}
        return {"format": "saltus-qp 1", "problem": "own/two", "instance": 1, "variables": 5, "rows": 2,
                "hessian": {"row": [*range(5)], "col": [*range(5)], "value": [1.0] * 5}, "jacobian": entries,
                "gradient": [0.0] * 5, "constant": 0.0, "lower": [1.0, 0.0, None, 0.0, None], "upper": [1.0, 1.0, None, 1.0, None],
                "row_lower": [0.0, 0.0], "row_upper": [0.0, 0.0], "stages": [[1, 1, 0], [1, 1, 0], [1, 0, 0]],
                "guess": [1.0, 0.5, 9.0, 0.25, 9.0],
                "warm": {"w": [1.0, 0.0, 1.0, 0.0, 1.0], "lambda": [2.0, 1.0], "z": [-3.0, -2.0, 0.0, -1.0, 0.0]}}

    def test_starts_of_the_file_are_offered_to_every_solver(self):
        sys.path.insert(0, SCRIPTS)
        import numpy
        import peers
        import task
        from quadratic_program import QuadraticProgram

        class Taker(peers.Adapter):
            given = []

            def __init__(self, qp, tolerance):
                pass

            def run(self):
                self.given.append(self.start)

            def read(self):
                return peers.Answer(numpy.zeros(5), numpy.zeros(2), numpy.zeros(5), "", False, 1)

        class Fixed(Taker):
            takes_start = False

        class Levels(Taker):
            level = 1

            @classmethod
            def warm_levels(cls):
                return 1, 2, 3
        qp = QuadraticProgram(self.staged_program())
        cold, warm = ({"problem": "own/two", "start": start} for start in ("cold", "warm"))
        qp.file, qp.instance = "f", 1
        self.assertEqual(task.Peer(Taker, cold, qp, None).settings, ["own start", "guess", "guess rolled out"])
        self.assertEqual(task.Ours(None, "sparse", cold, qp, None).settings, ["own start", "guess", "guess rolled out"])
        self.assertEqual(task.Peer(Taker, warm, qp, None).settings, ["warm", "own start"])
        self.assertEqual(task.Ours(None, "sparse", warm, qp, None).settings, ["warm", "own start"])
        self.assertEqual(task.Peer(Levels, warm, qp, None).settings, ["level 1", "level 2", "level 3", "own start"])
        self.assertEqual(task.Peer(Fixed, warm, qp, None).settings, ["own start"])
        self.assertEqual(task.Peer(Taker, cold, qp, None).ladder, task.LADDER)
        run = task.Peer(Taker, cold, qp, lambda step: None)
        for setting, w in (("guess", [1.0, 0.5, 9.0, 0.25, 9.0]), ("guess rolled out", [1.0, 0.5, 1.5, 0.25, 1.75])):
            run.begin(1e-8, setting)
            self.assertEqual(Taker.given[-1][0].tolist(), w)
        run = task.Peer(Levels, warm, qp, lambda step: None)
        for level in (1, 2, 3):
            run.begin(1e-8, f"level {level}")
            self.assertEqual(run.solver.level, level)
            self.assertEqual(Taker.given[-1][1].tolist(), [2.0, 1.0])

    def test_hpipm_receives_the_multipliers_of_a_warm_start(self):
        sys.path.insert(0, SCRIPTS)
        import numpy
        import hpipm

        class Library:
            def __init__(self):
                self.got = []

            def sol_set(self, name, stage, value, _):
                import ctypes
                self.got.append((name.decode(), stage.value, ctypes.cast(value, ctypes.POINTER(ctypes.c_double))[0]))

            def ipm_solve(self, *_):
                self.got.append("solve")

            def ipm_arg_set(self, name, value, _):
                self.got.append((name.decode(), value._obj.value))
        one = numpy.array([0])
        stage = argparse.Namespace(x=slice(0, 1), u=slice(1, 2), dynamics=slice(0, 1), rows=slice(1, 2), bounded_x=one, bounded_u=one)
        solver = hpipm._Hpipm.__new__(hpipm._Hpipm)
        solver.stages, solver.sol, solver.arg, solver.qp, solver.ws = [stage], None, None, None, None
        point = tuple(map(numpy.array, ([3.0, 4.0], [5.0, -6.0], [7.0, -8.0])))
        states, pushes = [("x", 0, 3.0), ("u", 0, 4.0)], [
            ("pi", 0, 5.0), ("lam_lg", 0, 6.0), ("lam_ug", 0, 0.0), ("lam_lbx", 0, 0.0), ("lam_ubx", 0, 7.0), ("lam_lbu", 0, 8.0),
            ("lam_ubu", 0, 0.0)]
        # A start without an iteration computes the slacks; otherwise those of the previous solve would help.
        warm = [*states, ("warm_start", 1), ("iter_max", 0), "solve", ("iter_max", hpipm.ITERATIONS), *states, *pushes]
        for start, level, expected in ((None, 0, []), (point, 1, states), (point, 2, warm), (point, 3, warm)):
            solver.f, solver.level = Library(), level or 1
            solver.hand_over(start)
            self.assertEqual(solver.f.got, [*expected, ("warm_start", level)])

    def test_profile_counts_only_instances_to_which_a_solver_applies(self):
        sys.path.insert(0, SCRIPTS)
        import records
        import scores
        import table

        def line(problem, start, solver, instance, verdict, us=1.0):
            return {"problem": problem, "start": start, "solver": solver, "instance": instance, "verdict": verdict,
                    "times": {"wall_us": [us], "cpu_us": [us]}}
        tasks = {"a cold": [*(line("a", "cold", "one", i, "solved") for i in (1, 2)), line("a", "cold", "two", 1, "solved", 3.0),
                            line("a", "cold", "two", 2, "wrong"), line("a", "cold", "three", 1, "wrong")],
                 "b cold": [*(line("b", "cold", "one", i, "solved") for i in (1, 2)), line("b", "cold", "two", 0, "not applicable"),
                            line("b", "cold", "three", 0, "missing")],
                 "a warm": [line("a", "warm", "one", 1, "solved")]}
        run = records.Records({"matrix": {"solvers": ["one", "two", "three"]}}, tasks)
        self.assertEqual(table.groups(run), [("quadratic programs, cold", ["a cold", "b cold"]),
                                             ("quadratic programs, warm", ["a warm"])])
        grid, found = scores.curves(run, ["a cold", "b cold"], ["one", "two", "three"], is_relative=True)
        self.assertEqual({name: (share[0], share[grid < 2.9].max(), share[-1]) for name, (share, *_) in found.items()},
                         {"one": (1.0, 1.0, 1.0), "two": (0.0, 0.0, 0.5), "three": (0.0, 0.0, 0.0)})

    def test_public_programs_need_no_table_of_optima(self):
        sys.path.insert(0, SCRIPTS)
        import data_problems
        import numpy
        os.makedirs(self.path("set/data"))
        numpy.savez(self.path("set/data/ONE.npz"), P=numpy.eye(2), q=numpy.array([-1.0, 1.0]), lb=numpy.zeros(2),
                    ub=numpy.full(2, 4.0))
        numpy.savez(self.path("set/TWO.npz"), q=numpy.zeros(1))
        before = os.environ.get("SALTUS_REFERENCE_DATA")
        self.addCleanup(lambda: os.environ.__setitem__("SALTUS_REFERENCE_DATA", before or ""))
        os.environ["SALTUS_REFERENCE_DATA"] = self.path("set")
        self.assertEqual([p["name"] for p in data_problems.described() if p["name"].startswith("public/")],
                         ["public/ONE", "public/TWO"])
        data_problems.write("public/ONE", 1, self.path("one.json"))
        with open(self.path("one.json"), encoding="utf-8") as file:
            self.assertIsNone(json.load(file)["optimum"])
        with self.assertRaisesRegex(ValueError, "TWO.npz' has no matrix or vector 'P"):
            data_problems.write("public/TWO", 1, self.path("two.json"))
        with open(self.path("set/data/expected.csv"), "w", encoding="utf-8") as file:
            file.write("# name,,,,,optimum\nONE.npz,2,0,0,0,-0.5\n")
        data_problems.write("public/ONE", 1, self.path("one.json"))
        with open(self.path("one.json"), encoding="utf-8") as file:
            self.assertEqual(json.load(file)["optimum"], -0.5)
        with open(self.path("set/data/expected.csv"), "a", encoding="utf-8") as file:
            file.write("TWO.npz,2\n")
        with self.assertRaisesRegex(ValueError, "line 3: its sixth column must be the known optimum"):
            data_problems.described()

    @unittest.skipUnless(importlib.util.find_spec("scipy"), "needs scipy")
    def test_public_programs_in_matlab_files_are_read(self):
        sys.path.insert(0, SCRIPTS)
        import quadratic_files
        import numpy
        import scipy.io
        import scipy.sparse as sparse
        scipy.io.savemat(self.path("QP.mat"), {
            "P": sparse.csc_matrix([[2.0, 1.0], [1.0, 3.0]]), "q": [[1.0], [2.0]], "r": 7.0,
            "A": sparse.csc_matrix([[1.0, 1.0], [1.0, 0.0], [0.0, 1.0]]), "l": [[1.0], [0.0], [-1e20]], "u": [[1.0], [1e20], [5.0]]})
        program = quadratic_files.from_mat("public/QP", self.path("QP.mat"))
        self.assertEqual([program[key] for key in ("variables", "rows", "constant", "lower", "upper", "row_lower", "row_upper")],
                         [2, 1, 7.0, [0.0, None], [None, 5.0], [1.0], [1.0]])
        self.assertEqual(sorted(program["hessian"]["value"]), [1.0, 2.0, 3.0])

    def test_forecast_is_within_20_percent_after_the_first_task(self):
        sys.path.insert(0, SCRIPTS)
        import forecast
        import io
        seconds = {f"t{i} cold": {"a": 0.02 * 3 ** (i % 5), "b": 0.5 if i == 7 else 0.01} for i in range(20)}
        tasks = [{"id": name, "solvers": ["a", "b"], "instances": [1, 2], "repetitions": 3} for name in seconds]
        work = forecast.expected(tasks, seconds)
        now, stream = [0.0], io.StringIO()
        progress = forecast.Progress(work, 0, stream, now=lambda: now[0])
        truth = {task: 2.7 * of * (1.1 if number % 2 else 0.9) for number, (task, of) in enumerate(work.items())}
        for task, took in truth.items():
            now[0] += took
            progress.tell(task)
            remaining = sum(truth.values()) - now[0]
            self.assertLess(abs(progress.left() - remaining), 0.2 * sum(truth.values()), task)
        self.assertIn("20 of 20 (100 %), t19 cold; ", stream.getvalue())
        self.assertIn("recipe/kI=7 cold", forecast.known_seconds())  # of the first run of a user
        forecast.learn("recipe/kI=7 cold", {"riccati": 7.0})
        self.assertEqual(forecast.known_seconds()["recipe/kI=7 cold"], {"riccati": 7.0})
        # A solver without a record takes its median on other tasks.
        self.assertEqual(forecast.expected([{"id": "new", "solvers": ["b"], "instances": [1], "repetitions": 1}], seconds),
                         {"new": 0.02})

    def test_missing_library_is_named(self):
        for library, sentence in (("", "SALTUS_HPIPM names no library"), ("/no.so", "there is no library '/no.so'")):
            done = self.run_small(f"a{len(library)}.jsonl", solvers="riccati,hpipm", SALTUS_HPIPM=library)
            self.assertIn(sentence, done.stdout)

    def test_uncoupled_nonlinear_program_splits_into_stages(self):
        sys.path.insert(0, SCRIPTS)
        from fatrop import Stages
        from nonlinear_program import read_nonlinear
        from peers import NotApplicable
        from program import Program
        os.environ["SALTUS_PROGRAM"] = PROGRAM
        with Program() as program:
            found = {}
            for name in ("tank_on_ramp", "hanging_chain", "bryson_denham", "brachistochrone"):
                program.ask(do="export", problem="library/" + name, file=self.path("p.json"))
                try:
                    found[name] = Stages(read_nonlinear(self.path("p.json")))
                except NotApplicable as why:
                    self.assertIn("coupled", str(why))
        self.assertEqual(set(found), {"tank_on_ramp", "hanging_chain"})  # the durations of the others are free
        self.assertEqual(found["tank_on_ramp"].sizes, [[0, 3, 2], *[[2, 1, 0]] * 399, [2, 0, 0]])
        # The end of a linear input is the start of the next. A row that closes with the other sign is an error.
        self.assertEqual(set(found["hanging_chain"].sign), {1.0, -1.0})
        self.assertEqual(sorted(found["hanging_chain"].order), list(range(123)))

    def written(self, problem, instance=12):
        """The quadratic program that all solvers read."""
        sys.path.insert(0, SCRIPTS)
        import data_problems
        from program import Program
        from quadratic_program import read_program
        os.environ["SALTUS_PROGRAM"] = PROGRAM
        if data_problems.is_data(problem):
            data_problems.write(problem, instance, self.path("p.json"))
        else:
            with Program() as program:
                program.ask(do="export", problem=problem, instance=instance, file=self.path("p.json"))
        return read_program(self.path("p.json"))

    @unittest.skipUnless(importlib.util.find_spec("scipy"), "needs scipy")
    def test_trajectory_splits_and_joins(self):
        for problem in ("sequence", "steps/chain", "steps/car"):
            qp = self.written(problem)
            from trajectories import Trajectory
            trajectory = Trajectory(qp)
            w, rows, bounds = (qp.warm[key] for key in ("w", "lambda", "z"))
            states, inputs = trajectory.split(w)
            again = trajectory.joined(states, inputs)
            self.assertTrue((again == w).all())
            costates, pushes = trajectory.split_multipliers(rows, bounds)
            rows_again, bounds_again = trajectory.joined_multipliers(w, costates, pushes)
            self.assertTrue((rows_again == rows).all())
            first = qp.stages[0][0]
            self.assertTrue((bounds_again[first:] == bounds[first:]).all())
            for s, (C, D, low, high), x, u in zip(trajectory.stages, trajectory.rows, states, [*inputs, []]):
                self.assertEqual(len(low), len(C @ x + D @ u))
                self.assertTrue((low < high).all())
        with self.assertRaisesRegex(Exception, "no stages"):
            qp.stages = None
            Trajectory(qp)

    def test_solvers_do_not_depend_on_earlier_solves(self):
        """Installed solvers need the same iterations to the same point in repeated solves."""
        import numpy
        asked = 0
        for problem, is_warm in (("steps/chain", False), ("steps/car", True), ("box/4x1", False)):
            qp = self.written(problem)
            import peers
            for adapter in peers.all_peers():
                if adapter.name == "aligator-proxddp" or peers.why_missing(adapter):
                    continue  # the first includes compilation at first use, which is slow
                try:
                    solver = adapter(qp, 1e-8)
                except peers.NotApplicable:
                    continue
                reduced = getattr(solver, "reduced", None) or getattr(getattr(solver, "rows", None), "reduced", None)
                start = None
                if is_warm:
                    start = tuple(qp.warm[key] for key in ("w", "lambda", "z"))
                    start = reduced.restrict(start) if reduced else start
                first, second = solver.solve(start), solver.solve(start)
                self.assertEqual(first.iterations, second.iterations, f"{adapter.name} on {problem}")
                self.assertLess(numpy.abs(first.w - second.w).max(), 1e-9, f"{adapter.name} on {problem}")
                asked += 1
        if not asked:
            self.skipTest("no peers are installed")

    @unittest.skipUnless(importlib.util.find_spec("casadi"), "needs casadi")
    def test_front_ends_receive_our_discretisation(self):
        """The function of one interval maps states in the same way as the rows of the whole program."""
        import numpy
        sys.path.insert(0, SCRIPTS)
        import peers
        from front_ends import Intervals
        from nonlinear_program import CasadiProgram, read_nonlinear
        from program import Program
        os.environ["SALTUS_PROGRAM"] = PROGRAM
        with Program() as program:
            for name in ("tank_on_ramp", "hanging_chain"):
                program.ask(do="export", problem="library/" + name, file=self.path(name))
        with self.assertRaises(peers.NotApplicable):
            Intervals(read_nonlinear(self.path("hanging_chain")))  # its final state is fixed
        file = read_nonlinear(self.path("tank_on_ramp"))
        it, draws = Intervals(file), numpy.random.default_rng(1)
        inputs = draws.uniform(it.low, it.high, (it.N, it.nu))
        states, cost = [it.start], 0.0
        for k in range(it.N):
            following, more = it.step(states[k], inputs[k], it.numbers[k])
            states.append(numpy.array(following).ravel())
            cost += float(more)
        functions = CasadiProgram(file).functions
        w = it.joined(numpy.array(states), inputs)
        rows = numpy.array(functions["nlp_g"](w, [])).ravel()
        self.assertLess(numpy.abs(rows - file.row_lower).max(), 1e-12)
        self.assertAlmostEqual(float(functions["nlp_f"](w, [])), cost, delta=1e-12)

    def test_multiplier_without_active_bound_counts(self):
        """min 1/2 w^2 - w with 0 <= w without upper bound and a row -1 <= w without upper bound: the optimum is 1,
        without active bounds."""
        import numpy
        sys.path.insert(0, SCRIPTS)
        from quadratic_program import QuadraticProgram, kkt_residual
        entry = {"row": [0], "col": [0], "value": [1.0]}
        qp = QuadraticProgram({"problem": "own/one", "instance": 1, "variables": 1, "rows": 1, "hessian": entry, "jacobian": entry,
                               "gradient": [-1.0], "constant": 0.0, "lower": [0.0], "upper": [None], "row_lower": [-1.0],
                               "row_upper": [None], "stages": []})

        def largest(w, row, bound):
            return max(kkt_residual(qp, *(numpy.array([v]) for v in (w, row, bound))).values())
        self.assertEqual(largest(1.0, 0.0, 0.0), 0.0)
        self.assertEqual(largest(0.5, 0.0, 0.5), 0.5)  # nonzero multiplier of a missing bound
        self.assertEqual(largest(0.5, 0.5, 0.0), 0.5)
        self.assertEqual(largest(2.0, 0.0, -1.0), 2.0)  # nonzero multiplier of a bound at distance two
        self.assertEqual(largest(-0.5, 0.0, 0.0), 1.5)
        for wrong in ((numpy.nan, 0.0, 0.0), (1.0, numpy.nan, 0.0), (1.0, 0.0, numpy.inf)):
            self.assertEqual(largest(*wrong), numpy.inf)

    def cluster(self, behaviour, tasks, workers=("tcp://a:1", "tcp://b:1", "tcp://c:1")):
        """Runs the tasks on workers that behave like `behaviour(worker, task, attempt)`: a status of a future, or an outcome.
        Returns (the tasks that have results, sentences, error)."""
        sys.path.insert(0, SCRIPTS)
        import engine
        os.environ["SALTUS_PROGRAM"] = PROGRAM
        attempts = {}

        class Future:
            def __init__(self, key, task, worker):
                self.key, attempts[task["id"]] = key, attempts.get(task["id"], 0) + 1
                told = behaviour(worker, task["id"], attempts[task["id"]])
                self.status = told if isinstance(told, str) else "finished"
                self.outcome = {"host": "host of " + worker, "worker": worker, "seconds": 0.1, "error": "", **dict(
                    told if isinstance(told, dict) else {})}

            def add_done_callback(self, call):
                call(self)

            def result(self, timeout):
                return self.outcome

            def exception(self):
                return RuntimeError()

            def release(self):
                pass

        class Client:
            status, count = "running", 0

            def nthreads(self):
                return dict.fromkeys(workers, 1)

            def submit(self, function, program, task, pure, workers):
                self.count += 1
                allowed = sorted(workers or self.nthreads())
                return Future(self.count, task, allowed[self.count % len(allowed)])
        got, told, error = [], [], ""
        cluster = engine.Cluster([{"id": task} for task in tasks], told.append)
        try:
            cluster.run(Client(), lambda task, lines: got.append((task["id"], len(lines))))
        except engine.EngineError as why:
            error = str(why)
        return got, told, error, cluster

    @staticmethod
    def good(task):
        return {"status": 0, "lines": json.dumps({"solver": "s"}) + "\n" + json.dumps({"done": task}) + "\n"}

    def test_lost_tasks_are_repeated_with_a_limit(self):
        tasks = [f"t{i}" for i in range(20)]

        def dies_once(worker, task, attempt):
            return "lost" if task in ("t3", "t7") and attempt == 1 else self.good(task)
        got, told, error, cluster = self.cluster(dies_once, tasks)
        self.assertEqual((sorted(got), told, error), (sorted((task, 1) for task in tasks), [], ""))

        def dies_always(worker, task, attempt):
            return "lost" if task == "t3" else self.good(task)
        got, told, error, cluster = self.cluster(dies_always, tasks)
        self.assertEqual((len(got), cluster.given_up), (19, ["t3"]))
        self.assertEqual(told, ["the task 't3' is given up after 3 attempts: its worker died"])

    def test_workers_that_cannot_run_tasks_are_quarantined(self):
        tasks = [f"t{i}" for i in range(20)]
        for status, sentence in ((127, "the program 'p' cannot be started"), (2, "No module named 'numpy'")):
            def bad_node(worker, task, attempt, status=status, sentence=sentence):
                return {"status": status, "lines": "", "error": sentence} if worker == "tcp://b:1" else self.good(task)
            got, told, error, _ = self.cluster(bad_node, tasks)
            self.assertEqual((sorted(got), error), (sorted((task, 1) for task in tasks), ""))
            self.assertEqual(told, [f"the worker tcp://b:1 on host of tcp://b:1 is not used any more: {sentence}; its tasks go to "
                                    "others"])
            got, told, error, _ = self.cluster(bad_node, tasks, ("tcp://b:1",))
            self.assertEqual((got, error), ([], f"no usable worker is left: tcp://b:1: {sentence}"))

    @unittest.skipUnless(importlib.util.find_spec("distributed"), "needs distributed")
    def test_dask_survives_killed_workers_and_scheduler(self):
        sys.path.insert(0, SCRIPTS)
        import engine
        import random
        program, port, children = self.path("program"), 20000 + os.getpid() % 20000, {}
        with open(program, "w", encoding="utf-8") as file:
            file.write(f"#!{sys.executable} -S\nimport json, sys, time\ntime.sleep(0.05)\ntask = json.loads(sys.argv[3])['id']\n"
                       "print(json.dumps({'solver': 's'}))\nprint(json.dumps({'done': task}))\n")
        os.chmod(program, 0o755)

        def start(name):
            words = (["scheduler", "--host", "127.0.0.1", "--port", str(port), "--no-dashboard"] if name == "scheduler" else
                     ["worker", f"tcp://127.0.0.1:{port}", "--host", "127.0.0.1", "--nthreads", "1", "--no-dashboard", "--no-nanny",
                      "--local-directory", self.path(name)])
            children[name] = subprocess.Popen([sys.executable, "-m", f"distributed.cli.dask_{words[0]}", *words[1:]],
                                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, cwd=self.folder)

        def end(name):
            children[name].kill()
            children[name].wait()
        self.addCleanup(lambda: [end(name) for name in children])
        before = os.environ.get("SALTUS_PROGRAM", "")
        self.addCleanup(lambda: os.environ.__setitem__("SALTUS_PROGRAM", before))
        os.environ["SALTUS_PROGRAM"] = program
        names, draws, got = ["a", "b", "c"], random.Random(1), []
        for name in ("scheduler", *names):
            start(name)

        def take(task, lines):
            got.append((task["id"], len(lines)))
            if len(got) == 60:
                for name in ("scheduler", *names):
                    end(name)
                for name in ("scheduler", *names):
                    start(name)
            elif len(got) % 15 == 0:
                name = draws.choice(names)
                end(name)
                start(name)
        tasks = [{"id": f"t{i}", "problem": "p", "solvers": ["s"]} for i in range(120)]
        engine.run_on_cluster(tasks, take, f"tcp://127.0.0.1:{port}")
        self.assertEqual(sorted(got), sorted((task["id"], 1) for task in tasks))

    def test_dead_program_of_a_task_is_a_crash_here_and_repeated_elsewhere(self):
        def dies_once(worker, task, attempt):
            return {"status": -9, "lines": "", "error": ""} if task == "t1" and attempt == 1 else self.good(task)
        got, told, error, _ = self.cluster(dies_once, ["t1", "t2"])
        self.assertEqual((sorted(got), told, error), ([("t1", 1), ("t2", 1)], [], ""))
        import engine
        lines = engine.results_here({"id": "t", "problem": "p", "solvers": ["a", "b"]}, {"status": -9, "lines": "", "error": "no"})
        self.assertEqual([(line["solver"], line["verdict"], line["claimed"]) for line in lines],
                         [(name, "crashed", "the task ended with status -9: no") for name in ("a", "b")])

    def test_task_that_fails_everywhere_is_an_error(self):
        def invalid(worker, task, attempt):
            return {"status": 2, "lines": "", "error": "no such problem"} if task == "t5" else self.good(task)
        got, _, error, _ = self.cluster(invalid, [f"t{i}" for i in range(20)])
        self.assertEqual(error, "no such problem")
        self.assertGreaterEqual(len(got), 1)

    def test_missing_scheduler_gives_a_sentence(self):
        done = self.run_small("a.jsonl", "--scheduler", "tcp://127.0.0.1:9", status=2)
        self.assertRegex(done.stderr, "no Dask scheduler answers|--scheduler needs Dask")

    @unittest.skipUnless(importlib.util.find_spec("matplotlib"), "needs matplotlib")
    def test_report_is_one_file_with_its_pictures(self):
        self.run_small("a.jsonl", solvers="riccati,toy")
        self.bench("report", "a.jsonl")
        with open(self.path("a.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertGreaterEqual(page.count("<svg"), 3)
        self.assertNotIn("src=", page)
        self.assertIn("<td>toy</td><td>4</td><td>0</td><td>4</td>", page)

    @unittest.skipUnless(importlib.util.find_spec("matplotlib"), "needs matplotlib")
    def test_report_escapes_file_contents(self):
        self.run_small("a.jsonl", solvers="riccati,toy")
        with open(self.path("a.jsonl"), encoding="utf-8") as file:
            head, *lines = file.read().splitlines()
        head, spell = json.loads(head), "<script>alert(1)</script>"
        head["saltus"] = {key: spell for key in head["saltus"]}
        head["machine"] = {key: spell for key in head["machine"]}
        head["packages"] = {key: spell for key in head["packages"]}
        head["matrix"] |= {"instances": spell, "repetitions": spell}
        with open(self.path("a.jsonl"), "w", encoding="utf-8") as file:
            file.write("\n".join([json.dumps(head), *lines]) + "\n")
        self.bench("report", "a.jsonl")
        with open(self.path("a.html"), encoding="utf-8") as file:
            page = file.read()
        self.assertNotIn(spell, page)
        self.assertIn("&lt;script&gt;alert(1)", page)


if __name__ == "__main__":
    if importlib.util.find_spec("numpy") is None:
        print("skipped: numpy is not installed (Debian: python3-numpy)")
        sys.exit(77)
    unittest.main()
