"""Campaigns run outside continuous integration; what they found last is stored, and of which code."""

from __future__ import annotations


def test_every_campaign_is_stored(campaigns):
    """A new or renamed campaign fails here until `make soak` has run it; a summary tells which are of other code."""
    there, stored = campaigns
    assert [name for name in there if name not in stored] == []
    assert [name for name, found in stored.items() if found["outcome"] not in ("passed", "xfailed", "failed")] == []
