"""Experiments on friction: protocols, adaptive methods, sessions, simulated participants, analysis, export.

A protocol is a file. A session of it is a folder with one row per trial, which says what was asked, what was delivered
and whether it counts.

new  check  power             write a protocol, run it dry, see how many participants it takes
run  resume  amend  simulate  a session, one that was left, a trial that does not count, a whole study that is simulated
report  write_page  export    what sessions found, as an answer and as a page, and for other programs
"""

from __future__ import annotations

from frictionloop.quantities.optional_libraries import lazily

HOMES = {
    "adaptive_methods": "Psi Quest Staircase",
    "session_folder": "read_session read_trials",
    "lsl": "Streams",
    "level_handlers": "Adjustment ConstantStimuli Interleaved Walk",
    "participant_reach": "reaches",
    "simulated_participant": "Observer",
    "planning": "Power ProtocolCheck check power",
    "protocol": "NewProtocol Protocol new read_protocol",
    "psychometric": "fit",
    "respondent": "Keyboard Respondent",
    "resumable_session": "Ran amend resume run",
    "session_export": "Exported export",
    "study_run": "Study report simulate",
    "study_summary": "fits funnel groups pooled",
    ".report.psychophysics_page": "write_page",
}
__getattr__, __all__, __dir__ = lazily(__name__, HOMES)
