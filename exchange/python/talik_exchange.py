"""Talik's exchange from Python: a law of one's own answers mpm-driver, or a script drives rve-farm. numpy is all it needs.

A law (tension positive, SI; every array has a row per RVE of the chunk):

    import numpy as np, talik_exchange as talik

    class Elastic(talik.Law):
        answers = ("stress", "stiffness")
        def configure(self, setup):
            self.stress = setup.initial_stress.copy()                       # [rves, 3]: xx yy xy, Pa
            return {"stress": self.stress, "stiffness": np.full(setup.rves, 1e7)}
        def answer(self, batch):
            h = batch["displacement_gradient_increment"]                    # [rows, 4]: xx xy yx yy
            self.stress[batch.ids] += 1e7 * np.stack([h[:, 0], h[:, 3], 0.5 * (h[:, 1] + h[:, 2])], axis=1)
            return {"stress": self.stress[batch.ids], "stiffness": np.full(len(batch.ids), 1e7)}

    talik.serve("shm:mine", Elastic())          # beside: mpm-driver run scene.toml --exchange shm:mine

A driver:

    with talik.Driver("shm:mine") as farm:      # beside: rve-farm serve --exchange shm:mine
        start = farm.configure("spec.toml", rves=10)
        for step in range(1, 101):
            answer = farm.step(step, 1e-3, {"displacement_gradient_increment": h})

The library libtalik_exchange.so is looked for where TALIK_LIBRARY says, beside an installation, and in a build folder.
"""
import ctypes
import os
import sys
import traceback
from ctypes import CFUNCTYPE, POINTER, Structure, c_char_p, c_double, c_int, c_int32, c_size_t, c_uint32, c_uint64, c_void_p
from pathlib import Path

import numpy as np


class Error(RuntimeError):
    """What Talik reports, in one line; `code` is the exit code of its programs (1 failed, 2 bad input, 3 partner lost, 4 out of a resource)."""

    def __init__(self, text, code=1):
        super().__init__(text)
        self.code = code


class _Column(Structure):
    _fields_ = [("name", c_char_p), ("components", c_int32), ("unit", c_char_p), ("meaning", c_char_p)]


class _Setup(Structure):
    _fields_ = [("size", c_size_t), ("rves", c_size_t), ("initial_stress", POINTER(c_double)), ("thickness", c_double),
                ("grain_density", c_double), ("void_ratio", POINTER(c_double)), ("volume", POINTER(c_double))]


class _Batch(Structure):
    _fields_ = [("size", c_size_t), ("rows", c_size_t), ("ids", POINTER(c_uint32)), ("step", c_uint64), ("time_increment", c_double),
                ("request", POINTER(c_double)), ("answer", POINTER(c_double))]


_Configure = CFUNCTYPE(c_int, c_void_p, POINTER(_Setup), POINTER(c_double))
_Answer = CFUNCTYPE(c_int, c_void_p, POINTER(_Batch))
_Text = CFUNCTYPE(c_int, c_void_p, c_char_p)


class _Law(Structure):
    _fields_ = [("size", c_size_t), ("name", c_char_p), ("request", POINTER(_Column)), ("request_columns", c_size_t), ("answer", POINTER(_Column)),
                ("answer_columns", c_size_t), ("configure", _Configure), ("answer_batch", _Answer), ("command", _Text), ("checkpoint", _Text), ("restore", _Text)]


class _DriverOptions(Structure):
    _fields_ = [("size", c_size_t), ("program", c_char_p), ("request", POINTER(_Column)), ("request_columns", c_size_t), ("answer", POINTER(_Column)),
                ("answer_columns", c_size_t), ("attach_seconds", c_double), ("stall_seconds", c_double)]


