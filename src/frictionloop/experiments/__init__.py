"""Experiments on friction: protocols, adaptive methods, sessions, simulated participants, analysis, export.

A protocol is a file. A session of it is a folder with one row per trial, which says what was asked, what was delivered
and whether it counts.

new  check  power             write a protocol, run it dry, see how many participants it takes
run  resume  simulate         a session, a session that was left, a whole study with simulated participants
report  write_page  export    what sessions found, as an answer and as a page, and for other programs
"""

from __future__ import annotations

from frictionloop.quantities.lazily import lazily

HOMES = {
    "adaptive_methods": "Psi Quest Staircase",
    "folder": "read_session read_trials",
    "lsl": "Streams",
    "methods": "Adjustment ConstantStimuli Interleaved Walk",
    "own_reach": "reaches",
    "participant": "Observer",
    "planning": "Power ProtocolCheck check power",
    "protocol": "NewProtocol Protocol new read_protocol",
    "psychometric": "fit",
    "respondent": "Keyboard Respondent",
    "session_run": "Ran resume run",
    "session_export": "Exported export",
    "study": "Study report simulate",
    "study_summary": "fits funnel groups pooled",
    ".report.study_page": "write_page",
}
__getattr__ = lazily(__name__, HOMES)
__all__ = [name for names in HOMES.values() for name in names.split()]


def __dir__() -> list[str]:
    return sorted(__all__)
