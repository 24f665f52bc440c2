"""The same loop in block-diagram simulators: Drake and PathSim (optional; skipped when not installed)."""

from __future__ import annotations

from math import exp
from typing import Any

import numpy as np

from paper import Array, Paper, draw
from solvers import Controller, derivative


class Sampled:
    """The sampled side: records f_a, runs the controller, returns what is held until the next sample."""

    def __init__(self, p: Paper, kp: float, ki: float, periods: int) -> None:
        t = np.arange(periods + 1) / p.rate_hz
        self.p, self.control, self.f_a = p, Controller(p, kp, ki), np.zeros(periods)
        self.f_r, self.d, self.noise = p.set_point(t), p.disturbance(t), np.append(draw(p, periods), 0.0)
        self.start = np.array([0.0, p.f0 + self.d[0]])

    def __call__(self, t: float, a: float, f_m: float) -> list[float]:
        k = round(t * self.p.rate_hz)
        if k < len(self.f_a):
            self.f_a[k] = self.p.f0 * exp(-self.p.tau * a * a) + self.d[k]
        return [self.control(self.f_r[k], f_m), self.noise[k]]


def drake(p: Paper, kp: float, ki: float, periods: int) -> Array:
    """Plant from symbolic expressions (run in C++), controller in Python, error-controlled Runge-Kutta of order 3."""
    from pydrake import symbolic as sym
    from pydrake.systems import framework
    from pydrake.systems.analysis import ApplySimulatorConfig, Simulator, SimulatorConfig
    from pydrake.systems.primitives import SymbolicVectorSystem

    sampled = Sampled(p, kp, ki, periods)

    class Pi(framework.LeafSystem):
        def __init__(self) -> None:
            super().__init__()
            self.measured = self.DeclareVectorInputPort("x", 2)
            held = self.DeclareDiscreteState(2)
            self.DeclareStateOutputPort("held", held)
            self.DeclarePeriodicDiscreteUpdateEvent(p.period_s, 0.0, self.update)

        def update(self, context: Any, state: Any) -> None:
            state.set_value(sampled(context.get_time(), *self.measured.Eval(context)))

    t, a, f_m, command, noise = (sym.Variable(name) for name in ("t", "a", "f_m", "command", "noise"))
    rates = derivative(t, [a, f_m], p, command, noise, sym)
    builder = framework.DiagramBuilder()
    plant = builder.AddSystem(
        SymbolicVectorSystem(time=t, state=[a, f_m], input=[command, noise], output=[a, f_m], dynamics=rates)
    )
    pi = builder.AddSystem(Pi())
    builder.Connect(plant.get_output_port(), pi.get_input_port())
    builder.Connect(pi.get_output_port(), plant.get_input_port())
    simulator = Simulator(builder.Build())
    config = SimulatorConfig(
        integration_scheme="runge_kutta3", accuracy=1e-6, use_error_control=True, max_step_size=p.period_s
    )
    ApplySimulatorConfig(config, simulator)
    plant.GetMyMutableContextFromRoot(simulator.get_mutable_context()).SetContinuousState(sampled.start)
    simulator.AdvanceTo((periods - 0.5) * p.period_s)
    return sampled.f_a


def pathsim(p: Paper, kp: float, ki: float, periods: int) -> Array:
    """Plant as an ODE block, controller in a scheduled event, adaptive Dormand-Prince 5(4)."""
    from pathsim import Connection, Simulation
    from pathsim.blocks import ODE, Constant
    from pathsim.events import Schedule
    from pathsim.solvers import RKDP54

    sampled = Sampled(p, kp, ki, periods)
    command, noise = Constant(0.0), Constant(0.0)
    plant = ODE(lambda x, u, t: np.array(derivative(t, x, p, u[0], u[1])), sampled.start)

    def sample(t: float) -> None:
        command.value, noise.value = sampled(t, *plant.engine.state)

    wires = [Connection(command, plant[0]), Connection(noise, plant[1])]
    events = [Schedule(t_start=0.0, t_period=p.period_s, func_act=sample)]
    simulation = Simulation(
        [command, noise, plant], wires, events, dt=p.period_s / 10, Solver=RKDP54, log=False,
        tolerance_lte_rel=1e-8, tolerance_lte_abs=1e-10,
    )  # fmt: skip
    simulation.run((periods - 0.5) * p.period_s)
    return sampled.f_a
