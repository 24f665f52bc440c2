"""One board and what can be asked of it."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np
import xarray as xr

from frictionloop.device.device_run import (
    KEPT_AS,
    STATES,
    Interrupted,
    Running,
    carried,
    check_decimation,
    check_folder,
    ending,
    free_path,
    number,
    recorded_in,
    rows_of,
)
from frictionloop.device.errors import DeviceError, Refused
from frictionloop.device.link import Link, identified
from frictionloop.device.parameter_table import Parameters, table_for, told_controller, tuned_words
from frictionloop.device.recording import ALL, CHANNELS, SCALES, Recorder, Recording
from frictionloop.device.transport import Pipe, opener
from frictionloop.device.waveform import checked, table, table_of, trigger_effect, upload_of, with_setpoint
from frictionloop.findings import Finding
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.loop.growing_file import DiskFull
from frictionloop.parameters import Source, System
from frictionloop.quantities import FrictionloopError, must_be
from frictionloop.quantities.class_help import Brief
from frictionloop.rendering.effect import Effect


def connect(address: str, system: System | None = None, seed: int = 0) -> Device:
    """Return the device at an address.

    Parameters
    ----------
    address : str
        ``"sim:"``, ``"emulated:image.elf"`` (or its folder), ``"serial:///dev/ttyACM0"`` or ``"tcp://host:port"``.
    system : System, optional
        The bench of a simulated or emulated board, `bench()` by default.
    seed : int
        Seed of its noise.

    Raises
    ------
    FrictionloopError
        For an address of no known form; DeviceError, which is one, when there is no such port, it is not ours to open
        or in use, nothing there speaks the protocol, or another version of it.
    """
    return Device(opener(address, system, seed), address)


class Device(metaclass=Brief):
    """A board behind a line; use it in a ``with`` statement, at whose end a plate that it switched on is switched off.

    While the loop is on, the host must be heard every 200 ms, which `run` and `stream` see to: between them the
    firmware ramps the plate down by itself.
    ``opening`` opens the line, again after it was unplugged; ``address`` is what errors call it.
    """

    def __init__(self, opening: Callable[[], Pipe], address: str = "device") -> None:
        self._opening, self.address = opening, address
        self._commanded = False  # who only looks leaves the mode alone: another host's run may be going on
        self._link = Link(opening())
        try:
            self.info = identified(self._link, self.address)
        except Exception:
            self._link.pipe.close()
            raise
        self.parameters = Parameters(self._link, self.info)
        """The parameters in force, by name, in their units."""
        given = self._link.pipe.system
        self.system = given if given is not None and self.parameters.hold(firmware_words(given)) else None
        """What the device was set up from, None where nobody knows."""
        self._tuned: dict[str, Any] = {}  # what waits of the controller
        self._others_wait = False

    def __enter__(self) -> Self:
        """Return the device."""
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, at: TracebackType | None) -> None:
        """As `close`."""
        self.close()

    def close(self) -> None:
        """Let go of the line; switch the plate off before, if this Device asked for a mode or a run."""
        try:
            if self._commanded and not self._link.is_others:
                self._link.ask("mode", state=STATES["idle"])
        except DeviceError:
            pass
        finally:
            self._link.pipe.close()

    def reconnect(self) -> None:
        """Open the line again after the device was unplugged."""
        self._link.pipe.close()
        self._link.reopened(self._opening())
        self.info = identified(self._link, self.address)
        self._link.resume()

    @property
    def sample_hz(self) -> float:
        """Most samples a second, of all channels, that a line carries: of every tick, or of every few."""
        return self.info.tick_hz / carried(1, self.info.tick_hz)

    @property
    def controller(self) -> Any:
        """The controller in force; where no System is known, the gains that the device tells (PI)."""
        return self.system.controller if self.system else told_controller(self.parameters, self.info)

    def set(self, name: str, value: Any) -> None:
        """Write a parameter, in its unit, into the copy that waits for `commit`.

        ``name`` is of the device's table (``"drive.ceiling_um"``) or of a System's controller (``"controller.kp"``).
        Whether such gains hold is not looked at; `frictionloop.device.configure` asks the analysis.
        """
        if not name.startswith("controller."):
            self.parameters.set(name, value)
            self._others_wait = True
            return
        tuned = {**self._tuned, name: value}
        base = self.system or told_controller(self.parameters, self.info)
        for word, words in tuned_words(base, tuned, self.info).items():
            self.parameters.put(word, words)
        self._tuned = tuned

    def commit(self) -> None:
        """Put the parameters that wait in force, checked as a whole."""
        system = None if self.system is None or self._others_wait else self.system.evolve(self._tuned)
        self._tuned, self._others_wait = {}, False
        self.parameters.commit()
        self.system = system

    def upload(self, system: System) -> None:
        """Write the whole parameter table from a System and put it in force; refused where it does not fit."""
        for _ in self.uploading(system):
            pass

    def uploading(self, system: System) -> Iterator[None]:
        """As `upload`, with a pause after each frame, for who listens to the device meanwhile."""
        self._tuned, self._others_wait = {}, False
        yield from self.parameters.writing(table_for(system, self.info))
        self.parameters.commit()
        self.system = system

    def mode(self, state: str) -> None:
        """Ask for a state of the loop: ``"idle"``, ``"open"`` (lookup alone) or ``"closed"``."""
        if state not in STATES or state == "fault":
            raise must_be("mode", state, "idle, open or closed")
        self._commanded = True
        self._link.ask("mode", state=STATES[state])

    def clear(self) -> None:
        """Clear a fault; refused while its cause lasts."""
        self._link.ask("clear")

    def statistics(self) -> dict[str, float]:
        """Return what the device has counted since reset; ``longest_us`` is its longest tick."""
        counted = {name: float(value) for name, value in self._link.ask("statistics").fields.items()}
        return counted | {"longest_us": counted["longest_us"] / 256}

    def clock(self) -> tuple[float, float, float]:
        """Return the device's time by its ticks, the host's time between asking and hearing, the round trip, in s."""
        asked_s = self._link.pipe.clock()
        tick = self._link.ask("heartbeat")["tick"]
        heard_s = self._link.pipe.clock()
        return tick / self.info.tick_hz, 0.5 * (asked_s + heard_s), heard_s - asked_s

    def play(
        self,
        force_n: Any,
        *,
        spacing_s: float | None = None,
        spacing_m: float | None = None,
        start_m: float = 0.0,
        loop: bool = False,
    ) -> tuple[Finding, ...]:
        """Play an effect, or set-points at even times or places (`table` in `waveform`), in place of what plays.

        ``force_n`` is an effect, such as ``fl.rendering.find("bump")``, an `EffectSource` with a track, or forces in N.
        Returns what of an effect is sampled more coarsely than in the simulator. Raises
        `FrictionloopError` for more steps, triggers or values than a device has room for.
        """
        played = upload_of(force_n, self.system, self.info.waveform, self.info.tick_hz)
        if played is None:
            table(force_n, self.info.waveform, self.info.tick_hz, spacing_s, spacing_m, start_m, loop).send(self._link)
            return ()
        if spacing_s is not None or spacing_m is not None:
            raise must_be("spacing", spacing_s or spacing_m, "None for an effect")
        played.send(self._link)
        return played.tables.findings

    def trigger(self, number: int | None = None) -> None:
        """Change over trigger 0 to 3 of the effect that plays; without a number its first waves begin again."""
        trigger_effect(self._link, number)

    def stream(self, duration_s: float, decimation: int = 50) -> Iterator[dict[str, np.ndarray]]:
        """Yield telemetry as it comes, for so long: ``tick`` and the channels, in their units."""
        number("duration_s", duration_s)
        check_decimation(decimation)
        since = self._link.listen(decimation, ALL)["tick"]
        until = self._link.pipe.clock() + duration_s
        try:
            while (left := until - self._link.pipe.clock()) > 0:
                for message in self._link.poll(left):
                    if message.name == "telemetry" and (message["decimation"], message["mask"]) == (decimation, ALL):
                        samples = message["values"].reshape(-1, len(CHANNELS)) * SCALES
                        ticks = message["tick"] + decimation * np.arange(len(samples))
                        past = (ticks - since) % 2**32
                        new = (past > 0) & (past < 2**31)  # what was still on its way is of an earlier run
                        if new.any():
                            yield {"tick": ticks[new], **dict(zip(CHANNELS, samples[new].T, strict=True))}
        finally:
            with suppress(Refused):  # the host whose loop is on has asked for other telemetry meanwhile
                self._link.ask("stream", decimation=0, mask=0)

    def run(
        self,
        setpoint: Source | Effect | float | np.ndarray,
        duration_s: float,
        *,
        path: str | os.PathLike[str] | None = None,
        state: str = "closed",
        decimation: int = 1,
        progress: Callable[[int], Any] | None = None,
        live: Callable[[dict[str, float]], Any] | None = None,
    ) -> xr.Dataset:
        """Run the loop on the device and return what it recorded, in the form of `simulate`.

        Parameters
        ----------
        setpoint : source, effect, float or array
            A source as in a System (``fl.Sine(...)``), an effect, a force in N that is held, or forces in N at
            every tick. Refused where `info.waveform` points miss forces over time by more than 2 mN rms.
        duration_s : float
            Duration in s, rounded up to whole samples.
        path : path, optional
            File that keeps the run, also when it ends early; without it ``interrupted-run.h5`` keeps what ends early
            (or ``-2``, ``-3``, ...), if a sample was recorded.
        state : str
            ``"closed"``, or ``"open"`` for the lookup alone.
        decimation : int
            Ticks per sample, 1 or more; more than asked for where a line would not carry as many samples.
        progress, live : callable, optional
            Called with the number of samples so far; with the newest, channels by name and ``elapsed_s``.

        Returns
        -------
        xarray.Dataset
            Over ``time``, from the first sample in that state. Samples that were lost are NaN and not ``scored``; of
            the others those that `counted` keeps are. The attributes count what was lost (``lost_samples``,
            ``gaps``), and say in ``ended`` why the run ended.

        Raises
        ------
        FrictionloopError
            For a set-point or duration that does not fit; `Interrupted` when the device faults, is gone, or is changed.
        KeyboardInterrupt
            At Ctrl-C, SIGTERM or SIGHUP, with the file named as well.
        """
        check_decimation(decimation)
        decimation = carried(decimation, self.info.tick_hz)
        rows = rows_of(duration_s, decimation, self.info.tick_hz)
        if state not in ("open", "closed"):
            raise must_be("state", state, "open or closed")
        check_folder(path)
        effect = upload_of(setpoint, self.system, self.info.waveform, self.info.tick_hz)
        asked = effect.source if effect else checked(setpoint)
        played = effect or table_of(asked, duration_s, self.info.waveform, self.info.tick_hz)
        played.send(self._link)
        recorder = Recorder(rows, decimation, STATES[state], self.info.tick_hz)
        running = Running(self._link, self._opening, recorder)
        device = {"board": self.info.board, "revision": self.info.revision, "serial": self.info.serial}
        attrs = {"setpoint_error_n": played.error_n, **device}
        recording = Recording(path or f"{KEPT_AS}.h5", recorder, self._link, with_setpoint(self.system, asked), attrs)
        before = self._counts()
        ended: FrictionloopError | KeyboardInterrupt | None = None
        self._commanded = True
        with ending() as signals:
            try:
                running.start()
                try:
                    running.go(recording.keep, progress, live)
                except (DeviceError, DiskFull, KeyboardInterrupt) as end:
                    ended = end
            except BaseException:
                recording.spool.drop()
                raise
            finally:
                signals.hold()
                running.stop()  # before all else: nobody keeps the heart beating while the file is finished
            counts = {name: now - before[name] for name, now in self._counts().items()}
            found: dict[str, Any] = {**counts, "reconnects": running.reconnects}
            found["ended"] = "complete" if ended is None else str(ended) or type(ended).__name__
            if ended is None:
                return recording.finish(rows, found, path)
            kept = Path(path or free_path()) if path or recorder.reached else None
            run = recording.finish(recorder.reached, found, kept)
        if isinstance(ended, KeyboardInterrupt):
            raise KeyboardInterrupt(recorded_in(recording.recorded, kept)) from None
        raise Interrupted(ended, run, kept, recording.recorded) from None

    def _counts(self) -> dict[str, int]:
        decoder = self._link.decoder
        return {
            "broken_frames": decoder.broken,
            "missed_frames": decoder.missed,
            "repeated_frames": decoder.repeated,
        }
