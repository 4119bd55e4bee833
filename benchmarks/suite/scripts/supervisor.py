"""Runs the solvers of one task in a process group of its own, with limits of wall time and memory.

The process of the solvers reports over a pipe that only it and this process have. Every message starts with a random
word, so text that a solver prints is never a message. A message that begins a step, {"trying": SOLVER, "step": STEP},
starts the clock of that step. A step that exceeds its limit ends the group. So does a solver that ends its process.
Then the task runs again without that solver.
"""

import collections
import contextlib
import fcntl
import json
import os
import resource
import secrets
import select
import signal
import socket
import subprocess
import sys
import tempfile
import time

from cache import cache_folder
from package import adopt_orphans, children_of, end_children, end_with_parent
from program import ProgramError

LIMITS = {"import": 60.0, "set-up": 600.0, "solve": 10.0, "task": 7200.0, "memory": 8.0}  # wall seconds; GB
VARIABLES = {"solve": "SALTUS_BENCH_PATIENCE", "import": "SALTUS_BENCH_IMPORT_LIMIT", "set-up": "SALTUS_BENCH_SETUP_LIMIT",
             "task": "SALTUS_BENCH_TASK_LIMIT", "memory": "SALTUS_BENCH_MEMORY"}
LOOK_EVERY = 0.2  # s between two looks at the memory
SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "bench.py")


def limits():
    """LIMITS with those of the environment. Raises ValueError with one sentence."""
    found = dict(LIMITS)
    for name, variable in VARIABLES.items():
        text = os.environ.get(variable)
        try:
            found[name] = float(text) if text else found[name]
            if not 0.0 < found[name] < float("inf"):
                raise ValueError
        except ValueError:
            unit = "GB" if name == "memory" else "seconds"
            raise ValueError(f"{variable} must be a number of {unit} above 0, not '{text}'") from None
    return found


class Channel:
    """The end of the pipe in the process of the solvers."""

    def __init__(self, number, word):
        self.pipe, self.word = os.fdopen(number, "w", encoding="utf-8"), word

    def say(self, line):
        self.pipe.write(f"\n{self.word} {json.dumps(line)}\n")  # even if a solver has written an unfinished line
        self.pipe.flush()

    def step(self, solver, step):
        self.say({"trying": solver, "step": step})


def receive():
    """(task, channel) in the process of the solvers. Afterwards its standard streams lead nowhere."""
    order = json.loads(sys.stdin.buffer.readline())
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in (0, 1):
        os.dup2(nowhere, stream)
    os.set_inheritable(order["pipe"], False)
    return order["task"], Channel(order["pipe"], order["word"])


def resident_gb(process):
    """Memory of a process and its children in GB; 0 on systems without /proc."""
    pages = 0
    for one in (process, *children_of(process)):
        try:
            with open(f"/proc/{one}/statm", encoding="ascii") as file:
                pages += int(file.read().split()[1])
        except (OSError, IndexError):
            continue
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e9


def processor_seconds(process):
    """Processor time of a process and its children; 0 on systems without /proc."""
    ticks = 0
    for one in (process, *children_of(process)):
        try:
            with open(f"/proc/{one}/stat", encoding="ascii", errors="replace") as file:
                ticks += sum(map(int, file.read().rpartition(")")[2].split()[11:15]))  # user, system, and of ended children
        except (OSError, ValueError):
            continue
    return ticks / os.sysconf("SC_CLK_TCK")


