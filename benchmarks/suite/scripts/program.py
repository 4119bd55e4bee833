"""Our side of the suite: the process `saltus bench answer`, which answers requests in JSON, line by line."""

import json
import os
import subprocess


END_WAIT = 2.0  # s


class ProgramError(Exception):
    """An error of a request or of the program; the message is one sentence."""


class ProgramDied(ProgramError):
    """The program ended without an answer."""


def path_of_program():
    """Set by `saltus bench`, which runs these scripts."""
    program = os.environ.get("SALTUS_PROGRAM", "")
    if not os.access(program, os.X_OK):
        raise ProgramError("these scripts must be run by `saltus bench`, which gives them the path of the program")
    return program


class Program:
    def __init__(self):
        self.process = subprocess.Popen([path_of_program(), "bench", "answer"], text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)

    def ask(self, **request):
        try:
            self.process.stdin.write(json.dumps(request) + "\n")
            self.process.stdin.flush()
            line = self.process.stdout.readline()
        except BrokenPipeError:
            line = ""
        if not line:
            raise ProgramDied("the program ended without an answer")
        answer = json.loads(line)
        if "error" in answer:
            raise ProgramError(answer["error"])
        return answer

    def close(self):
        try:
            self.process.stdin.close()
        except BrokenPipeError:
            pass  # it has died
        try:
            self.process.wait(END_WAIT)
        except subprocess.TimeoutExpired:  # another process may have inherited the standard input
            self.process.kill()
            self.process.wait()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