def _load():
    here = Path(__file__).resolve().parent
    places = [Path(os.environ["TALIK_LIBRARY"])] if "TALIK_LIBRARY" in os.environ else []
    name = "libtalik_exchange.so"
    places += [here.parents[1] / "lib" / name, here.parents[2] / "lib" / name, here.parents[1] / "build" / "lib" / name, *sorted(here.parents[1].glob("lib/*/" + name)),
               *sorted(here.parents[2].glob("lib/*/" + name)), Path(name)]
    for place in places:
        if place.exists() or place == places[-1]:
            try:
                library = ctypes.CDLL(str(place))
                break
            except OSError as problem:
                raise Error(f"{name} cannot be loaded: {problem} (set TALIK_LIBRARY to its path)", 2) from None
    library.talik_last_error.restype = c_char_p
    library.talik_version.restype = c_char_p
    library.talik_known_column.restype = POINTER(_Column)
    library.talik_known_column.argtypes = [c_int]
    library.talik_set_error.argtypes = [c_char_p]
    library.talik_serve.argtypes = [c_char_p, POINTER(_Law), c_void_p, c_double]
    library.talik_driver_open.argtypes = [POINTER(c_void_p), c_char_p, POINTER(_DriverOptions)]
    library.talik_driver_configure.argtypes = [c_void_p, c_char_p, c_size_t, POINTER(c_double)]
    library.talik_driver_step.argtypes = [c_void_p, c_uint64, c_double, c_uint32, c_size_t, POINTER(c_uint32), POINTER(c_double), POINTER(c_double)]
    for call in ("command", "checkpoint", "restore"):
        getattr(library, "talik_driver_" + call).argtypes = [c_void_p, c_char_p]
    library.talik_driver_times.argtypes = [c_void_p, POINTER(c_double), POINTER(c_double)]
    library.talik_driver_bye.argtypes = [c_void_p]
    library.talik_driver_close.argtypes = [c_void_p]
    library.talik_driver_close.restype = None
    return library


_library = _load()
version = _library.talik_version().decode()


def _known():
    columns, index = {}, 0
    while (column := _library.talik_known_column(index)):
        columns[column.contents.name.decode()] = column.contents
        index += 1
    return columns


columns = _known()  # what Talik's own programs exchange, by name


def _checked(code):
    if code:
        raise Error(_library.talik_last_error().decode(), code)


def _column_array(names):
    for name in names:
        if name not in columns:
            raise Error(f"no column '{name}' (there are: {', '.join(columns)})", 2)
    return (_Column * len(names))(*[columns[name] for name in names])


def _doubles(pointer, *shape):
    return np.ctypeslib.as_array(pointer, shape=shape) if np.prod(shape) else np.empty(shape)


def _pointer(array, kind=c_double):
    return array.ctypes.data_as(POINTER(kind))


def _spread(names, flat):
    """[components, rows] as one array per column: [rows] or [rows, components]."""
    out, first = {}, 0
    for name in names:
        count = columns[name].components
        out[name] = flat[first] if count == 1 else flat[first:first + count].T
        first += count
    return out


def _gather(names, given, flat):
    first = 0
    for name in names:
        count = columns[name].components
        if name not in given:
            raise Error(f"the column '{name}' was announced and is not given", 2)
        flat[first:first + count] = np.asarray(given[name], dtype=float).reshape(-1, count).T
        first += count


class Setup:
    """What a law is told of the RVEs it answers for."""

    def __init__(self, raw):
        self.rves, self.thickness, self.grain_density = raw.rves, raw.thickness, raw.grain_density
        self.initial_stress = _doubles(raw.initial_stress, 3, raw.rves).T.copy()  # [rves, 3]: xx yy xy, Pa
        self.void_ratio = _doubles(raw.void_ratio, raw.rves).copy()
        self.volume = _doubles(raw.volume, raw.rves).copy()  # m^3: energies are of one such volume


class Batch:
    """A chunk of a step: batch["column"] is what is asked."""

    def __init__(self, raw, names):
        self.rows, self.step, self.time_increment = raw.rows, raw.step, raw.time_increment
        self.ids = np.ctypeslib.as_array(raw.ids, shape=(raw.rows,)).copy()
        components = sum(columns[name].components for name in names)
        self._values = _spread(names, _doubles(raw.request, components, raw.rows))

    def __getitem__(self, name):
        return self._values[name]


class Law:
    """To be derived from. An exception of a method ends the run; its text reaches the driver."""
    name = "a law in Python"
    requests = ("displacement_gradient_increment",)  # columns that it reads
    answers = ("stress", "stiffness")                # columns that it gives

    def configure(self, setup):
        """The answers before the first step: {column: array}."""
        raise NotImplementedError

    def answer(self, batch):
        """The answers of a chunk: {column: array}."""
        raise NotImplementedError

    def command(self, name):
        raise Error(f'the law knows no command "{name}"', 2)

    def checkpoint(self, path):
        """Writes its state to that file: here, all arrays among its attributes."""
        with open(path, "wb") as file:
            np.savez(file, **{key: value for key, value in vars(self).items() if isinstance(value, np.ndarray)})

    def restore(self, path):
        with np.load(path) as file:
            for key in file.files:
                setattr(self, key, file[key])


