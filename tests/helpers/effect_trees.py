"""Random effects: every kind, mixed and placed in every way, for hypothesis."""

from hypothesis import strategies as st

import frictionloop as fl

R = fl.rendering
forces = st.floats(-1.0, 1.0)
ways = st.floats(0.3, 60.0)


def wave():
    values = st.lists(forces, min_size=2, max_size=6).map(tuple)
    return st.builds(R.Wave, values_n=values, rate_hz=st.floats(5.0, 500.0), loops=st.booleans())


LEAVES = st.one_of(
    st.builds(R.Constant, level_n=forces),
    st.builds(R.Gradient, from_n=forces, to_n=forces, length_mm=ways),
    st.builds(R.Edge, from_n=forces, to_n=forces, width_mm=ways),
    st.builds(
        R.Grating, shape=st.sampled_from(["sine", "square", "triangle"]), offset_n=forces, spacing_mm=ways,
        amplitude_n=st.floats(0.0, 1.0),
    ),
    st.builds(R.Chirp, from_mm=st.floats(4.0, 10.0), to_mm=st.floats(0.5, 3.0)),
    st.builds(R.Ridge, height_mm=st.floats(-1.0, 1.0), width_mm=ways),
    st.builds(R.Detents, spacing_mm=ways),
    st.builds(R.Texture, seed=st.integers(0, 100), rms_n=st.floats(0.0, 0.2)),
    st.builds(R.Dots),
    st.builds(R.Viscous, per_speed_n_s_m=st.floats(0.0, 5.0)),
    st.builds(
        R.Map, values_n=st.lists(forces, min_size=2, max_size=9).map(tuple), pitch_mm=ways, start_mm=forces,
        between=st.sampled_from(["linear", "nearest"]), beyond=st.sampled_from(["hold", "repeat"]),
    ),
    st.builds(R.Map, values_n=st.just(((0.1, 0.2, 0.5), (0.3, 0.8, 0.2))), pitch_mm=ways),
    st.builds(R.Relief, height=st.builds(R.Grating, spacing_mm=ways)),
    st.builds(R.Resynthesis, seed=st.integers(0, 100), offset_n=forces),
    wave(),
)  # fmt: skip


def triggers(inner):
    def pair(on, off):
        return st.tuples(st.just(on), st.just(off), st.floats(0.1, 1.0), st.floats(0.1, 1.0)).filter(
            lambda p: p[2] != p[3]
        )

    def made(names, then, starts, dead_s):
        on, off, high, low = names
        return R.Trigger(**{on: high, off: low}, then=then, starts=starts, dead_s=dead_s)

    conditions = st.one_of(pair("on_load_n", "off_load_n"), pair("on_speed_mm_s", "off_speed_mm_s"))
    return st.builds(made, conditions, inner, st.one_of(st.none(), wave()), st.floats(0.001, 0.1))


def grown(inner):
    return st.one_of(
        st.builds(lambda a, b: a + b, inner, inner),
        st.builds(lambda a, b: a * b, inner, inner),
        st.builds(lambda a, b: a.max(b), inner, inner),
        st.builds(lambda a, b, c: a.mask(b, c), inner, inner, inner),
        st.builds(lambda a, x, y: a.at(x, y), inner, st.floats(-20, 20), st.floats(-5, 5)),
        st.builds(lambda a, angle: a.rotate(angle), inner, st.floats(-90, 90)),
        st.builds(lambda a, f, s: a.scale(f, s), inner, forces, st.floats(0.2, 4.0)),
        st.builds(lambda a, every: a.repeat(every), inner, ways),
        st.builds(lambda a, b: R.Directed(forth=a, back=b), inner, inner),
        triggers(inner),
    )


TREES = st.recursive(LEAVES, grown, max_leaves=5)
