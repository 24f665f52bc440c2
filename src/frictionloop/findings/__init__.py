"""What a person should know of an answer, as values: findings, conditions, results, and the one way they are shown."""

from frictionloop.findings.catalogue import CATALOGUE, Entry, explain
from frictionloop.findings.finding import Condition, Finding
from frictionloop.findings.result import Result
from frictionloop.findings.shown import shown