def serve(exchange, law, attach_seconds=60.0):
    """Answers the driver at that exchange until it says bye."""
    def guarded(body):
        def run(*arguments):
            try:
                body(*arguments)
                return 0
            except Error as problem:
                _library.talik_set_error(str(problem).encode())
                return problem.code
            except BaseException as problem:  # noqa: BLE001: nothing may be thrown through C, Ctrl-C neither
                traceback.print_exc(file=sys.stderr)
                _library.talik_set_error(f"{type(problem).__name__}: {problem}".encode())
                return 1
        return run

    answered = sum(columns[name].components for name in law.answers)

    def configure(_, raw, initial):
        setup = Setup(raw.contents)
        _gather(law.answers, law.configure(setup), _doubles(initial, answered, setup.rves))

    def answer(_, raw):
        batch = Batch(raw.contents, law.requests)
        _gather(law.answers, law.answer(batch), _doubles(raw.contents.answer, answered, batch.rows))

    request_columns, answer_columns = _column_array(law.requests), _column_array(law.answers)
    raw = _Law(ctypes.sizeof(_Law), law.name.encode(), request_columns, len(law.requests), answer_columns, len(law.answers), _Configure(guarded(configure)),
               _Answer(guarded(answer)), _Text(guarded(lambda _, name: law.command(name.decode()))),
               _Text(guarded(lambda _, path: law.checkpoint(path.decode()))), _Text(guarded(lambda _, path: law.restore(path.decode()))))
    _checked(_library.talik_serve(exchange.encode(), ctypes.byref(raw), None, attach_seconds))


class Driver:
    """Drives a farm: with Driver("shm:NAME", answers=("stress", "void_ratio")) as farm: ..."""

    def __init__(self, exchange, answers=("stress", "status"), requests=("displacement_gradient_increment",), attach_seconds=60.0, program="a driver in Python"):
        self.requests = tuple(requests)
        self.answers = tuple(answers) if "status" in answers else (*answers, "status")
        self._columns = (_column_array(self.requests), _column_array(self.answers))
        options = _DriverOptions(ctypes.sizeof(_DriverOptions), program.encode(), self._columns[0], len(self.requests), self._columns[1], len(self.answers), attach_seconds, 0.0)
        self._handle = c_void_p()
        self.rves = 0
        _checked(_library.talik_driver_open(ctypes.byref(self._handle), exchange.encode(), ctypes.byref(options)))

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        if kind is None:
            self.bye()
        self.close()

    def _components(self, names):
        return sum(columns[name].components for name in names)

    def configure(self, specification, rves=1):
        """RVEs from a TOML specification with [rve] tables; the answers before the first step."""
        initial = np.empty((self._components(self.answers), rves))
        _checked(_library.talik_driver_configure(self._handle, str(specification).encode(), rves, _pointer(initial)))
        self.rves = rves
        return _spread(self.answers, initial)

    def step(self, number, time_increment, request, ids=None, substeps=0):
        """One macro step; request: {column: [rows] or [rows, components]}; ids: None = all RVEs. A failed RVE is an Error."""
        ids = np.arange(self.rves, dtype=np.uint32) if ids is None else np.ascontiguousarray(ids, dtype=np.uint32)
        asked, answer = np.empty((self._components(self.requests), len(ids))), np.empty((self._components(self.answers), len(ids)))
        _gather(self.requests, request, asked)
        _checked(_library.talik_driver_step(self._handle, number, time_increment, substeps, len(ids), _pointer(ids, c_uint32), _pointer(asked), _pointer(answer)))
        out = _spread(self.answers, answer)
        if out["status"].any():
            rve = int(ids[np.flatnonzero(out["status"])[0]])
            raise Error(f"RVE {rve} failed in step {number} with status {out['status'].max():.0f} (take smaller steps)")
        return out

    def command(self, name):
        _checked(_library.talik_driver_command(self._handle, name.encode()))

    def checkpoint(self, path):
        _checked(_library.talik_driver_checkpoint(self._handle, str(Path(path).absolute()).encode()))

    def restore(self, path):
        _checked(_library.talik_driver_restore(self._handle, str(Path(path).absolute()).encode()))

    def times(self):
        """Seconds: what this side has waited, and what the farm has computed, copied and waited."""
        own, farm = np.empty(1), np.empty(3)
        _checked(_library.talik_driver_times(self._handle, _pointer(own), _pointer(farm)))
        return {"own_waiting": own[0], "computing": farm[0], "copying": farm[1], "waiting": farm[2]}

    def bye(self):
        _checked(_library.talik_driver_bye(self._handle))

    def close(self):
        if self._handle:
            _library.talik_driver_close(self._handle)
            self._handle = c_void_p()
