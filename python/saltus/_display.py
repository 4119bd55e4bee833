"""Results as tables and pictures: pandas, xarray, notebooks."""

import html

import numpy as np


def _columns(table, names=None):
    """One column per entry of x, u and z."""
    columns = {"t": table["t"]}
    for key in ("phase", "mode"):
        if key in table:
            columns[key] = np.asarray(table[key])
    for letter in ("x", "u", "z"):
        for i in range(table[letter].shape[1] if letter in table else 0):
            given = (names or {}).get(letter)
            columns[given[i] if given else f"{letter}{i}"] = table[letter][:, i]
    return columns


def to_pandas(self, samples_per_interval=1):
    """A pandas.DataFrame with one row per sample: t, phase or mode, states, inputs."""
    import pandas
    if hasattr(self, "recording"):
        self = self.recording
    if hasattr(self, "trajectory"):
        self = self.trajectory
    if hasattr(self, "state_names"):
        return pandas.DataFrame(_columns(self.samples(), {"x": self.state_names, "u": self.input_names}))
    table = self.samples(samples_per_interval)
    names = self.phases
    frame = pandas.DataFrame(_columns(table))
    frame["phase"] = [names[i] for i in table["phase"]]
    return frame


def to_xarray(self, samples_per_interval=1):
    """An xarray.Dataset with the dimension sample: t, states x, inputs u."""
    import xarray
    if hasattr(self, "recording"):
        self = self.recording
    if hasattr(self, "trajectory"):
        self = self.trajectory
    table = self.samples() if hasattr(self, "state_names") else self.samples(samples_per_interval)
    named = {"x": "state", "u": "input", "z": "algebraic"}
    data = {key: (("sample", named[key]) if key in named else ("sample",), np.asarray(value))
            for key, value in table.items() if key != "t"}
    return xarray.Dataset(data, coords={"t": ("sample", table["t"])})


def _polyline(t, y, width, height):
    low, high = np.nanmin(y), np.nanmax(y)
    span = (high - low) or 1.0
    length = (t[-1] - t[0]) or 1.0
    points = " ".join(f"{width * (a - t[0]) / length:.1f},{height * (1.0 - (b - low) / span):.1f}"
                      for a, b in zip(t, y) if np.isfinite(b))
    return f'<polyline points="{points}" fill="none" stroke="#1f77b4" stroke-width="1.5"/>'


def _pictures(columns):
    """A small picture per column."""
    width, height = 180, 60
    parts = []
    t = np.asarray(columns["t"], dtype=float)
    for name, values in columns.items():
        values = np.asarray(values)
        if name == "t" or values.dtype.kind != "f" or not np.isfinite(values).any():
            continue
        parts.append(
            f'<div style="display:inline-block;margin:4px"><svg width="{width}" height="{height}" '
            f'style="border:1px solid #ccc">{_polyline(t, values, width, height)}</svg><br><small>{html.escape(name)}: '
            f'{np.nanmin(values):.4g} to {np.nanmax(values):.4g}</small></div>')
    return "".join(parts)


def _solution(self):
    rows = "".join(f"<tr><td>{html.escape(phase)}</td><td>{html.escape(term)}</td><td>{value:.6g}</td></tr>"
                   for (phase, term), value in self.costs.items())
    text = (f"<p><b>{html.escape(str(self.status).split('.')[-1])}</b>: {html.escape(self.message)}</p>"
            f"<p>cost {self.cost:.8g}, {self.iterations} iterations, {self.seconds:.3g} s</p>"
            f"<table><tr><th>phase</th><th>cost</th><th>value</th></tr>{rows}</table>")
    return text if self.trajectory.empty else text + _pictures(_columns(self.trajectory.samples(4)))


def _log(self):
    names = {"x": self.recording.state_names, "u": self.recording.input_names}
    return (f"<p><b>{'ok' if self.ok() else 'not ok'}</b>: {html.escape(self.message)}</p>"
            f"{_pictures(_columns(self.recording.samples(), names))}")


def _page(self):
    return f"<pre>{html.escape(self.text())}</pre>"


def install(core):
    """Adds the methods to the classes of the extension."""
    for of_samples in (core.Trajectory, core.Solution, core.Recording, core.LoopLog):
        of_samples.to_pandas = to_pandas
        of_samples.to_xarray = to_xarray
    core.Solution._repr_html_ = _solution
    core.LoopLog._repr_html_ = _log
    core.ProblemCheck._repr_html_ = _page
    core.Explanation._repr_html_ = _page