class Attempt:
    """One run of the task. `lines`: its results; `trying`, `step`: what it did last; `cause`: (verdict, sentence) if it
    did not end by itself. Adds the processor seconds of each solver to `spent`, and of the rest to spent[None]."""

    def __init__(self, task, spent):
        self.lines, self.is_done, self.trying, self.step, self.cause = [], False, None, "task", None
        self.has_begun = False
        self.limits, self.spent, self.counted = task["limits"], spent, 0.0
        used_before = _seconds_of_ended()
        self.word = secrets.token_hex(16)
        reader, writer = os.pipe()
        with tempfile.TemporaryFile() as errors:
            child = self.child = subprocess.Popen([sys.executable, "-B", SCRIPT, "task", "--solvers"], stdin=subprocess.PIPE,
                                     stdout=subprocess.DEVNULL, stderr=errors, pass_fds=(writer,), start_new_session=True,
                                     preexec_fn=end_with_parent)
            os.close(writer)
            try:
                child.stdin.write(json.dumps({"task": task, "word": self.word, "pipe": writer}).encode() + b"\n")
                child.stdin.close()
                self._listen(child, reader)
            except BrokenPipeError:
                pass  # it ended before it read the task
            finally:
                os.close(reader)
                if self.cause is None and self.is_done:
                    try:
                        child.wait(LOOK_EVERY)  # close its own children
                    except subprocess.TimeoutExpired:
                        pass
                try:
                    os.killpg(child.pid, signal.SIGKILL)
                except ProcessLookupError:
                    pass
                self.status = child.wait()
                end_children()  # also those that have left the group
            self._count(_seconds_of_ended() - used_before)
            errors.seek(0)
            self.errors = errors.read()[-2000:].decode(errors="replace").strip()
        if self.cause is None and not self.is_done:
            self.cause = "crashed", f"it ended its process with {how(self.status)} during its {self.step}"

    def _listen(self, child, reader):
        begin = time.monotonic()
        last, text = begin, b""
        while not self.is_done:
            now = time.monotonic()
            allowed = min(last + self.limits.get(self.step, self.limits["task"]), begin + self.limits["task"])
            if now > allowed:
                step = self.step if allowed < begin + self.limits["task"] else "task"
                self.cause = "too slow", f"its {step} took longer than its limit of {self.limits[step]:g} s"
                return
            if resident_gb(child.pid) > self.limits["memory"]:
                self.cause = "out of memory", f"its {self.step} needed more than its limit of {self.limits['memory']:g} GB"
                return
            if not select.select([reader], [], [], min(LOOK_EVERY, allowed - now + 1e-3))[0]:
                if child.poll() is not None:
                    return  # its children may have the pipe
                continue
            data = os.read(reader, 1 << 16)
            if not data:
                child.wait()
                return
            *whole, text = (text + data).split(b"\n")
            for message in filter(None, map(self._message, whole)):
                last, self.has_begun = time.monotonic(), True
                self._take(message)

    def _message(self, text):
        word, _, content = text.decode(errors="replace").partition(" ")
        return json.loads(content) if secrets.compare_digest(word.encode(), self.word.encode()) else None

    def _count(self, used):
        """Attributes processor time since the last count to the solver that is tried."""
        self.spent[self.trying] = self.spent.get(self.trying, 0.0) + max(0.0, used - self.counted)
        self.counted = max(self.counted, used)

    def _take(self, message):
        if "trying" in message:
            if message["trying"] != self.trying:
                self._count(processor_seconds(self.child.pid))
            self.trying, self.step = message["trying"], message["step"]
        elif "error" in message:
            raise ProgramError(message["error"])
        elif "done" in message:
            self.is_done = True
        else:
            self.lines.append(message)


def _seconds_of_ended():
    """Processor time of the ended children of this process."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def how(status):
    """How a process ended: `status 3` or `SIGABRT`."""
    try:
        return signal.Signals(-status).name if status < 0 else f"status {status}"
    except ValueError:
        return f"signal {-status}"


def machine():
    """Host and processor, which every line of a result names."""
    processor = ""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            processor = next((line.partition(":")[2].strip() for line in file if line.startswith("model name")), "")
    except OSError:
        pass
    return {"host": socket.gethostname(), "processor": processor}


@contextlib.contextmanager
def one_at_a_time():
    """A lock, so timed tasks run one at a time on a machine."""
    name = f"timing-{socket.gethostname()}.lock"  # home folders may be shared by machines
    with open(os.path.join(cache_folder(), name), "a", encoding="utf-8") as file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def carry_out(task):
    """The lines of the task, in the order of instances and solvers. Ends all descendants of this process."""
    spent = {}
    adopt_orphans()
    with one_at_a_time():
        lines = attempts(task, spent)
    counts = collections.Counter(line["solver"] for line in lines)
    shared = spent.get(None, 0.0) / max(1, len(lines))  # start of the process, reading of the problem
    for line in lines:
        line.setdefault("times", {})["spent_s"] = round(spent.get(line["solver"], 0.0) / counts[line["solver"]] + shared, 3)
    order = {name: i for i, name in enumerate(task["solvers"])}
    here = machine()
    return sorted(({**line, "machine": {**here, **line.get("machine", {})}} for line in lines),
                  key=lambda line: (line["instance"], order[line["solver"]]))


def attempts(task, spent):
    """Runs the task until it ends. Each time, one more solver that prevented this is left out. `spent` receives the
    seconds of each solver."""
    task = {**task, "limits": {**LIMITS, **task.get("limits", {})}, "ended": {}}
    while True:
        attempt = Attempt(task, spent)
        if attempt.is_done:
            return attempt.lines
        if not attempt.has_begun:
            told = attempt.errors.splitlines()[-1] if attempt.errors else attempt.cause[1]
            raise ProgramError(f"the process of the solvers cannot start: {told}")
        verdict, sentence = attempt.cause
        if attempt.trying is None or attempt.trying in task["ended"]:  # not the fault of one solver
            told = f"the task: {sentence}; {attempt.errors[-300:]}".rstrip("; ")
            return [{"problem": task["problem"], "start": task["start"], "solver": name, "instance": 0,
                     "verdict": "crashed", "claimed": told} for name in task["solvers"]]
        task = {**task, "ended": {**task["ended"], attempt.trying: (verdict, sentence)}}
