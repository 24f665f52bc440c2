"""The page and the schema are enough to write a client: one that is made of them alone runs a board."""

from __future__ import annotations

import ast
import importlib.util
import re
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import frictionloop as fl
from frictionloop.control.laws import BUILT_IN
from frictionloop.firmware.parameter_words import firmware_words
from frictionloop.quantities import flat_tuples
from frictionloop.quantities.protocol_schema import schema, schema_path, table_hash, word_count

SOURCE = Path(__file__).with_name("written_client.py")


@pytest.fixture
def written() -> Any:
    spec = importlib.util.spec_from_file_location("written_client", SOURCE)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def make(written: Any, page: str) -> Any:
    """Return what makes a client of a line."""
    text = schema_path().read_text(encoding="utf-8")
    return lambda line: written.Client(text, page, line.write, line.read, line.clock)


def test_it_knows_nothing_of_this_package() -> None:
    imported = set()
    for node in ast.walk(ast.parse(SOURCE.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            imported |= {name.name for name in node.names}
        if isinstance(node, ast.ImportFrom):
            imported.add(node.module)
    assert all(name.partition(".")[0] in sys.stdlib_module_names for name in imported)


def test_the_checks_of_the_page_are_what_they_say(written: Any, make: Any, boards: Any) -> None:
    client = make(boards.Line(boards.Board()))
    assert set(client.checks) == {"CRC-16", "CRC-32"}
    for how in client.checks.values():
        assert written.crc(b"123456789", how) == int(how["Of the ASCII text 123456789"], 16)
    assert client.table_hash() == table_hash()
    assert client.table_words() == word_count()


def test_it_runs_the_simulated_board(make: Any, boards: Any) -> None:
    board = boards.Firmware()
    client = make(boards.Line(board))
    table = firmware_words(fl.bench().evolve(fl.RETUNED)).tolist()
    points = np.rint(5000 + 1000 * np.sin(2 * np.pi * np.arange(500) / 500)).astype(int).tolist()
    client.run(table, points, 0.5)
    frames = [message for message in client.told if message["name"] == "telemetry"]
    assert [message for message in client.told if message["name"] == "fault"] == []
    assert all(1 <= len(message["values"]) // 8 <= client.number("samples in telemetry") for message in frames)
    rows = np.array([row for message in frames for row in np.reshape(message["values"], (-1, 8))])
    closed = rows[rows[:, 7] >> 2 & 3 == schema()["states"]["closed"]]
    assert len(closed) > 2400
    turns = (np.arange(len(closed)) + points.index(closed[0, 0])) % 500
    assert np.abs(closed[:, 0] - np.array(points)[turns]).max() <= 1
    assert closed[:, 3].max() > 0
    assert client.ask("heartbeat")["commits"] == 1
    assert client.ask("heartbeat")["state"] == schema()["states"]["idle"]


def test_it_is_told_that_it_speaks_another_version(make: Any, boards: Any) -> None:
    client = make(boards.Line(boards.Firmware()))
    answer = client.ask("hello", major=1, nonce=5)
    assert (answer["name"], answer["reason"]) == ("refused", schema()["refusals"]["wrong_version"])


@pytest.mark.parametrize("law", BUILT_IN, ids=lambda law: law.kind)
def test_the_gains_and_start_words_of_the_page_are_those_of_the_laws(law: Any, page: str) -> None:
    gains, start = ("".join(re.findall(rf"^\| {law.kind} \|(.*)\|$", page, re.M)[k : k + 1]) for k in (0, 1))
    assert re.findall(r"`([\w.]+)`", gains) == list(flat_tuples.names(law.gains))[:-2]
    assert re.findall(r"`([\w.]+)`", start) == list(flat_tuples.names(law.state))
