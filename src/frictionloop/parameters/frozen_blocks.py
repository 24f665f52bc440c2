"""What a System and the designs behind it have in common: blocks in a frozen whole, changed only by ``evolve``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Self

from pydantic import BaseModel, ValidationError

from frictionloop.parameters.block import Block
from frictionloop.parameters.refusals import MOST_NAMED, explain, known_names, refusal, registry_of
from frictionloop.quantities import FrictionloopError


class Description(Block):
    """A whole made of blocks."""

    def evolve(self, overrides: Mapping[str, Any] | None = None, **blocks: Any) -> Self:
        """Return a copy with some values replaced.

        Parameters
        ----------
        overrides : mapping
            Dotted paths to values in the unit their name ends with: ``{"controller.kp": 20.0}``. A whole block may be
            given: as a mapping of what changes in it, or as a block, ``{"setpoint": fl.Sine(offset_n=0.6)}``.

            A new ``kind`` keeps what describes the bench: of a controller its rate, delay and model, of a plate or a
            finger the values that both kinds have. A signal and the gains of a law start from the new kind's defaults.
        **blocks : mapping or block
            The same for whole blocks: ``evolve(controller={"kp": 20.0}, setpoint=fl.Sine(offset_n=0.6))``.

        Raises
        ------
        FrictionloopError
            For unknown paths, naming near ones, or a value outside its range.
        """
        overrides = self.resolved({**(overrides or {}), **blocks})
        # Blocks that no path enters stay as they are: sweeps evolve thousands of systems.
        tree = {name: getattr(self, name) for name in type(self).model_fields}
        for block in {path.split(".", 1)[0] for path in overrides} & tree.keys():
            if isinstance(tree[block], BaseModel):
                tree[block] = _values(tree[block])
        strangers: dict[str, Any] = {}
        for path, value in sorted(overrides.items(), key=_turn):
            _place(type(self), tree, path, value, strangers)
        if strangers:
            raise FrictionloopError(refusal(strangers, type(self), tree))
        return self.from_tree(tree)

    def resolved(self, overrides: Mapping[str, Any]) -> dict[str, Any]:
        """Return overrides with those that other values follow from in these values; there are none here."""
        return dict(overrides)

    @classmethod
    def from_tree(cls, tree: Mapping[str, Any], where: str = "") -> Self:
        """Return what a nested mapping describes; ``where`` (a file) is named in errors."""
        try:
            return cls.model_validate(tree)
        except ValidationError as error:
            raise FrictionloopError(where + explain(cls, error, tree)) from None


def flat(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return values by dotted names, also those in a block within a block."""
    found: dict[str, Any] = {}
    for name, value in changes.items():
        found |= {f"{name}.{key}": each for key, each in value.items()} if isinstance(value, Mapping) else {name: value}
    return found


def _values(block: BaseModel) -> dict[str, Any]:
    """Return ``block.model_dump()`` in a third of the time."""
    return {name: _values(value) if isinstance(value, BaseModel) else value for name, value in block.__dict__.items()}


def _turn(item: tuple[str, Any]) -> int:
    """Return when a value has its turn: a kind comes first, so that other values land in the block of that kind."""
    return 0 if item[0].rpartition(".")[2] == "kind" else 1


def _place(whole: type[Description], tree: dict[str, Any], path: str, value: Any, strangers: dict[str, Any]) -> None:
    """Put a value where its path leads; one that leads nowhere is kept among the strangers."""
    *parents, leaf = path.split(".")
    node: Any = tree
    for name in parents:
        if isinstance(node, dict) and isinstance(node.get(name), BaseModel):  # the default of a new kind
            node[name] = _values(node[name])
        node = node.get(name) if isinstance(node, dict) else None
    # A new kind may need a value that nothing has given yet: the path of a recording.
    many = len(strangers) > MOST_NAMED
    if not isinstance(node, dict) or (leaf not in node and (many or path not in known_names(whole, tree))):
        strangers[path] = value
    elif leaf == "kind" and len(parents) > 1:
        if value != node["kind"]:
            _change_inner(whole, tree, parents, value)
    elif leaf == "kind" and value != node["kind"]:
        _change_kind(whole, tree, parents[0], value)
    elif isinstance(value, Mapping) and isinstance(node.get(leaf), dict) and parents and _another(value, node[leaf]):
        node[leaf] = dict(value)
    elif isinstance(value, Mapping) and isinstance(node.get(leaf), dict):
        for name, inner in sorted(value.items(), key=_turn):
            _place(whole, tree, f"{path}.{name}", inner, strangers)
    else:
        node[leaf] = value.model_dump() if isinstance(value, BaseModel) else value


def _another(value: Mapping[str, Any], there: dict[str, Any]) -> bool:
    """Tell whether a mapping describes an inner block of another kind, of which nothing is kept."""
    return "kind" in value and value["kind"] != there.get("kind")


def _change_inner(whole: type[Description], tree: dict[str, Any], parents: list[str], kind: Any) -> None:
    """Swap a block inside a block, such as an effect, for one of another kind with its defaults."""
    model: Any = whole
    node: Any = tree
    for name in parents:
        kinds, node = registry_of(model, name), node[name]
        model = kinds[node["kind"]] if kinds else model.model_fields[name].annotation
    if kinds is None or not (isinstance(kind, str) and kind in kinds.names):
        raise FrictionloopError(f"{'.'.join(parents)}.kind = {kind!r} {_refusal(kinds, kind)}")
    node.clear()
    node.update(_defaults(kinds[kind]) | {"kind": kind})


def _change_kind(whole: type[Description], tree: dict[str, Any], block: str, kind: Any) -> None:
    """Swap a block for one of another kind, keeping what describes the bench."""
    kinds = registry_of(whole, block)
    model = kinds[kind] if kinds and isinstance(kind, str) and kind in kinds.names else None
    if kinds is None or model is None:
        raise FrictionloopError(f"{block}.kind = {kind!r} {_refusal(kinds, kind)}")
    tree[block] = _defaults(model) | kinds.carried(tree[block], model) | {"kind": kind}


def _refusal(kinds: Any, kind: Any) -> str:
    return kinds.refusal(kind) if kinds else "is unknown; it has none"


def _defaults(model: type[BaseModel]) -> dict[str, Any]:
    fields = {name: field for name, field in model.model_fields.items() if not field.is_required()}
    return {name: field.get_default(call_default_factory=True) for name, field in fields.items()}
